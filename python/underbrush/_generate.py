"""Making data sets, with a progress bar on a terminal."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import cast

from . import _core
from ._errors import refused
from ._progress import Bar, Progress
from ._types import ControllerLike, SceneLike


def scene_list(scenes: SceneLike | Sequence[SceneLike]) -> list[SceneLike]:
    """The scenes of an argument, which may be a single one."""
    if isinstance(scenes, (_core.Scene, str, os.PathLike)):
        return [scenes]
    if not isinstance(scenes, Iterable):
        allowed = "a Scene, the name or the path of one, or a list of them"
        raise refused("scenes", f"an object of type {type(scenes).__name__}", allowed, "give one of them")
    return list(scenes)


def generate(
    scenes: SceneLike | Sequence[SceneLike],
    reaches: int,
    out: str | os.PathLike[str],
    *,
    seed: int = 0,
    controller: ControllerLike | None = None,
    verdicts: str | os.PathLike[str] | None = None,
    resume: bool = False,
    force: bool = False,
    shard: tuple[int, int] | None = None,
    progress: Progress | bool = True,
    jobs: int | None = None,
) -> _core.Dataset:
    """Simulate many reaches and write them as a data set in the LeRobotDataset v3.0 layout.

    The same scenes, seed and version give the same bytes, for any number of threads. Ctrl-C ends the reaches that are
    running. Finished reaches are kept, and ``resume=True`` continues.

    Parameters
    ----------
    scenes : Scene, name or path, or a list of them
        What the arm reaches through.
    reaches : int
        Number of reaches of each scene.
    out : path
        The folder to write.
    seed : int
        Decides all random draws.
    controller : str, callable or class, optional
        The name of a controller that ships, or one of your own: called with a :class:`ControllerInput`, it returns
        equilibrium angles, rad. A class is called with the :class:`Arm` at the start of every reach. It needs a name of
        its own (its attribute ``name``, or else ``__name__``).
    verdicts : path, optional
        A touch model that tells the controller what the skin touches. ``"truth"`` tells the true categories instead.
    resume : bool
        Continue an interrupted set.
    force : bool
        Remove the data set that is in ``out`` first.
    shard : (int, int), optional
        Run only part I of N, counted from 1.
    progress : bool or callable
        ``True`` shows a bar on a terminal; a function is called as ``progress(done, total, text)`` on the calling thread.
    jobs : int, optional
        Number of threads; all cores by default.

    Returns
    -------
    Dataset

    Raises
    ------
    InputError
        If a scene, an option or the folder is bad.
    """
    with Bar("reaches").shown(progress) as shown:
        made = _core.generate(
            scene_list(scenes),
            reaches,
            Path(out),
            seed=seed,
            controller=controller,
            verdicts=None if verdicts is None else Path(verdicts),
            resume=resume,
            force=force,
            shard=shard,
            progress=shown,
            jobs=jobs,
        )
    # Only a part of a shared set may leave none.
    return cast(_core.Dataset, made)


def generate_shared(
    scenes: SceneLike | Sequence[SceneLike],
    reaches: int,
    out: str | os.PathLike[str],
    shard: tuple[int, int],
    *,
    seed: int = 0,
    controller: ControllerLike | None = None,
    verdicts: str | os.PathLike[str] | None = None,
    progress: Progress | bool = True,
    jobs: int | None = None,
) -> _core.Dataset | None:
    """Simulate part I of N of a data set into a folder that all parts share, as ``underbrush generate --shared`` does.

    All parts have the same arguments except ``shard``. They may run at the same time, on machines that share a file
    system with locks. The part that finishes last makes the set there, byte for byte the set of :func:`generate`
    without ``shard``, and returns it; the others return ``None``. A part that was interrupted continues when it is run
    again. The other parameters are those of :func:`generate`.

    Parameters
    ----------
    out : path
        The folder of the set, the same for all parts.
    shard : (int, int)
        The part I of N, counted from 1.

    Returns
    -------
    Dataset or None
        The set, if no other part is at work and all reaches are there.

    Raises
    ------
    InputError
        If a scene or an option is bad, or if the folder holds another set, parts of another campaign or other files.
    """
    with Bar("reaches").shown(progress) as shown:
        return _core.generate(
            scene_list(scenes),
            reaches,
            Path(out),
            seed=seed,
            controller=controller,
            verdicts=None if verdicts is None else Path(verdicts),
            shard=shard,
            shared=True,
            progress=shown,
            jobs=jobs,
        )


def generate_again(
    dataset: str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    verdicts: str | os.PathLike[str] | None = None,
    resume: bool = False,
    force: bool = False,
    progress: Progress | bool = True,
    jobs: int | None = None,
) -> _core.Dataset:
    """Make a data set again from what it stores. Parameters are those of :func:`generate`."""
    with Bar("reaches").shown(progress) as shown:
        return _core.generate_again(
            Path(dataset),
            Path(out),
            verdicts=None if verdicts is None else Path(verdicts),
            resume=resume,
            force=force,
            progress=shown,
            jobs=jobs,
        )
