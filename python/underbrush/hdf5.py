"""HDF5: reaches in the layout of robomimic's data sets, and logs of other robots as CSV for ``underbrush import``.

    python -m underbrush.hdf5 export my-set reach.parquet --out reaches.hdf5
    python -m underbrush.hdf5 csv log.h5 --forces "data/*/skin" --times "data/*/t" --category label --out log.csv

Needs h5py: ``pip install 'underbrush[hdf5]'``.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import os
import re
import sys
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from . import _core, _export
from ._errors import InputError

# Choice: a window of some seconds, as learners read it, touches one or two chunks.
_FRAMES_PER_CHUNK = 256
# One of this many demonstrations is in ``mask/valid``.
_VALID_PERIOD = 10
_PARTS = ("train", "valid")


def _h5py() -> Any:
    try:
        import h5py
    except ImportError as error:
        raise ImportError("underbrush.hdf5 needs h5py: pip install 'underbrush[hdf5]'") from error
    return h5py


def _tables(reach: _core.Reach) -> dict[str, Any]:
    """The tables of a demonstration, by name."""
    column = reach.column
    state, velocity, tip = column("observation.state"), column("observation.velocity"), column("observation.tip_pose")
    rewards, dones = np.zeros(len(reach)), np.zeros(len(reach))
    for goal in reach.goals:
        if goal["outcome"] == "reached" and len(reach) > 0:
            # The frame at its end has the next goal already.
            rewards[np.searchsorted(reach.time_s, goal["end_time_s"]) - 1] = 1
    dones[-1:] = 1
    tables = {
        "actions": column("action"),
        "states": np.hstack([state, velocity]),
        "rewards": rewards,
        "dones": dones,
        "obs/joint_pos": state,
        "obs/joint_vel": velocity,
        "obs/joint_torque": column("observation.torque"),
        "obs/eef_pos": tip[:, :3],
        "obs/eef_quat": tip[:, 3:],
        "obs/goal_pos": column("goal_position"),
    }
    for patch in reach.skin.patches:
        tables[f"obs/tactile_{patch}"] = reach.sensed_force_n(patch, dtype="float64")
    return tables


def export(
    reaches: _core.Reach | _core.Dataset | Iterable[_core.Reach], path: str | os.PathLike[str], *, force: bool = False
) -> None:
    """Write reaches to an HDF5 file in the layout of robomimic's data sets, which ``docs/exchange.md`` describes.

    Each reach is a demonstration. Every tenth is in ``mask/valid`` (of two to nine, the last), the others are in
    ``mask/train``; those of a scene are in ``mask/SCENE``. The file gets its name when it is complete.

    Parameters
    ----------
    reaches : Reach, Dataset or iterable of Reach
        They are read one by one.
    path : path
        The file to write.
    force : bool
        Overwrite a file that exists.

    Raises
    ------
    InputError
        If the file exists and ``force`` is not set.
    """
    h5py = _h5py()
    scenes: list[str] = []
    frames = 0
    files: list[Any] = []
    # Ctrl-C is raised in the main thread only, so it does not make HDF5 fail in this one.
    with ThreadPoolExecutor(1) as writer:
        # The thread must run before there is anything to close.
        writer.submit(int).result()
        with _export.whole(Path(path), force) as temporary:
            disk = _Disk(temporary, "r+")
            with io.BufferedRandom(disk) as buffer:
                try:
                    writer.submit(lambda: files.append(h5py.File(buffer, "w"))).result()
                    for number, reach in enumerate(_export.each(reaches)):
                        writer.submit(_add, files[0], number, reach).result()
                        disk.check()
                        scenes.append(reach.scene)
                        frames += len(reach)
                    writer.submit(_describe, files[0], scenes, frames).result()
                finally:
                    writer.submit(lambda: [file.close() for file in files]).result()
            disk.check()


class _Disk(io.FileIO):
    """A file that keeps its first error for ``check``: the whole process crashes if HDF5 cannot write, as on a full disk."""

    error: OSError | None = None

    def write(self, content: Any) -> int:
        try:
            return super().write(content)
        except OSError as error:
            self.error = self.error or error
            return len(content)

    def truncate(self, size: int | None = None) -> int:
        try:
            return super().truncate(size)
        except OSError as error:
            self.error = self.error or error
            return size or 0

    def check(self) -> None:
        if self.error:
            raise self.error


def _add(file: Any, number: int, reach: _core.Reach) -> None:
    """Adds a demonstration."""
    demonstration = file.create_group(f"data/demo_{number}")
    seed, index = reach.seed_and_index
    demonstration.attrs["num_samples"] = len(reach)
    demonstration.attrs["scene"] = reach.scene
    demonstration.attrs["seed"] = np.uint64(seed)
    demonstration.attrs["reach_index"] = np.uint64(index)
    demonstration.attrs["controller"] = reach.controller
    demonstration.attrs["outcome"] = reach.outcome
    for name, table in _tables(reach).items():
        # An empty table, such as that of a patch without taxels, has no chunks.
        chunked: dict[str, Any] = {}
        if table.size > 0:
            chunks = (min(_FRAMES_PER_CHUNK, len(table)), *table.shape[1:])
            chunked = {"chunks": chunks, "shuffle": True, "compression": "gzip"}
        demonstration.create_dataset(name, data=np.asarray(table, dtype="f8"), **chunked)


def _describe(file: Any, scenes: list[str], frames: int) -> None:
    """Adds what is about all demonstrations."""
    data = file.require_group("data")
    data.attrs["total"] = frames
    # robomimic requires a description of the environment, although it cannot make this one. 2 is its code for Gym.
    data.attrs["env_args"] = json.dumps({"env_name": "underbrush", "type": 2, "env_kwargs": {}})
    for mask, numbers in _masks(scenes).items():
        names = [f"demo_{number}".encode() for number in numbers]
        file.create_dataset(f"mask/{mask}", data=np.array(names))


def _masks(scenes: list[str]) -> dict[str, list[int]]:
    """The numbers of the demonstrations in each mask."""
    last = len(scenes) - 1
    few = 2 <= len(scenes) < _VALID_PERIOD
    masks: dict[str, list[int]] = {}
    for number, scene in enumerate(scenes):
        valid = number == last if few else number % _VALID_PERIOD == _VALID_PERIOD - 1
        # A scene may have the name of a part.
        for mask in (_PARTS[valid], f"{scene}-scene" if scene in _PARTS else scene):
            masks.setdefault(mask, []).append(number)
    return masks


def csv_of(
    path: str | os.PathLike[str],
    out: str | os.PathLike[str],
    forces: str,
    *,
    times: str | None = None,
    category: str | None = None,
    channels: Mapping[str, str] | None = None,
    force: bool = False,
) -> int:
    """Write the forces in an HDF5 file as CSV, which ``underbrush import`` reads with a mapping.

    The columns are ``reach``, ``time`` (if ``times`` is given), ``category`` (if given), and ``force_0``, ``force_1``, …
    for the taxels, then those of the channels: their name for a single number, or else ``NAME_0``, ``NAME_1``, …. Numbers come
    back the same.

    Parameters
    ----------
    path, out : path
        The HDF5 file, and the CSV file to write.
    forces : str
        Path of the dataset of forces, frames × taxels or frames. With ``*`` in place of a group's name, each group that
        has this dataset is a reach, in the order of the numbers at the end of their names.
    times : str, optional
        Path of the dataset of times, also with ``*``.
    category : str, optional
        Name of a text attribute of the reach's group.
    channels : dict of str to str, optional
        Further columns by their names: paths of datasets with as many frames, also with ``*``.
    force : bool
        Overwrite a file that exists.

    Returns
    -------
    int
        The number of reaches.

    Raises
    ------
    InputError
        If something is not in the file, or has another shape or type, or if ``out`` exists and ``force`` is not set.
    """
    h5py = _h5py()
    given = [name for name, own in (("time", times), ("category", category)) if own is not None]
    wanted = {"force": forces} | dict(channels or {})
    if set(channels or {}) & {"reach", "time", "category", "force"}:
        raise _fault(path, "channels", ", ".join(channels or {}), "names other than reach, time, category and force")
    with _opened(h5py, path) as file, _export.whole(Path(out), force, path) as temporary:
        with open(temporary, "w", newline="", encoding="utf-8") as text:
            rows = csv.writer(text)
            groups = _groups(file, path, forces)
            sizes: dict[str, int] = {}
            for number, group in enumerate(groups):
                tables = {name: _numbers(h5py, file, path, own, group) for name, own in wanted.items()}
                tables = {name: np.atleast_2d(own.T).T for name, own in tables.items()}
                frames = len(tables["force"])
                if not sizes:
                    sizes = {name: table.shape[1] for name, table in tables.items()}
                    rows.writerow(["reach", *given, *_export.column_names(sizes)])
                for name, table in tables.items():
                    if table.shape != (frames, sizes[name]):
                        found, allowed = f"{table.shape} numbers in {group}", f"({frames}, {sizes[name]}), as in the first reach"
                        raise _fault(path, wanted[name], found, allowed)
                columns: list[list[Any]] = [[number] * frames]
                if times is not None:
                    own = _numbers(h5py, file, path, times, group)
                    if own.shape != (frames,):
                        raise _fault(path, times, f"shape {own.shape}", f"({frames},), one time for each frame")
                    columns.append(own.tolist())
                if category is not None:
                    columns.append([_attribute(file, path, forces, category, group)] * frames)
                rows.writerows(zip(*columns, *(column for table in tables.values() for column in table.T.tolist()), strict=True))
    return len(groups)


def _fault(path: object, field: str, found: str, allowed: str) -> InputError:
    remedy = "name another path; `h5ls -r` lists them"
    message = f"{path}: {field}: found {found}; allowed: {allowed}; {remedy}"
    return InputError(message, file=str(path), field=field, found=found, allowed=allowed, remedy=remedy)


def _opened(h5py: Any, path: str | os.PathLike[str]) -> Any:
    try:
        return h5py.File(path, "r")
    except OSError as error:
        raise _fault(path, "file", str(error), "a readable HDF5 file") from error


def _groups(file: Any, path: object, pattern: str) -> list[str]:
    """The names that ``*`` stands for, those that end in a number in its order; one empty name without ``*``."""
    parent, star, rest = pattern.partition("*")
    if not star:
        return [""]
    group = file.get(parent.strip("/") or "/")
    names = [name for name in group or () if f"{name}{rest}" in group]
    if not names:
        raise _fault(path, pattern, "no such dataset", "the path of a dataset")

    def order(name: str) -> tuple[int, str]:
        number = re.search(r"\d+$", name)
        return (int(number[0]) if number else -1, name)

    return sorted(names, key=order)


def _numbers(h5py: Any, file: Any, path: object, pattern: str, group: str) -> Any:
    """A dataset of numbers in one or two dimensions."""
    name = pattern.replace("*", group)
    data = file.get(name)
    if not isinstance(data, h5py.Dataset):
        raise _fault(path, pattern, f"{name!r}, which is no dataset", "the path of a dataset")
    if data.ndim not in (1, 2) or data.dtype.kind not in "fiu":
        raise _fault(path, pattern, f"{data.dtype} of shape {data.shape}", "numbers of shape (frames,) or (frames, taxels)")
    return data[()]


def _attribute(file: Any, path: object, pattern: str, name: str, group: str) -> str:
    """A text attribute of the group that ``*`` stands for, or of the file."""
    parent, star, _ = pattern.partition("*")
    holder = file[f"{parent}{group}"] if star else file
    value = holder.attrs.get(name)
    if not isinstance(value, (str, bytes)):
        raise _fault(path, "category", repr(name), f"a text attribute: {', '.join(sorted(holder.attrs))}")
    return value.decode() if isinstance(value, bytes) else value


def main(arguments: list[str] | None = None) -> int:
    """The command line: ``python -m underbrush.hdf5 --help``."""
    parser = argparse.ArgumentParser(prog="python -m underbrush.hdf5", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    _export.export_parser(commands, "write reaches in the layout of robomimic's data sets", "HDF5 file to write")
    log = commands.add_parser("csv", help="write the forces of a log as CSV, for `underbrush import`")
    log.add_argument("log", type=Path, help="HDF5 file")
    log.add_argument("--forces", required=True, help="dataset of frames × taxels; * stands for the group of each reach")
    log.add_argument("--times", help="dataset of the times")
    log.add_argument("--category", help="text attribute of the reach's group")
    channel = "a further column: a dataset with as many frames; may be given more than once"
    log.add_argument("--channel", action="append", default=[], metavar="NAME=DATASET", help=channel)
    _export.output_options(log, "CSV file to write")
    options = parser.parse_args(arguments)

    def run() -> dict[str, int]:
        if options.command == "export":
            count, reaches = _export.reaches_in(options.data, options.out)
            export(reaches, options.out, force=options.force)
            return {"reaches": count}
        channels = dict(text.partition("=")[::2] for text in options.channel)
        if len(channels) < len(options.channel) or not all(name and own for name, own in channels.items()):
            raise _fault("--channel", "text", repr(options.channel), "NAME=DATASET, each NAME once")
        given = {"times": options.times, "category": options.category, "channels": channels, "force": options.force}
        return {"reaches": csv_of(options.log, options.out, options.forces, **given)}

    return _export.status(run, options)


if __name__ == "__main__":
    sys.exit(main())
