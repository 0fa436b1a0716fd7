"""One contact trial."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class Trial:
    """One contact trial. Its arrays have an entry for each sample; they are read-only.

    Attributes
    ----------
    number : int
        Number of the trial in its table.
    category : str or None
        Ground truth; None if unknown.
    reach : int or None
        The reach that it comes from; None if unknown.
    patch : str or None
        Name of the patch; None if unknown.
    taxel : int or None
        Index of the taxel in its patch; None if unknown.
    touched : bool or None
        Ground truth: whether something truly pressed in at least one sample; None if unknown.
    time_s : array
        Time of each sample, s.
    force_n : array
        Sensed force, N.
    motion_m : array
        Distance that the contact has travelled since it began, m; NaN where it is unknown.
    """

    number: int
    category: str | None
    reach: int | None
    patch: str | None
    taxel: int | None
    touched: bool | None
    time_s: _Array
    force_n: _Array
    motion_m: _Array

    def __len__(self) -> int:
        """Number of samples."""
        return len(self.time_s)

    def __repr__(self) -> str:
        return f"Trial({self.number}, {self.category or 'unknown'}, {len(self)} samples)"
