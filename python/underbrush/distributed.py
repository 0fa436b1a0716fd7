"""Data sets and campaigns on many machines with Ray.

A set is divided into parts that depend on nothing but the call and the version of the package. Each part is one Ray
task, which writes to storage that all nodes share and returns only a manifest. A part may be run twice, for example
after a node was lost. Both runs give the same bytes, and the second to finish is thrown away. The driver then merges
the parts into the set that one process would have made, byte for byte. Campaigns of an experiment are also tasks: each
leaves its result in the folder of the run, and the driver takes it from there.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import time
import uuid
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypedDict, cast

from . import _core
from ._benchmark import Track, entry, lasting
from ._benchmark import benchmark as _benchmark
from ._errors import InputError, whole
from ._generate import scene_list
from ._progress import Bar, Progress
from ._study import check_campaigns
from ._study import reproduce as _reproduce
from ._types import ControllerLike, SceneLike


def _ray() -> Any:
    """The module of Ray, which is imported only when something is run."""
    try:
        import ray
    except ImportError as error:
        raise ImportError("underbrush.distributed needs Ray: pip install 'underbrush[ray]'") from error
    return ray


class Manifest(TypedDict):
    """What a task returns: how many reaches or campaigns it has done, where it ran, and for how long."""

    done: int
    node: str
    seconds: float


def generate(
    scenes: SceneLike | Sequence[SceneLike],
    reaches: int,
    out: str | os.PathLike[str],
    *,
    parts: int | None = None,
    seed: int = 0,
    controller: ControllerLike | None = None,
    verdicts: str | os.PathLike[str] | None = None,
    address: str | None = None,
    retries: int = 3,
    keep_parts: bool = False,
    progress: Progress | bool = True,
) -> _core.Dataset:
    """Simulate many reaches on the nodes of a Ray cluster, and write them as one data set.

    The same scenes, seed and version give the same bytes as :func:`underbrush.generate`, however the parts were spread
    over nodes. Parts that fail because of a lost node or an I/O error are tried again; other errors end the call at
    once. Finished parts are kept, and the same call continues from them. If the set is finished already, it is opened.

    Parameters
    ----------
    scenes : Scene, name or path, or a list of them
        What the arm reaches through. Files are read here and sent to the tasks.
    reaches : int
        Number of reaches of each scene.
    out : path
        The folder to write, on storage that all nodes see under this path. The parts are written to ``<out>.parts`` beside it.
    parts : int, optional
        Number of tasks; by default four for each processor of the cluster, and at most one for each reach, or as many as
        there were before the call was interrupted.
    seed : int
        Decides all random draws.
    controller : str, callable or class, optional
        As for :func:`underbrush.generate`. It is sent to the tasks. Parts of a controller of your own are found again by
        its name, so give it another name when you have changed it.
    verdicts : path, optional
        As for :func:`underbrush.generate`. A touch model must be on storage that all nodes see.
    address : str, optional
        Address of the cluster, such as ``"auto"``; by default the cluster that this process is connected to, or else a
        local one.
    retries : int
        How often a part is tried again after its node was lost or an I/O error occurred.
    keep_parts : bool
        Keep ``<out>.parts`` after the merge.
    progress : bool or callable
        ``True`` shows one bar for all nodes on a terminal; a function is called as ``progress(done, total, text)``.

    Returns
    -------
    Dataset

    Raises
    ------
    InputError
        If a scene, an option or a folder is bad, or if a folder holds the set or parts of another call.
    OSError
        If a file cannot be read or written, in a part also after all retries; mostly a :class:`StorageError`.
    ImportError
        If Ray is not installed and the set is not finished.
    """
    listed = [scene if isinstance(scene, _core.Scene) else _core.Scene(scene) for scene in scene_list(scenes)]
    options: dict[str, Any] = {
        "seed": seed,
        "controller": controller,
        "verdicts": lasting(verdicts),
    }
    if _is_finished(Path(out)):
        # Nothing is simulated: this opens the set, or says in what another set differs or what is wrong with it.
        return cast(_core.Dataset, _core.generate(listed, reaches, Path(out), resume=True, **options))
    _connect(address)
    make = partial(_generate_part, listed, reaches, **options)
    call = _call(
        scenes=[[scene.name, _hash(scene.text.encode())] for scene in listed],
        reaches=int(reaches),
        seed=int(seed),
        controller=controller,
        verdicts=verdicts,
    )
    return _in_parts(make, call, reaches * len(listed), Path(out), parts, retries, keep_parts, progress)


def reproduce(
    out: str | os.PathLike[str],
    *,
    campaigns: int,
    experiment: str | os.PathLike[str] | None = None,
    quick: bool = False,
    seed: int | None = None,
    address: str | None = None,
    retries: int = 3,
    progress: Progress | bool = True,
) -> dict[str, Any]:
    """Run many campaigns of an experiment on the nodes of a Ray cluster, and write its report.

    The results are those of :func:`underbrush.reproduce` with the same number of campaigns. The first campaign, from
    which the report takes everything that it shows of a single one, runs on this machine after the others. Finished
    campaigns are kept, and the same call continues from them.

    Parameters
    ----------
    out : path
        The folder to write, on storage that all nodes see under this path.
    campaigns : int
        Number of campaigns. They have the seed and the following ones.
    experiment : path, optional
        An experiment file that all nodes see under this path; by default the paper's.
    quick : bool
        Fewer reaches, and only the first recipe.
    seed : int, optional
        A seed instead of the experiment's own.
    address, retries : optional
        As for :func:`generate`.
    progress : bool or callable
        As for :func:`generate`; it counts campaigns.

    Returns
    -------
    dict
        The results, with the keys of ``underbrush reproduce --json``.

    Raises
    ------
    InputError
        If the experiment file or an option is bad, or if the folder holds the results of another run, or files that may
        not come from a run.
    ImportError
        If Ray is not installed.
    """
    check_campaigns(campaigns)
    ray = _ray()
    _connect(address)
    folder = Path(out).absolute()
    options: dict[str, Any] = {
        "experiment": None if experiment is None else str(Path(experiment).absolute()),
        "quick": quick,
        "seed": seed,
    }
    run = ray.remote(num_cpus=1, max_retries=retries, retry_exceptions=[OSError])(_run_campaign)
    waiting = [run.remote(str(folder), number, options) for number in range(1, campaigns)]
    with Bar("campaigns").shown(progress) as shown:
        _watch(waiting, campaigns, shown)
    return _reproduce(folder, campaigns=campaigns, progress=progress, **options)


def benchmark(
    track: Track,
    out: str | os.PathLike[str] = "out/benchmark",
    *,
    model: str | os.PathLike[str] | None = None,
    controller: ControllerLike | None = None,
    verdicts: str | os.PathLike[str] | None = None,
    quick: bool = False,
    parts: int | None = None,
    address: str | None = None,
    retries: int = 3,
    progress: Progress | bool = True,
) -> dict[str, Any]:
    """Judge a model or a controller on frozen scenes, with the reaches made on the nodes of a Ray cluster.

    The row equals that of :func:`underbrush.benchmark`, byte for byte. Sets that are in the folder already are not made
    again.

    Parameters
    ----------
    track : {"verdicts", "transfer", "reaching"}
        As for :func:`underbrush.benchmark`.
    out : path
        The folder to write, on storage that all nodes see under this path.
    model, controller, verdicts, quick : optional
        As for :func:`underbrush.benchmark`. Models must be on storage that all nodes see.
    parts : int, optional
        Number of tasks for each set; by default as for :func:`generate`.
    address, retries : optional
        As for :func:`generate`.
    progress : bool or callable
        As for :func:`generate`.

    Returns
    -------
    dict
        The row, with the keys of ``underbrush benchmark --json``.

    Raises
    ------
    InputError
        If the model or an argument is bad, if an argument does not belong to the track, or if the folder holds the row
        of another model under this name, reaches of another version, or parts of another call.
    ImportError
        If Ray is not installed.
    """
    _connect(address)
    folder = Path(out).absolute()
    options: dict[str, Any] = {"quick": quick, **entry(model, controller, verdicts)}
    for place, (path, reaches) in enumerate(_core.benchmark_sets(track, out=folder, **options)):
        if not path.exists():
            make = partial(_core.benchmark_part, place, track=track, **options)
            call = _call(track=track, set=place, **options)
            _in_parts(make, call, reaches, path, parts, retries, False, progress)
    return _benchmark(track, folder, model=model, controller=controller, verdicts=verdicts, quick=quick, progress=progress)


def _is_finished(out: Path) -> bool:
    """Whether a folder holds a finished data set, damaged or not, or anything else that no set can be written into. If
    the disk fails, that is an error, because a finished set would be made again."""
    try:
        _core.Dataset(out)
    except InputError:
        # Only a folder that is missing, empty or begun counts as not finished.
        try:
            names = os.listdir(out)
        except FileNotFoundError:
            return False
        except NotADirectoryError:
            return True
        return bool(names) and "incomplete" not in names
    return True


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _call(*, controller: ControllerLike | None, **given: Any) -> dict[str, Any]:
    """Describes a call that makes parts: the version, and the arguments that decide the bytes of a part. Models stand
    there by the hashes of their files, and controllers by their names, as in data sets."""
    for name in ("model", "verdicts"):
        if (path := given.get(name)) is not None:
            # The tasks say what is wrong with a file that cannot be read.
            given[name] = _hash(Path(path).read_bytes()) if Path(path).is_file() else str(path)
    if controller is not None and not isinstance(controller, str):
        names = [getattr(controller, attribute, None) for attribute in ("name", "__name__")]
        controller = next((name for name in names if isinstance(name, str)), "python")
    return {"version": _core.PROGRAM_VERSION, "controller": controller, **given}


def _claim(folder: Path, call: dict[str, Any], parts: int | None, default: int) -> int:
    """Takes a folder for the parts of a call, unless it holds finished parts of another one. Returns the number of
    parts: the given one, or else that of the parts that are there, or else the default."""
    if parts is not None:
        whole("parts", parts, 1)
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "call.json"
    if any(path.is_dir() and path.name.isdecimal() for path in folder.iterdir()):
        before: dict[str, Any] = {}
        try:
            before = dict(json.loads(file.read_bytes()))
        except (FileNotFoundError, TypeError, ValueError):
            pass
        count = int(parts or before.get("parts", default))
        wanted = {**call, "parts": count}
        if before != wanted:
            names = sorted(name for name in before.keys() | wanted.keys() if before.get(name) != wanted.get(name))
            found = f"parts of another call, which differs in {' and '.join(names)}" if before else "parts of an unknown call"
            allowed = "an empty folder, or parts of this call"
            remedy = "remove this folder, or choose another out"
            message = f"{folder}: out: found {found}; allowed: {allowed}; remedy: {remedy}"
            raise InputError(message, str(folder), None, "out", found, allowed, remedy)
        return count
    count = int(parts or default)
    own = folder / f".call-{uuid.uuid4().hex}"
    own.write_text(json.dumps({**call, "parts": count}, indent=2) + "\n")
    own.replace(file)
    return count


def _in_parts(
    make: Callable[..., object],
    call: dict[str, Any],
    reaches: int,
    out: Path,
    parts: int | None,
    retries: int,
    keep_parts: bool,
    progress: Progress | bool,
) -> _core.Dataset:
    """Makes the parts of a set as tasks, by ``make(folder, shard=(I, N), jobs=1)``, and merges them."""
    ray = _ray()
    folder = Path(f"{out}.parts").absolute()
    count = _claim(folder, call, parts, max(1, min(4 * int(ray.cluster_resources().get("CPU", 1)), reaches)))
    run = ray.remote(num_cpus=1, max_retries=retries, retry_exceptions=[OSError])(_run_part)
    waiting = [run.remote(make, str(folder), part, count) for part in range(1, count + 1)]
    with Bar("reaches").shown(progress) as shown:
        _watch(waiting, reaches, shown)
    merged = _core.merge([folder / str(part) for part in range(1, count + 1)], out, resume=True)
    if not keep_parts:
        shutil.rmtree(folder)
    return merged


def _connect(address: str | None) -> None:
    """Connects this process to a cluster, unless it is connected to one already."""
    ray = _ray()
    if not ray.is_initialized():
        ray.init(address=address, log_to_driver=False, include_dashboard=False)


def _watch(waiting: list[Any], total: int, shown: Progress | None) -> None:
    """Waits for all tasks, and reports how many of the total are done. If one fails for good, the others are ended."""
    ray = _ray()
    count, done = len(waiting), 0
    nodes: set[str] = set()
    try:
        while waiting:
            ready, waiting = ray.wait(waiting, timeout=1.0)
            for manifest in _answers(ready):
                done += manifest["done"]
                nodes.add(manifest["node"])
            if shown is not None:
                shown(done, total, f"{len(waiting)} of {count} tasks to go, {len(nodes)} nodes")
    finally:
        for task in waiting:
            ray.cancel(task, force=True)


def _answers(tasks: list[Any]) -> list[Manifest]:
    """What finished tasks returned. If one failed, its exception is raised here as it was raised there."""
    ray = _ray()
    try:
        return list(ray.get(tasks))
    except ray.exceptions.RayTaskError as error:
        raise error.cause from None


def _generate_part(scenes: list[_core.Scene], reaches: int, out: Path, **options: Any) -> None:
    _core.generate(scenes, reaches, out, **options)


def _run_part(make: Callable[..., object], folder: str, part: int, count: int) -> Manifest:
    """Runs one part on this node, unless it is finished."""
    start = time.monotonic()
    final = Path(folder, str(part))
    if not final.exists():
        own = Path(folder, f".{part}-{uuid.uuid4().hex}")
        try:
            make(own, shard=(part, count), jobs=1)
            try:
                # Renaming is one step: another run of this part has either finished before, or will find this result.
                own.rename(final)
            except OSError:
                if not final.exists():
                    raise
        finally:
            shutil.rmtree(own, ignore_errors=True)
    return _manifest(len(_core.Dataset(final)), start)


def _run_campaign(folder: str, number: int, options: dict[str, Any]) -> Manifest:
    """Runs one campaign, not the first, on this node, unless it is finished."""
    start = time.monotonic()
    _core.run_campaign(folder, number, jobs=1, **options)
    return _manifest(1, start)


def _manifest(done: int, start: float) -> Manifest:
    return Manifest(done=done, node=_ray().get_runtime_context().get_node_id(), seconds=time.monotonic() - start)
