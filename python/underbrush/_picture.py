"""Pictures."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from . import _export


@dataclass(frozen=True, repr=False)
class Picture:
    """A picture (SVG), shown inline in a notebook.

    Attributes
    ----------
    svg : str
        The text of the picture.
    """

    svg: str

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Write the picture to a file. Only with ``force`` is a file overwritten."""
        with _export.whole(Path(path), force) as temporary:
            temporary.write_text(self.svg, encoding="utf-8")
