"""Pictures."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from . import _export


@dataclass(frozen=True, repr=False)
class Picture:
    """A picture (PNG), shown inline in a notebook.

    Attributes
    ----------
    png : bytes
        The file.
    """

    png: bytes

    def __repr__(self) -> str:
        return f"Picture({len(self.png)} bytes)"

    def _repr_png_(self) -> bytes:
        return self.png

    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Write the picture to a file. Only with ``force`` is a file overwritten."""
        with _export.whole(Path(path), force) as temporary:
            temporary.write_bytes(self.png)
