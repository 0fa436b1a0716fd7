"""The command ``underbrush``, also as ``python -m underbrush``."""

from __future__ import annotations

import argparse
import importlib
import signal
import sys
import warnings
from pathlib import Path

from underbrush._core import run_command_line

# The formats of `underbrush export --to` and of films of `underbrush replay --video` that modules of this package write. Another
# one sends `underbrush classify - --foxglove PORT` to Foxglove.
_EXPORTS = ("hdf5", "mcap", "ros2")
_FILMS = (".mp4", ".webp")
# For each command, the option that decides.
_OPTIONS = {"export": ["--to"], "classify": ["--foxglove"], "replay": ["--video"]}


def _of_python(arguments: list[str]) -> tuple[str, list[str]] | None:
    """The module that does what these arguments ask for, and its arguments. None if the command line does it.

    The modules do not write JSON. With ``--json`` the command line ends with an error that names the module.
    """
    command = arguments[0] if arguments else ""
    if "--json" in arguments or command not in _OPTIONS:
        return None
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
    for option in _OPTIONS[command]:
        parser.add_argument(option)
    try:
        given, others = parser.parse_known_args(arguments[1:])
    except argparse.ArgumentError:
        return None
    if command == "export":
        return (given.to, ["export", *others]) if given.to in _EXPORTS else None
    if command == "classify":
        return ("live", arguments[1:]) if given.foxglove else None
    if Path(given.video or "").suffix.lower() not in _FILMS:
        return None
    return "video", ["film", "--out", given.video, *others]


def main() -> int:
    """Run the command line with the arguments of this process, and return its exit status."""
    if found := _of_python(sys.argv[1:]):
        module, arguments = found
        status: int = importlib.import_module(f"underbrush.{module}").main(arguments)
        return status
    # Remarks of the libraries are lines, as those of the program.
    warnings.showwarning = lambda message, *_: print(message, file=sys.stderr)
    warnings.simplefilter("always")
    # The command line handles Ctrl-C by itself. Python's handler would wait until it returns.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return run_command_line(["underbrush", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
