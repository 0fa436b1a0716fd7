"""The command ``underbrush``, also as ``python -m underbrush``."""

import signal
import sys

from underbrush._core import run_command_line


def main() -> int:
    """Run the command line with the arguments of this process, and return its exit status."""
    # The command line handles Ctrl-C by itself. Python's handler would wait until it returns.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return run_command_line(["underbrush", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
