"""What exports to files of other tools share."""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import signal
import sys
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import zip_longest
from pathlib import Path

from . import _core
from ._errors import InputError, refused


@contextlib.contextmanager
def whole(path: Path, force: bool, source: str | os.PathLike[str] | None = None) -> Iterator[Path]:
    """A temporary file that gets its name when it is complete. Missing folders around it are made. It must not replace its source,
    and neither a folder nor a device."""
    if source is not None and path.exists() and path.samefile(source):
        raise InputError(f"{path}: is the input; choose another name", file=str(path))
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: is a folder or not a regular file; give the name of a file to write", file=str(path))
    _core._check_free(path, force)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        descriptor = os.open(temporary, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
    except KeyboardInterrupt:
        # It may come as soon as the file is there.
        temporary.unlink(missing_ok=True)
        raise
    try:
        yield temporary
        os.fsync(descriptor)
        temporary.replace(path)
    finally:
        os.close(descriptor)
        temporary.unlink(missing_ok=True)


def make_folder(path: Path) -> None:
    """Makes the folder for the files of several reaches, if it is not there. It is not made within a data set."""
    _core._check_free(path, True)
    if path.exists() and not path.is_dir():
        raise InputError(f"{path}: is a file, and several reaches become a folder; choose another name", file=str(path))
    path.mkdir(parents=True, exist_ok=True)


def each(reaches: _core.Reach | _core.Dataset | Iterable[_core.Reach]) -> Iterator[_core.Reach]:
    """The reaches one by one. An object that holds no reaches is refused at once."""
    listed: Iterable[_core.Reach] = [reaches] if isinstance(reaches, _core.Reach) else reaches
    if isinstance(listed, (str, os.PathLike)) or not isinstance(listed, Iterable):
        raise _no_reach(listed)

    def checked() -> Iterator[_core.Reach]:
        for reach in listed:
            if not isinstance(reach, _core.Reach):
                raise _no_reach(reach)
            yield reach

    return checked()


def _no_reach(found: object) -> InputError:
    allowed = "a Reach, a Dataset, or a list of reaches"
    return refused("reaches", f"an object of type {type(found).__name__}", allowed, "open it with Reach.load or Dataset")


def reaches_in(places: list[Path], out: Path) -> tuple[int, Iterator[_core.Reach]]:
    """The number of reaches in data sets, recordings and folders of them, and the reaches. None of the places may be the output."""
    if any(out.exists() and place.exists() and out.samefile(place) for place in places):
        raise InputError(f"{out}: is an input of this command; choose another name", file=str(out))
    sets = [_core.Dataset(place) if place.is_dir() else place for place in _core._with_recordings(places)]

    def read() -> Iterator[_core.Reach]:
        for one in sets:
            yield from one if isinstance(one, _core.Dataset) else [_core.Reach.load(one)]

    return sum(len(one) if isinstance(one, _core.Dataset) else 1 for one in sets), read()


def export_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser], help: str, out: str) -> argparse.ArgumentParser:
    """Adds the subcommand ``export``."""
    parser = commands.add_parser("export", help=help)
    parser.add_argument("data", nargs="+", type=Path, help="data sets or folders of recordings, or recordings (.parquet)")
    output_options(parser, out)
    return parser


def output_options(parser: argparse.ArgumentParser, out: str) -> None:
    """Adds the options about what is written and printed."""
    parser.add_argument("--out", required=True, type=Path, help=out)
    parser.add_argument("--force", action="store_true", help="overwrite a file that exists")
    parser.add_argument("--json", action="store_true", help="print the result as one JSON object")


def status(run: Callable[[], Mapping[str, int] | None], options: argparse.Namespace) -> int:
    """Runs a command, which may return how many things it wrote. Prints this, and with ``--json`` what the command line prints.

    Returns its exit status: 1 if a file cannot be read or written, 2 for bad input. Ctrl-C ends the process.
    """
    try:
        found = run() or {}
        if options.json:
            files = [file for file in (options.out, *options.out.rglob("*")) if file.is_file()]
            print(json.dumps({"file": str(options.out), **found, "bytes": sum(file.stat().st_size for file in files)}))
        else:
            for things, count in found.items():
                one = {"reaches": "reach"}.get(things, things.removesuffix("s"))
                print(f"{count} {one if count == 1 else things} in {options.out}")
    except KeyboardInterrupt as interrupt:
        # If it came while a `with` began, its temporary file is removed only when nothing refers to it any more.
        traceback.clear_frames(interrupt.__traceback__)
        # As the command line does. A script that runs this command then stops, too.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        signal.raise_signal(signal.SIGINT)
    except (InputError, ImportError, OSError) as error:
        number = 1 if isinstance(error, OSError) else 2
        # A command names its options, not arguments of Python.
        known = error.args if isinstance(error, InputError) else [str(error)]
        if options.json:
            names = ("message", "file", "line", "field", "found", "allowed", "remedy")
            about = dict(zip_longest(names, known))
            print(json.dumps({"error": {"kind": "run" if number == 1 else "input", **about}}))
        print(f"error: {known[0]}", file=sys.stderr)
        return number
    return 0


def column_names(sizes: Mapping[str, int]) -> list[str]:
    """The columns of a log in CSV: the forces of the taxels, and the numbers of each channel, which may be one."""
    alone = {name for name, size in sizes.items() if size == 1 and name != "force"}
    names = [name if name in alone else f"{name}_{index}" for name, size in sizes.items() for index in range(size)]
    if repeated := sorted(name for name, count in Counter(names).items() if count > 1):
        raise refused("channels", f"two columns called {repeated[0]}", "names that differ", "give the channel another name")
    return names
