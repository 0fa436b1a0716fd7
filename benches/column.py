"""Time from an open data set to an array [frames, taxels] of float32, compared with Polars.

Both run alternately on the same set, whose files are in the operating system's cache. The fastest of several runs
counts.

    python benches/column.py SET [--runs N] [--column NAME]
"""

from __future__ import annotations

import argparse
import time

import numpy as np
import polars
import underbrush as ub
from numpy.typing import NDArray


def ours(path: str, column: str) -> NDArray[np.float32]:
    """Opens the set, checks the hashes of the files that it reads, and reads the column."""
    return ub.Dataset(path).column(column, "float32")


def theirs(path: str, column: str) -> NDArray[np.float32]:
    """Reads the column with Polars, which checks no hashes."""
    frames = polars.read_parquet(f"{path}/data/**/*.parquet", columns=[column])
    return frames[column].to_numpy().astype(np.float32)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("set")
    parser.add_argument("--runs", type=int, default=7)
    parser.add_argument("--column", default="observation.tactile.forearm")
    given = parser.parse_args()
    opened = ub.Dataset(given.set)
    ways = {
        "underbrush, open and read": lambda: ours(given.set, given.column),
        "underbrush, read": lambda: opened.column(given.column, "float32"),
        "Polars": lambda: theirs(given.set, given.column),
    }
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
    arrays = {}
    for _ in range(given.runs):
        for name, way in ways.items():
            start, used = time.perf_counter(), time.process_time()
            arrays[name] = way()
            found[name].append((time.perf_counter() - start, time.process_time() - used))
    first, *others = arrays.values()
    assert all(np.array_equal(first, other) for other in others)
    print(f"{given.column}: {first.shape} {first.dtype}")
    for name, times in found.items():
        wall, cpu = (1e3 * min(column) for column in zip(*times, strict=True))
        print(f"{name:26} {wall:6.0f} ms, processor time {cpu:6.0f} ms")


if __name__ == "__main__":
    main()
