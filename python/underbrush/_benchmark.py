"""Rows of the benchmark's table."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Literal, TypeAlias

from . import _core
from ._progress import Bar, Progress
from ._types import ControllerLike

Track: TypeAlias = Literal["verdicts", "transfer", "reaching"]


def benchmark(
    track: Track,
    out: str | os.PathLike[str] = "out/benchmark",
    *,
    model: str | os.PathLike[str] | None = None,
    controller: ControllerLike | None = None,
    verdicts: str | os.PathLike[str] | None = None,
    quick: bool = False,
    progress: Progress | bool = True,
    jobs: int | None = None,
) -> dict[str, Any]:
    """Judge a model or a controller on frozen scenes, as ``underbrush benchmark`` does.

    ``benchmarks/incidental-contact-2.md`` has the rules. Public reaches are made once and kept in the folder for the next
    model; those of the audit half have a seed that follows from the model's file, or from a controller's name. After Ctrl-C,
    the same call continues.

    Parameters
    ----------
    track : {"verdicts", "transfer", "reaching"}
        What is judged: verdicts on objects; the same with another arm, speed or sensor than in training; or how a
        controller reaches.
    out : path
        Folder for the reaches, and for the rows as JSON files.
    model : path, optional
        The model to judge, of any kind; for verdicts and transfer.
    controller : str, callable or class, optional
        The controller to judge, as for :func:`generate`; for reaching. Reaches of a controller of your own are found
        again by its name, so give it another name when you have changed it.
    verdicts : path, optional
        A touch model that tells the controller what the skin touches.
    quick : bool
        Only two reaches of each scene, to try things out.
    progress : bool or callable
        ``True`` shows a bar on a terminal; a function is called as ``progress(done, total, text)`` on the calling thread.
    jobs : int, optional
        Number of threads; all cores by default.

    Returns
    -------
    dict
        The row, with the keys of ``underbrush benchmark --json``.

    Raises
    ------
    InputError
        If the model or an argument is bad, if an argument does not belong to the track, or if the folder holds the row
        of another model under this name or reaches of another version.
    """
    with Bar("reaches").shown(progress) as shown:
        row: dict[str, Any] = _core.benchmark(
            track, out=Path(out), quick=quick, progress=shown, jobs=jobs, **entry(model, controller, verdicts)
        )
    return row


def entry(
    model: str | os.PathLike[str] | None,
    controller: ControllerLike | None,
    verdicts: str | os.PathLike[str] | None,
) -> dict[str, Any]:
    """The arguments that say what is judged, as the native functions take them."""
    return {
        "model": None if model is None else Path(model).absolute(),
        "controller": controller,
        "verdicts": lasting(verdicts),
    }


def lasting(verdicts: str | os.PathLike[str] | None) -> Path | None:
    """Verdicts as a process in another folder finds them: ``truth`` and ``none`` are no files."""
    path = None if verdicts is None else Path(verdicts)
    return path if path is None or str(path) in ("truth", "none") else path.absolute()
