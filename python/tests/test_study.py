"""Inspecting files, regression suites, and whole studies: the same results and bytes as on the command line."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT, quick

import underbrush as ub
from underbrush import _core

SUITE = """summary = "A leaf is still a leaf"
seed = 1
[[scenes]]
scene = "leaf-quick.toml"
reaches = 2
[scenes.bounds]
goals_reached = {}
mean_force_n.leaf = { at_least = 0.0, at_most = 0.001 }
"""


def test_inspect_says_what_the_command_line_says(data: ub.Dataset, trials: ub.Trials, tmp_path: Path, command) -> None:
    """Tests that every kind of file is inspected with the command line's result, and that other files are refused."""
    scene, model, table = tmp_path / "leaf.toml", tmp_path / "model.json", tmp_path / "trials.csv"
    scene.write_text(quick("leaf").text)
    ub.fit(trials, "logistic-taxel").save(model)
    command("trials", data.path, "--out", table)
    data[0].save(tmp_path / "reach.parquet")
    for path in (scene, data.path, tmp_path / "reach.parquet", model, table):
        found = ub.inspect(path)
        assert found == command("inspect", path) and found["check"].startswith("sound"), path
    assert ub.inspect(scene, seed=2) == command("inspect", scene, "--seed", 2)
    (tmp_path / "notes.txt").write_text("no data")
    for name in ("notes.txt", "missing.toml"):
        with pytest.raises(ub.InputError, match=name):
            ub.inspect(tmp_path / name)


def suite(folder: Path) -> Path:
    folder.mkdir()
    (folder / "leaf-quick.toml").write_text(quick("leaf").text)
    file = folder / "leaf.toml"
    file.write_text(SUITE)
    return file


def test_suites_are_checked_as_by_the_command_line(tmp_path: Path, command) -> None:
    """Tests that blessing writes the command line's bounds, that the results and both result files equal the command
    line's, and that a broken bound is a result and not an error."""
    ours, theirs = suite(tmp_path / "ours"), suite(tmp_path / "theirs")
    broken = ub.check(ours, progress=False)
    verdicts = {bound["name"]: bound["verdict"] for bound in broken["suites"][0]["scenes"][0]["bounds"]}
    assert not broken["passed"] and verdicts["mean_force_n.leaf"] == "too_large"
    seen: list[tuple[int, int]] = []
    blessed = ub.check([ours], bless=True, progress=lambda done, total, text: seen.append((done, total)))
    assert blessed["passed"] and seen[-1] == (2, 2)
    assert blessed == at(command("check", theirs, "--bless"), ours)
    assert ours.read_text() == theirs.read_text() != SUITE
    again = ub.check(ours, out=tmp_path / "out", progress=False, jobs=1)
    assert again == blessed == json.loads((tmp_path / "out" / "results.json").read_text())
    command("check", ours, "--out", tmp_path / "cli")
    for name in ("results.json", "junit.xml"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "cli" / name).read_bytes()
    with pytest.raises(ub.InputError, match="seed"):
        ub.check(ours, bless=True, seed=2)
    with pytest.raises(ub.InputError, match="suites"):
        ub.check([])


def test_an_interrupted_suite_is_not_blessed(tmp_path: Path) -> None:
    """Tests that Ctrl-C ends a check, which then writes neither bounds nor results."""
    file = suite(tmp_path / "suite")

    def interrupt(done: int, total: int, text: str) -> None:
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        ub.check(file, bless=True, out=tmp_path / "out", progress=interrupt)
    assert file.read_text() == SUITE and not (tmp_path / "out" / "results.json").exists()


def at(found: dict[str, Any], file: Path) -> dict[str, Any]:
    """The results of a suite as if its scenes were in the folder of this file."""
    for scene in found["suites"][0]["scenes"]:
        scene["file"] = str(file.parent / Path(scene["file"]).name)
    return found


def test_a_study_is_that_of_the_command_line(tmp_path: Path, command) -> None:
    """Tests that an experiment that Ctrl-C ended and that was continued writes the command line's data, models, trials
    and tables, byte for byte, that another experiment cannot continue in its folder, and that progress is reported."""
    folder = tmp_path / "experiment"
    folder.mkdir()
    example = ROOT / "experiments" / "examples" / "three-categories"
    for file in example.iterdir():
        text = file.read_text().replace("../../../docs/arms/panda/panda.toml", str(ROOT / "docs/arms/panda/panda.toml"))
        for old, new in (
            ("reaches = 12", "reaches = 5\nsetting_reaches = 3"),
            ("states = [5, 10]", "states = [4, 5]"),
            ("truncations = [50, 10]", "truncations = [5]"),
            ("states = 10", "states = 5"),
        ):
            text = text.replace(old, new)
        (folder / file.name).write_text(text)
    experiment = folder / "three-categories.toml"
    seen: list[tuple[int, int]] = []

    def interrupt(done: int, total: int, text: str) -> None:
        if done >= 2:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        ub.reproduce(tmp_path / "ours", experiment=experiment, progress=interrupt)
    assert not (tmp_path / "ours" / "summary.json").exists()
    found = ub.reproduce(
        tmp_path / "ours", experiment=experiment, progress=lambda done, total, text: seen.append((done, total))
    )
    theirs = command("reproduce", "--experiment", experiment, "--out", tmp_path / "theirs")
    # Wall times differ.
    assert {**found, "timing": None} == {**theirs, "timing": None} and seen
    same = [path for path in (tmp_path / "theirs").rglob("*") if path.is_file() and path.suffix in (".parquet", ".csv")]
    same += [tmp_path / "theirs" / "model.json", tmp_path / "theirs" / "report" / "replay.html"]
    for path in same:
        if path.exists() and path.name != "stage_times.csv":
            assert path.read_bytes() == (tmp_path / "ours" / path.relative_to(tmp_path / "theirs")).read_bytes(), path
    assert len(same) > 10
    with pytest.raises(ub.InputError, match="another run"):
        ub.reproduce(tmp_path / "ours", quick=True)
    # The result of a campaign that was run by itself, as on another machine, is used and not computed again.
    _core.run_campaign(tmp_path / "ours", 1, experiment=experiment)
    [kept] = (tmp_path / "ours" / "campaigns").glob("seed-*.json")
    before = kept.read_bytes(), kept.stat().st_mtime_ns
    two = ub.reproduce(tmp_path / "ours", experiment=experiment, campaigns=2, progress=False)
    assert (kept.read_bytes(), kept.stat().st_mtime_ns) == before and len(two["campaigns"]["seeds"]) == 2
    again = ub.reproduce(tmp_path / "theirs", experiment=experiment, campaigns=2, progress=False)
    assert two["campaigns"] == again["campaigns"]
    with pytest.raises(ub.InputError, match="campaigns"):
        ub.reproduce(tmp_path / "other", campaigns=0)
