"""The benchmark: the command line's rows, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

import underbrush as ub
from underbrush import _core


def test_a_row_is_that_of_the_command_line(tmp_path: Path, command) -> None:
    """Tests that Python and the command line write the same bytes, even if the set was made in parts, and that the
    result is what the command line prints."""
    options = {"controller": "cody-2013", "quick": True}
    found = ub.benchmark("reaching", tmp_path / "ours", progress=False, **options)
    theirs = command("benchmark", "reaching", "--controller", "cody-2013", "--quick", "--out", tmp_path / "theirs")
    assert found == theirs and found["entry"]["name"] == "cody-2013" and not found["complete"]
    [(folder, reaches), (audit, _)] = _core.benchmark_sets("reaching", out=tmp_path / "parts", **options)
    assert folder.name == "reaching-public-cody-2013" and audit.name == "reaching-audit-cody-2013"
    assert reaches == 2 and folder.is_relative_to(tmp_path / "parts" / "quick-sets")
    parts = [tmp_path / f"part-{number}" for number in (1, 2)]
    for number, part in enumerate(parts, 1):
        _core.benchmark_part(0, part, track="reaching", shard=(number, 2), **options)
    folder.parent.mkdir(parents=True)
    ub.merge(parts, folder)
    ub.benchmark("reaching", tmp_path / "parts", progress=False, **options)
    rows = [tmp_path / out / "quick-rows" / "reaching-cody-2013.json" for out in ("ours", "theirs", "parts")]
    assert len({row.read_bytes() for row in rows}) == 1


class Still:
    """A controller that keeps the arm where it is."""

    name = "still"

    def __call__(self, given: ub.ControllerInput) -> object:
        return given.equilibrium_angle_rad


def test_a_controller_of_ones_own_has_a_row(tmp_path: Path) -> None:
    """Tests that a controller written in Python is judged under its name. One that does nothing reaches no goal and
    presses on no trunk."""
    row = ub.benchmark("reaching", tmp_path, controller=Still(), quick=True, progress=False)
    assert row["entry"]["name"] == "still"
    halves = row["figures"]["reaching"]
    assert halves["ranking"]["audit"]["value"] == 0.0
    for figures in (halves["public"], halves["audit"]):
        assert figures["reached"]["value"] == 0.0 and figures["largest_on_trunk_n"] == 0.0
        assert figures["seconds_for_each"]["value"] is None


def test_what_does_not_go_with_a_track_is_refused(tmp_path: Path) -> None:
    """Tests that arguments that do not belong to a track are refused by name, and that nothing is written."""
    for track, options, argument in (
        ("speed", {}, "track"),
        ("verdicts", {}, "model"),
        ("verdicts", {"controller": "blind"}, "controller"),
        ("reaching", {}, "controller"),
        ("reaching", {"model": "touch.json", "controller": "blind"}, "model"),
        ("reaching", {"controller": "cody-2013", "verdicts": "truth"}, "verdicts: found truth; allowed: what a robot can sense"),
    ):
        with pytest.raises(ub.InputError, match=argument):
            ub.benchmark(track, tmp_path, progress=False, **options)
    with pytest.raises(IndexError):
        _core.benchmark_part(2, tmp_path / "part", track="reaching", shard=(1, 2), controller="blind")
    assert list(tmp_path.iterdir()) == []
