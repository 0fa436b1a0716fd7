"""Regression suites and whole studies."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from . import _core
from ._errors import refused, whole
from ._progress import Bar, Progress

PathLike = str | os.PathLike[str]


def check(
    suites: PathLike | Sequence[PathLike],
    *,
    seed: int | None = None,
    bless: bool = False,
    out: PathLike | None = None,
    force: bool = False,
    progress: Progress | bool = True,
    jobs: int | None = None,
) -> dict[str, Any]:
    """Run regression suites and compare the results with the bounds in their files, as ``underbrush check`` does.

    Parameters
    ----------
    suites : path, or list of paths
        Suite files; ``docs/suites.md`` describes them.
    seed : int, optional
        A seed instead of each file's own, for other draws of the same scenes.
    bless : bool
        Write bounds into the files, computed from the results.
    out : path, optional
        A folder for ``junit.xml`` and ``results.json``.
    force : bool
        Overwrite these two files.
    progress : bool or callable
        ``True`` shows a bar on a terminal; a function is called as ``progress(done, total, text)`` on the calling thread.
    jobs : int, optional
        Number of threads; all cores by default.

    Returns
    -------
    dict
        The keys of ``underbrush check --json``. A bound that does not hold is a result, not an error: ``passed`` says whether
        all hold.

    Raises
    ------
    InputError
        If a file or an option is bad, if no file is given, if ``bless`` comes with a ``seed``, or if a bound cannot be
        computed or written.
    """
    paths = [suites] if isinstance(suites, (str, os.PathLike)) else list(suites)
    if not paths:
        raise refused("suites", "none", "one suite file or more", "name one")
    if bless and seed is not None:
        raise refused("bless", "True with a seed", "bounds from the seed of the file", "leave the seed out")
    with Bar("reaches").shown(progress) as shown:
        found: dict[str, Any] = _core.check(
            [Path(path) for path in paths],
            seed=seed,
            bless=bless,
            out=None if out is None else Path(out),
            force=force,
            progress=shown,
            jobs=jobs,
        )
    return found


def reproduce(
    out: PathLike,
    *,
    experiment: PathLike | None = None,
    quick: bool = False,
    seed: int | None = None,
    campaigns: int = 1,
    force: bool = False,
    progress: Progress | bool = True,
    jobs: int | None = None,
) -> dict[str, Any]:
    """Run an experiment, by default the paper's, as ``underbrush reproduce`` does.

    The folder gets the data set, trials, ``model.json``, ``summary.json`` and ``report/index.html``. Finished stages
    are cached there, so the same call continues after Ctrl-C.

    Parameters
    ----------
    out : path
        The folder to write.
    experiment : path, optional
        An experiment file.
    quick : bool
        Fewer reaches, and only the first recipe.
    seed : int, optional
        A seed instead of the experiment's own.
    campaigns : int
        Number of campaigns. They have this seed and the following ones.
    force : bool
        Remove what another run has left in the folder, and start again.
    progress : bool or callable
        As for :func:`check`.
    jobs : int, optional
        Number of threads; all cores by default.

    Returns
    -------
    dict
        The results, with the keys of ``underbrush reproduce --json``.

    Raises
    ------
    InputError
        If the experiment file or an option is bad, or if the folder holds the results of another run, or files that may
        not come from a run.
    """
    check_campaigns(campaigns)
    with Bar("steps").shown(progress) as shown:
        found: dict[str, Any] = _core.reproduce(
            Path(out),
            experiment=None if experiment is None else Path(experiment),
            quick=quick,
            seed=seed,
            campaigns=campaigns,
            force=force,
            progress=shown,
            jobs=jobs,
        )
    return found


def check_campaigns(campaigns: int) -> None:
    """Refuses a number of campaigns that no experiment can have."""
    whole("campaigns", campaigns, 1, 10_000)
