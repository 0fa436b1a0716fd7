"""Map-style data sets for ``torch.utils.data.DataLoader``. They do not need torch themselves."""

from __future__ import annotations

import html
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._errors import InputError, refused, whole


def each(things: _core.Dataset | _core.Trials) -> Iterator[Any]:
    """The reaches of a data set, or trials, one by one."""
    return (things[index] for index in range(len(things)))


def html_of(dataset: _core.Dataset) -> str:
    """A table of the first reaches of a data set, for notebooks."""
    keys = ("scene", "frames", "outcome", "contacts")
    episodes = dataset.episodes[:50]
    rows = ([number, own["scene"], own["frames"], own["outcome"], own["contacts"]] for number, own in enumerate(episodes))
    cells = ("".join(f"<td>{html.escape(str(cell), quote=False)}</td>" for cell in row) for row in rows)
    header = "".join(f"<th>{name}</th>" for name in ("reach", *keys))
    caption = f"<caption>{len(dataset)} reaches in {html.escape(str(dataset.path), quote=False)}</caption>"
    return f"<table>{caption}<tr>{header}</tr>{''.join(f'<tr>{row}</tr>' for row in cells)}</table>"


def bytes_of(reach: _core.Reach) -> bytes:
    """The bytes of the file of a reach, for pickling."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "reach.parquet"
        reach.save(path)
        return path.read_bytes()


def reach_of(data: bytes) -> _core.Reach:
    """The reach in the bytes of a file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "reach.parquet"
        path.write_bytes(data)
        return _core.Reach.load(path)


def trials_of(frame: Any, min_samples: int) -> _core.Trials:
    """The trials in a data frame of pandas or Polars. It goes through a CSV file, whose reader checks every cell."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "frame.csv"
        if hasattr(frame, "write_csv"):
            frame.write_csv(path)
        elif hasattr(frame, "to_csv"):
            frame.to_csv(path, index=False)
        else:
            found, allowed = type(frame).__name__, "a data frame of pandas or Polars"
            raise refused("frame", found, allowed, "use Trials.from_sequences for arrays")
        try:
            return _core.Trials._of_frame(path, min_samples)
        except InputError as error:
            if error.field is None:
                raise
            # The first line is the header.
            row = "" if error.line is None or error.line < 2 else f"row {error.line - 2}, "
            found, allowed, remedy = (str(own) for own in (error.found, error.allowed, error.remedy))
            raise refused(f"{row}{error.field}", found, allowed, remedy, "the data frame") from None


class TrialDataset:
    """Trials as pairs of an array and the number of a category.

    Parameters
    ----------
    trials : Trials
        Trials with categories.
    categories : list of str, optional
        The categories in the order of their numbers; by default those of the trials, sorted.
    features : str or list of str
        Features of each sample.
    samples : int, optional
        Cut or pad (with the last sample) every trial to this length, so that trials can be batched.
    """

    def __init__(
        self,
        trials: _core.Trials,
        categories: Sequence[str] | None = None,
        *,
        features: str | Sequence[str] = "force",
        samples: int | None = None,
    ) -> None:
        known = sorted({name for name in trials.categories if name is not None})
        self.categories = list(categories) if categories is not None else known
        if categories is not None and not set(categories) & set(known):
            raise refused("categories", f"{self.categories}", f"names of categories of the trials: {known}", "give some of them")
        if len(set(self.categories)) < len(self.categories):
            raise refused("categories", f"{self.categories}", "each name once", "leave out the others")
        numbers = {name: number for number, name in enumerate(self.categories)}
        kept = [place for place, name in enumerate(trials.categories) if name in numbers]
        chosen = trials[kept]
        self.labels = [numbers[name] for name in chosen.categories if name is not None]
        self.sequences = chosen.sequences(features)
        self.samples = None if samples is None else whole("samples", samples, 1)

    def __len__(self) -> int:
        return len(self.labels)

    def __getitem__(self, index: int) -> tuple[NDArray[np.float32], int]:
        """An array (samples, features) of float32, and the number of its category."""
        sequence = self.sequences[index].astype(np.float32)
        if self.samples is not None:
            sequence = sequence[: self.samples]
            missing = self.samples - len(sequence)
            sequence = np.concatenate([sequence, np.repeat(sequence[-1:], missing, axis=0)])
        return sequence, self.labels[index]


class FrameDataset:
    """Frames of a data set as dictionaries of arrays, one by one over all reaches. Columns are read when they are first needed.

    Parameters
    ----------
    dataset : Dataset
    columns : list of str
        Columns of the frames, such as ``observation.tactile.forearm``.
    """

    def __init__(self, dataset: _core.Dataset, columns: Sequence[str]) -> None:
        self.dataset = dataset
        self.columns = [columns] if isinstance(columns, str) else list(columns)
        known = dataset.column_names
        if unknown := [name for name in self.columns if name not in known]:
            raise refused("columns", f"{unknown[0]!r}", ", ".join(known), "choose some of them")
        self._arrays: dict[str, NDArray[np.float32]] = {}
        self._length = sum(int(episode["frames"]) for episode in dataset.episodes)

    def __len__(self) -> int:
        return self._length

    def _array(self, name: str) -> NDArray[np.float32]:
        if name not in self._arrays:
            self._arrays[name] = self.dataset.column(name, "float32")
        return self._arrays[name]

    def __getitem__(self, index: int) -> dict[str, NDArray[np.float32]]:
        """The columns of one frame, copied, so that they may be changed."""
        if not -self._length <= index < self._length:
            raise IndexError(f"index {index} of {self._length}")
        return {name: np.array(self._array(name)[index], dtype=np.float32) for name in self.columns}
