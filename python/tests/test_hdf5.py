"""HDF5 files, read back with h5py itself."""

from __future__ import annotations

import csv
import errno
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import underbrush as ub
import underbrush.hdf5

h5py = pytest.importorskip("h5py")


def test_every_number_of_a_reach_comes_back(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that tables, attributes and rewards are those of the reaches, in the shapes that robomimic reads."""
    path = tmp_path / "reaches.hdf5"
    underbrush.hdf5.export(data, path)
    with h5py.File(path) as file:
        assert file["data"].attrs["total"] == sum(len(reach) for reach in data)
        assert json.loads(file["data"].attrs["env_args"])["type"] == 2
        for number, reach in enumerate(data):
            own = file[f"data/demo_{number}"]
            columns = {
                "actions": "action",
                "obs/joint_pos": "observation.state",
                "obs/joint_vel": "observation.velocity",
                "obs/joint_torque": "observation.torque",
                "obs/goal_pos": "goal_position",
            }
            for name, column in columns.items():
                assert own[name].dtype == np.float64 and own[name].chunks is not None
                assert np.array_equal(own[name], reach.column(column)), name
            state, velocity = reach.column("observation.state"), reach.column("observation.velocity")
            assert np.array_equal(own["states"], np.hstack([state, velocity]))
            assert np.array_equal(np.hstack([own["obs/eef_pos"], own["obs/eef_quat"]]), reach.column("observation.tip_pose"))
            for patch in reach.skin.patches:
                assert np.array_equal(own[f"obs/tactile_{patch}"], reach.sensed_force_n(patch))
            reached = [goal["end_time_s"] for goal in reach.goals if goal["outcome"] == "reached"]
            frames = np.flatnonzero(own["rewards"])
            assert len(frames) == len(reached)
            assert np.allclose(reach.time_s[frames], reached, atol=0.02)
            assert np.flatnonzero(own["dones"]).tolist() == [len(reach) - 1]
            assert (own.attrs["num_samples"], own.attrs["scene"]) == (len(reach), reach.scene)
            assert (own.attrs["seed"], own.attrs["reach_index"]) == reach.seed_and_index
            assert (own.attrs["controller"], own.attrs["outcome"]) == (reach.controller, reach.outcome)


def test_a_reward_is_in_the_last_frame_of_its_goal(tmp_path: Path) -> None:
    """Tests that the hand is within 1 cm of the goal of the frame in each frame with a reward, and in no frame before it."""
    underbrush.hdf5.export(ub.reach(ub.Scene("leaf").changed({"goals": {"count": 2}}), 1), tmp_path / "one.hdf5")
    with h5py.File(tmp_path / "one.hdf5") as file:
        own = file["data/demo_0"]
        distance_m = np.linalg.norm(own["obs/eef_pos"][()] - own["obs/goal_pos"][()], axis=1)
        rewarded = np.flatnonzero(own["rewards"])
    assert len(rewarded) == 2 and rewarded.tolist() == np.flatnonzero(distance_m < 0.01).tolist()


@pytest.mark.parametrize("count", [1, 2, 9, 12])
def test_demonstrations_are_split(data: ub.Dataset, tmp_path: Path, count: int) -> None:
    """Tests that every tenth demonstration is in valid, of two to nine the last, and all in the mask of their scene."""
    reach = data[0]
    path = tmp_path / "reaches.hdf5"
    underbrush.hdf5.export([reach] * count, path)
    with h5py.File(path) as file:
        masks = {name: [int(demo.decode().removeprefix("demo_")) for demo in mask[()]] for name, mask in file["mask"].items()}
    valid = [9] if count == 12 else [count - 1] if count > 1 else []
    assert masks.pop("valid", []) == valid
    assert masks.pop("train") == [number for number in range(count) if number not in valid]
    assert masks == {reach.scene: list(range(count))}
    assert underbrush.hdf5._masks(["train"])["train-scene"] == [0]


def test_one_reach_is_a_demonstration(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that a single reach is exported without a list around it."""
    underbrush.hdf5.export(data[0], tmp_path / "one.hdf5")
    with h5py.File(tmp_path / "one.hdf5") as file:
        assert list(file["data"]) == ["demo_0"] and file["data"].attrs["total"] == len(data[0])


def test_a_file_appears_only_when_it_is_complete(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that a failed export leaves nothing, that only force overwrites, and that the bytes are the same again."""
    path = tmp_path / "reaches.hdf5"

    def failing() -> object:
        yield data[0]
        raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        underbrush.hdf5.export(failing(), path)  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []
    assert underbrush.hdf5.main(["export", str(data.path), "--out", str(path)]) == 0
    once = path.read_bytes()
    with pytest.raises(ub.InputError, match="exists already"):
        underbrush.hdf5.export(data, path)
    underbrush.hdf5.export(data, path, force=True)
    assert path.read_bytes() == once
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_a_full_disk_is_an_error(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that an export that cannot write its whole file says so and leaves nothing. A limit for files stands for the disk."""
    pytest.importorskip("resource")
    limited = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))"
    run = "import sys, underbrush.hdf5; sys.exit(underbrush.hdf5.main(sys.argv[1:]))"
    command = [sys.executable, "-P", "-c", f"{limited}; {run}", "export", str(data.path), "--out", str(tmp_path / "set.hdf5")]
    found = subprocess.run(command, capture_output=True, text=True)
    assert (found.returncode, found.stderr) == (1, f"error: {OSError(errno.EFBIG, os.strerror(errno.EFBIG))}\n")
    assert list(tmp_path.iterdir()) == []


