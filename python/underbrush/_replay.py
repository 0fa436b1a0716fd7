"""Reaches in the browser, or in a cell of a notebook."""

from __future__ import annotations

import html
import os
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from . import _core, _export
from ._errors import refused


class Page:
    """The replay page with some reaches inside, as one HTML file."""

    def __init__(self, text: str) -> None:
        self.html = text

    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Write the page to a file. Only with ``force`` is a file overwritten."""
        with _export.whole(Path(path), force) as temporary:
            temporary.write_text(self.html, encoding="utf-8")

    def _repr_html_(self) -> str:
        page = html.escape(self.html, quote=True)
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 640px; border: 0"></iframe>'


def replay(
    source: _core.Reach | _core.Dataset | str | os.PathLike[str],
    reaches: Sequence[int] | None = None,
    *,
    model: str | os.PathLike[str] | None = None,
    patch: str | None = None,
) -> Page:
    """Show reaches: the arm in 3-D, its skin, plots and verdicts over time.

    Parameters
    ----------
    source : Reach, Dataset or path
        A reach, a data set, or the path of a data set, a recording, a folder of recordings or a table of trials.
    reaches : list of int, optional
        Numbers of the reaches, from 0; all by default. One that is named twice is shown once.
    model : path, optional
        A model of trials or a touch model, whose verdicts are shown.
    patch : str, optional
        The patch that is judged; by default the first. A touch model itself says which patches it judges.

    Returns
    -------
    Page
        Shown inline by a notebook; ``save`` writes it to a file.
    """
    if patch is not None and model is None:
        raise refused("patch", "given without model", "only with it, because it is what the model judges", "leave it out")
    numbers = list(reaches) if isinstance(reaches, Iterable) else reaches
    judged = None if model is None else Path(model)
    if isinstance(source, _core.Reach):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "reach.parquet"
            source.save(path)
            return Page(_core.replay_page([path], numbers, model=judged, patch=patch, limit_n=source._limit_n))
    path = source.path if isinstance(source, _core.Dataset) else Path(source)
    return Page(_core.replay_page([path], numbers, model=judged, patch=patch))
