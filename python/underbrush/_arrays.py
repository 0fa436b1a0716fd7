"""Arguments that are arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import refused


def joined(parts: Sequence[NDArray[Any]], dtype: str | None) -> NDArray[Any]:
    """The parts of a column, one below the other, read only. Floating-point numbers get this type."""
    array = parts[0] if len(parts) == 1 else np.concatenate(parts)
    if dtype is not None and array.dtype.kind == "f":
        array = array.astype(dtype, copy=False)
    array.flags.writeable = False
    return array


def numbers(value: Any, name: str, shape: Sequence[int | None]) -> NDArray[np.float64]:
    """The argument with this name as numbers of a shape, in which ``None`` stands for any size."""
    allowed = f"numbers of shape ({', '.join('n' if size is None else str(size) for size in shape)})"
    if np.ma.is_masked(value):
        raise refused(name, "a masked array", allowed, "fill it, or leave the masked numbers out")
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "fiub":
            raise TypeError
        array = np.asarray(array, np.float64)
    except Exception:
        has_dtype = hasattr(value, "dtype")
        found = f"an array of {value.dtype}" if has_dtype else f"an object of type {type(value).__name__}"
        raise refused(name, found, allowed, "give an array of numbers") from None
    fits = array.ndim == len(shape) and all(size in (None, own) for size, own in zip(shape, array.shape))
    if not fits:
        found = f"shape ({', '.join(map(str, array.shape))})"
        raise refused(name, found, allowed, "give an array of this shape")
    return array