def test_forces_become_csv(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that forces, times and categories come back from the CSV file, one reach for each demonstration by number."""
    path, table = tmp_path / "reaches.hdf5", tmp_path / "log.csv"
    reaches = [data[index % len(data)] for index in range(11)]
    underbrush.hdf5.export(reaches, path)
    forces = "data/*/obs/tactile_forearm"
    arguments = ["csv", str(path), "--forces", forces, "--times", "data/*/rewards", "--category", "scene", "--out", str(table)]
    assert underbrush.hdf5.main(arguments) == 0
    with open(table, newline="", encoding="utf-8") as text:
        header, *rows = csv.reader(text)
    taxels = reaches[0].skin.taxels("forearm")
    assert header == ["reach", "time", "category", *(f"force_{taxel}" for taxel in range(taxels))]
    for number, reach in enumerate(reaches):
        own = [row for row in rows if row[0] == str(number)]
        assert np.array_equal(np.array([row[3:] for row in own], dtype=float), reach.sensed_force_n("forearm"))
        assert {row[2] for row in own} == {reach.scene}
    assert underbrush.hdf5.csv_of(path, table, "data/demo_3/obs/tactile_forearm", force=True) == 1


def test_channels_become_columns(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that a dataset of several numbers and one of a single number become columns beside the forces."""
    path, table = tmp_path / "reaches.hdf5", tmp_path / "log.csv"
    underbrush.hdf5.export([data[0]], path)
    with h5py.File(path, "a") as file:
        file["data/demo_0/obs/heat"] = np.linspace(20.0, 21.0, len(data[0]))
    channels = [part for text in ("angle=data/*/obs/joint_pos", "heat=data/*/obs/heat") for part in ("--channel", text)]
    forces = ["--forces", "data/*/obs/tactile_forearm", "--out", str(table)]
    assert underbrush.hdf5.main(["csv", str(path), *forces, *channels]) == 0
    with open(table, newline="", encoding="utf-8") as text:
        header, *rows = csv.reader(text)
    first = 1 + data.skin.taxels("forearm")
    assert header[first:] == [*(f"angle_{joint}" for joint in range(7)), "heat"]
    numbers = np.array([row[first:] for row in rows], dtype=float)
    assert np.array_equal(numbers[:, -1], np.linspace(20.0, 21.0, len(data[0])))
    assert np.allclose(numbers[:, :-1], data[0].joint_angle_rad, atol=1e-6)


def test_what_is_not_in_the_file_is_named(tmp_path: Path) -> None:
    """Tests that missing datasets, other types and shapes, columns of one name, and files that are not HDF5 are errors that say so."""
    path, out = tmp_path / "log.h5", tmp_path / "log.csv"
    with h5py.File(path, "w") as file:
        file["run/a/force"] = np.zeros((3, 2))
        file["run/b/force"] = np.zeros((3, 3))
        file["run/a/text"] = ["x"]
        file["run/a/cube"] = np.zeros((2, 2, 2))
        file["run/a/short"] = np.zeros(2)
        file["run/a/heat"] = np.zeros(3)
    cases = [
        ({"forces": "run/*/skin"}, "run/\\*/skin: found no such dataset"),
        ({"forces": "run/a"}, "'run/a', which is no dataset"),
        ({"forces": "run/a/text"}, "of shape \\(1,\\); allowed: numbers"),
        ({"forces": "run/a/cube"}, "of shape \\(2, 2, 2\\)"),
        ({"forces": "run/*/force"}, "\\(3, 3\\) numbers in b; allowed: \\(3, 2\\)"),
        ({"forces": "run/a/force", "channels": {"heat": "run/a/short"}}, "run/a/short: found \\(2, 1\\)"),
        ({"forces": "run/a/force", "channels": {"time": "run/a/short"}}, "names other than reach, time"),
        ({"forces": "run/a/force", "channels": {"force_1": "run/a/heat"}}, "two columns called force_1"),
        ({"forces": "run/a/force", "times": "run/a/short"}, "one time for each frame"),
        ({"forces": "run/a/force", "category": "label"}, "category: found 'label'"),
    ]
    for given, reason in cases:
        with pytest.raises(ub.InputError, match=reason):
            underbrush.hdf5.csv_of(path, out, **given)
    twice = ["--channel", "heat=run/a/heat", "--channel", "heat=run/a/force"]
    assert underbrush.hdf5.main(["csv", str(path), "--forces", "run/a/force", "--out", str(out), *twice]) == 2
    path.write_text("no HDF5")
    with pytest.raises(ub.InputError, match="a readable HDF5 file"):
        underbrush.hdf5.csv_of(path, out, "force")
    assert not out.exists()
