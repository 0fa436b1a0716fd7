"""Compares two controllers on the same reaches of the benchmark's track `reaching`, with paired 95 % intervals.

    underbrush benchmark reaching --controller cody-2013
    underbrush benchmark reaching --controller cody-2013 --verdicts touch.json
    python3 benches/paired_reaching.py out/benchmark/sets/reaching-public-cody-2013 \\
        out/benchmark/sets/reaching-public-cody-2013+verdicts-HASH

Prints both values of each figure, and the second minus the first, from 2,000 resamples of whole reaches. Needs NumPy and
polars.
"""

import argparse
from pathlib import Path

import numpy as np
import polars as pl

# A goal counts if it is reached and no force between an object and one patch, or one bare link, was above this on the way.
LARGEST_FORCE_N = 5.0
RESAMPLES = 2000
FORCE = ["force_world_x_n", "force_world_y_n", "force_world_z_n"]
FIGURES = ["goals without more than 5 N on a trunk, %", "goals reached, %", "time for each goal reached, s", "peak on a trunk, mean, N"]


def table(folder: Path, name: str) -> pl.DataFrame:
    """A table of a data set."""
    return pl.read_parquet(folder / name / "**/*.parquet")


def forces_on_trunks(folder: Path) -> pl.DataFrame:
    """The largest force on a trunk on the way to each goal, N."""
    frame, place = ["episode_index", "frame_index"], ["link", "patch", "object_index"]
    trunks = table(folder, "truth/objects").filter(pl.col("category") == "trunk")
    points = table(folder, "truth/contact_points").join(trunks, on=["episode_index", "object_index"], how="semi")
    points = points.with_columns(pl.col("patch").fill_null(""))
    forces = points.group_by(frame + place).agg(pl.col(FORCE).sum())
    force_n = pl.sum_horizontal(pl.col(FORCE) ** 2).sqrt().alias("peak_n")
    goals = table(folder, "data").select([*frame, "goal_index"])
    return forces.join(goals, on=frame).group_by("episode_index", "goal_index").agg(force_n.max())


def reaches(folder: Path) -> np.ndarray:
    """For each reach: goals that count, goals reached, seconds for all, goals, and the largest force on a trunk, N."""
    goals = table(folder, "truth/goals")
    goals = goals.join(forces_on_trunks(folder), on=["episode_index", "goal_index"], how="left")
    reached, peak_n = pl.col("outcome") == "reached", pl.col("peak_n").fill_null(0.0)
    seconds = pl.col("end_time_s") - pl.col("start_time_s")
    counted = (reached & (peak_n <= LARGEST_FORCE_N)).sum()
    sums = [counted.alias("counted"), reached.sum().alias("reached"), seconds.sum().alias("s"), pl.len().alias("goals")]
    by_reach = goals.group_by("episode_index").agg(*sums, peak_n.max().alias("peak_n")).sort("episode_index")
    # Goals that were not tried because of a safety stop count as not reached.
    return by_reach.with_columns(pl.col("goals").max()).drop("episode_index").to_numpy().astype(float)


def figures(own: np.ndarray) -> np.ndarray:
    """The figures of some reaches."""
    counted, reached, seconds, goals, peak_n = own.sum(axis=0)
    return np.array([100 * counted / goals, 100 * reached / goals, seconds / reached, peak_n / len(own)])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("first", type=Path, help="data set of the first controller")
    parser.add_argument("second", type=Path, help="data set of the second controller, on the same reaches")
    arguments = parser.parse_args()
    first, second = reaches(arguments.first), reaches(arguments.second)
    if len(first) != len(second):
        parser.error(f"{len(first)} and {len(second)} reaches; give two sets of the same reaches")
    draws = np.random.default_rng(0).integers(0, len(first), (RESAMPLES, len(first)))
    differences = np.array([figures(second[draw]) - figures(first[draw]) for draw in draws])
    low, high = np.percentile(differences, [2.5, 97.5], axis=0)
    print(f"{len(first)} reaches")
    for place, name in enumerate(FIGURES):
        one, other = figures(first)[place], figures(second)[place]
        print(f"{name:41} {one:6.2f} {other:6.2f} {other - one:+6.2f} ({low[place]:+.2f} to {high[place]:+.2f})")


if __name__ == "__main__":
    main()
