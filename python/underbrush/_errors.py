"""The exceptions of the package."""

from __future__ import annotations

import math
import operator
import os
import re
import sys
import warnings
from typing import Any

# What messages of the command line are called in Python, the longer ones first.
_IN_PYTHON = [
    (r"`underbrush generate --shard I/N`", "`underbrush.generate(..., shard=(I, N))`"),
    (r"`underbrush train --classifier touch`", "`underbrush.TouchModel.fit`"),
    (r"`underbrush generate`", "`underbrush.generate`"),
    (r"`underbrush (schema[ a-z]*)`", r"the command `python -m underbrush \1`"),
    (r"\(--decision uncertain\)", "(such as decision=15.0)"),
    (r"classify --decision argmax", 'classify with decision="argmax"'),
    (r"classify --decision and --prior", "classify a decision"),
    (r"give classify and evaluate a larger --unknown-share", "give the commands classify and evaluate a larger --unknown-share"),
    (r"(?<!\S)--false-positive-rate\b", "false_positive_rate"),
    (r"(?<!\S)--(bless|force|resume)\b", r"\1=True"),
    (r"(?<!\S)--shard\b", "shard=(I, N)"),
    (r"\bTRIALS\b", "the argument trials"),
    (r"(?<!\S)--features (\w+)", r'features="\1"'),
    (r"(?<!\S)--(controller|out|reaches|train|verdicts)\b", r"the argument \1"),
]


def _in_python(text: str) -> str:
    """A message of the libraries with the names of arguments and functions in place of options and commands."""
    for pattern, name in _IN_PYTHON:
        text = re.sub(pattern, name, text)
    return text


class InputError(ValueError):
    """Bad input: where it is, what was found there, what is allowed, and the remedy.

    Attributes
    ----------
    file : str or None
        The file, or what else the error is about (an argument, a data set).
    line : int or None
        Line in the file, from 1.
    field : str or None
        The field, column, key, option or argument.
    found, allowed, remedy : str or None
        What was found there, what is allowed, and what to do. ``None`` if the message says all of this in one sentence.
    """

    # `args` has the words of the command line, which the exports as commands print.

    def __init__(
        self,
        message: str,
        file: str | None = None,
        line: int | None = None,
        field: str | None = None,
        found: str | None = None,
        allowed: str | None = None,
        remedy: str | None = None,
    ) -> None:
        super().__init__(message, file, line, field, found, allowed, remedy)
        self.file = file
        self.line = line
        self.field = field
        self.found = found
        self.allowed = None if allowed is None else _in_python(allowed)
        self.remedy = None if remedy is None else _in_python(remedy)

    def __str__(self) -> str:
        return _in_python(str(self.args[0]))


def warn(text: str) -> None:
    """Shows a warning of the libraries at the line that called the package."""
    level, frame = 2, sys._getframe().f_back
    while frame and os.path.dirname(frame.f_code.co_filename) == os.path.dirname(__file__):
        level, frame = level + 1, frame.f_back
    warnings.warn(_in_python(text.removeprefix("warning: ")), stacklevel=level)


def refused(field: str, found: str, allowed: str, remedy: str, file: str = "argument") -> InputError:
    """The error about an argument, or about a field of something else."""
    message = f"{file}: {field}: found {found}; allowed: {allowed}; remedy: {remedy}"
    return InputError(message, file, None, field, found, allowed, remedy)


def whole(field: str, value: Any, low: int, high: float = math.inf) -> int:
    """The argument with this name as a whole number of a range."""
    try:
        number = operator.index(value)
    except TypeError:
        number = low - 1
    if isinstance(value, bool) or not low <= number <= high:
        allowed = f"{low} or more" if math.isinf(high) else f"{low} to {high}"
        raise refused(field, f"{value}", f"a whole number, {allowed}", "change it")
    return number


class RunError(RuntimeError):
    """A run that failed although its input was good, for example because of a fault inside the physics engine."""

    def __str__(self) -> str:
        return _in_python(super().__str__())


class StorageError(RunError, OSError):
    """A file that could not be read or written, for example on a full disk. The same call may succeed later."""


InputError.__module__ = "underbrush"
RunError.__module__ = "underbrush"
StorageError.__module__ = "underbrush"
