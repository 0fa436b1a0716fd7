"""The command ``underbrush``, also as ``python -m underbrush``."""

from __future__ import annotations

import argparse
import importlib
import os
import signal
import sys
from pathlib import Path

from underbrush import _errors
from underbrush._core import run_command_line

# The formats of `underbrush export --to` and of films of `underbrush replay --video` that modules of this package write. Another
# one sends `underbrush classify - --foxglove PORT` to Foxglove.
_EXPORTS = ("hdf5", "mcap", "ros2")
_FILMS = (".mp4", ".webp")


def _of_python(arguments: list[str]) -> tuple[str, list[str]] | None:
    """The module that does what these arguments ask for, and its arguments. None if the command line does it."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
    for option in ("--to", "--foxglove", "--video"):
        parser.add_argument(option)
    # These two may stand before the command.
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--jobs", type=int, choices=range(1, 1025))
    try:
        given, others = parser.parse_known_args(arguments)
    except argparse.ArgumentError:
        return None
    command, *others = others or [""]
    if given.jobs:
        # The libraries read it when they start their threads.
        os.environ["RAYON_NUM_THREADS"] = str(given.jobs)
    json = ["--json"] if given.json else []
    if command == "export" and given.to in _EXPORTS:
        return given.to, ["export", *json, *others]
    if command == "replay" and Path(given.video or "").suffix.lower() in _FILMS:
        return "video", ["film", "--out", given.video, *json, *others]
    if command == "classify" and given.foxglove and not given.json:
        return "live", ["--foxglove", given.foxglove, *others]
    return None


def main() -> int:
    """Run the command line with the arguments of this process, and return its exit status."""
    if found := _of_python(sys.argv[1:]):
        module, arguments = found
        status: int = importlib.import_module(f"underbrush.{module}").main(arguments)
        return status
    # Warnings of the libraries are lines, as those of the program.
    _errors.warn = lambda text: print(text, file=sys.stderr)
    # The command line handles Ctrl-C by itself. Python's handler would wait until it returns.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return run_command_line(["underbrush", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
