"""A progress bar on a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ._errors import refused

Progress = Callable[[int, int, str], object]

_WIDTH = 30


class Bar:
    """A progress bar on standard error, which is not shown if standard error is not a terminal.

    Parameters
    ----------
    things : str
        What is counted.
    """

    def __init__(self, things: str) -> None:
        self.things = things
        self.is_shown = sys.stderr is not None and sys.stderr.isatty()
        self.last = ""

    def __call__(self, done: int, total: int, text: str) -> None:
        filled = _WIDTH * done // max(total, 1)
        line = f"{'#' * filled}{'.' * (_WIDTH - filled)} {done}/{total} {self.things}  {text}"
        if self.is_shown and line != self.last:
            print(f"\r\033[K{line}", end="", file=sys.stderr, flush=True)
            self.last = line

    @contextmanager
    def shown(self, progress: Progress | bool) -> Iterator[Progress | None]:
        """What a call should report to: this bar for ``True``, nothing for ``False``, or else the given function."""
        if progress and progress is not True and not callable(progress):
            allowed = "True, False, or a function of done, total and text"
            raise refused("progress", f"an object of type {type(progress).__name__}", allowed, "give one of them")
        try:
            yield self if progress is True else (progress or None)
        finally:
            if self.last:
                print("\r\033[K", end="", file=sys.stderr, flush=True)
