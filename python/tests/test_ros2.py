"""Bags of ROS 2, read back with rosbags and, independently of what wrote them, with the decoder of mcap-ros2-support."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import underbrush as ub
import underbrush.mcap
import underbrush.ros2

from conftest import QUICK, ROOT, quick

rosbag2 = pytest.importorskip("rosbags.rosbag2")
mcap = pytest.importorskip("mcap.reader")
ros2 = pytest.importorskip("mcap_ros2.decoder")

URDF = '<robot name="one"><link name="base"/></robot>'


@pytest.fixture(scope="module")
def reach(data: ub.Dataset) -> ub.Reach:
    return data[0]


@pytest.fixture(scope="module")
def bag(reach: ub.Reach, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("ros2")
    (folder / "arm.urdf").write_text(URDF)
    underbrush.ros2.export(reach, folder / "bag", urdf=folder / "arm.urdf")
    return folder / "bag"


@pytest.fixture(scope="module")
def decoded(bag: Path) -> dict[str, list[tuple[int, Any]]]:
    """The times, ns, and messages of each topic, by the independent decoder."""
    topics: dict[str, list[tuple[int, Any]]] = {}
    with open(bag / "bag.mcap", "rb") as file:
        reader = mcap.make_reader(file, validate_crcs=True, decoder_factories=[ros2.DecoderFactory()])
        for found in reader.iter_decoded_messages():
            topics.setdefault(found.channel.topic, []).append((found.message.log_time, found.decoded_message))
    return topics


def test_the_bag_is_whole(bag: Path, reach: ub.Reach) -> None:
    """Tests that rosbags finds every topic, with as many messages as the reach has frames, all in CDR."""
    with rosbag2.Reader(bag) as reader:
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
        read = sum(1 for _ in reader.messages())
    each_frame = ["/joint_states", "/equilibrium", "/tf"]
    for patch in reach.skin.layout["patches"]:
        name = patch["name"]
        each_frame += [f"/skin/{name}", f"/skin/{name}/pressed", f"/truth/contact_force/{name}"]
    assert {topic: counts.pop(topic) for topic in each_frame} == dict.fromkeys(each_frame, len(reach))
    assert counts.pop("/goal") == len(reach.goals)
    assert counts == {"/scene": 1, "/robot_description": 1}
    assert read == len(reach) * len(each_frame) + len(reach.goals) + 2
    assert (bag / "robot.urdf").read_text() == URDF


def test_joints_forces_and_contacts_come_back(decoded: dict[str, list[tuple[int, Any]]], reach: ub.Reach) -> None:
    """Tests the numbers of joints, taxels and contact forces, at their times."""
    times = [round(time_s * 1e9) for time_s in reach.time_s]
    assert [time for time, _ in decoded["/joint_states"]] == times
    positions = [message.position for _, message in decoded["/joint_states"]]
    assert np.array_equal(positions, reach.column("observation.state"))
    for patch in reach.skin.layout["patches"]:
        name, places = patch["name"], reach.skin.positions_link(patch["name"])
        forces_n = reach.sensed_force_n(name)
        grids = decoded[f"/skin/{name}"]
        assert np.array_equal([message.data for _, message in grids], forces_n)
        assert int(np.prod([dimension.size for dimension in grids[0][1].layout.dim])) == len(places)
        for (_, cloud), own in zip(decoded[f"/skin/{name}/pressed"], forces_n, strict=True):
            taxels = np.flatnonzero(own > 0)
            points = np.frombuffer(bytes(cloud.data), "<f4").reshape(-1, 4)
            assert np.allclose(points, np.column_stack([places[taxels], own[taxels]]), atol=1e-6)
            assert cloud.header.frame_id == patch["link"] and cloud.width == len(taxels)
        wrenches = [message.wrench.force for _, message in decoded[f"/truth/contact_force/{name}"]]
        found = [[force.x, force.y, force.z] for force in wrenches]
        assert np.array_equal(found, reach.column(f"truth.contact_force.{name}"))
    assert max(reach.sensed_force_n(patch["name"]).max() for patch in reach.skin.layout["patches"]) > 0.03


def test_every_shape_has_a_frame(decoded: dict[str, list[tuple[int, Any]]], reach: ub.Reach) -> None:
    """Tests that the frame of every marker is in the transforms of the first frame, with the pose of its body."""
    (_, scene), (_, first) = decoded["/scene"][0], decoded["/tf"][0]
    frames = {one.child_frame_id: one.transform.translation for one in first.transforms}
    assert {marker.header.frame_id for marker in scene.markers} <= set(frames)
    assert len(scene.markers) >= sum(1 for body in reach.bodies if body["parts"])
    for body, found in zip(reach.bodies, frames.values(), strict=True):
        moved = len(body["moved_frames"]) > 0 and body["moved_frames"][0] == 0
        expected = body["poses_world"][0][:3] if moved else body["rest_pose_world"]["position"]
        assert np.allclose([found.x, found.y, found.z], expected, atol=1e-12)


def test_a_category_of_a_scene_is_exported(tmp_path: Path) -> None:
    """Tests that a scene with a category that is not built in becomes a bag."""
    underbrush.ros2.export(ub.reach(quick("bottle"), 1), tmp_path / "bag")
    assert (tmp_path / "bag" / "metadata.yaml").exists()


def test_nothing_else_is_overwritten(reach: ub.Reach, tmp_path: Path) -> None:
    """Tests that a bag is replaced only with ``force``, and that a folder which is no bag is never removed."""
    underbrush.ros2.export(reach, tmp_path / "bag")
    with pytest.raises(ub.InputError, match="exists already"):
        underbrush.ros2.export(reach, tmp_path / "bag")
    underbrush.ros2.export(reach, tmp_path / "bag", force=True)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "thesis.txt").write_text("years of work")
    with pytest.raises(ub.InputError, match="choose another name"):
        underbrush.ros2.export(reach, tmp_path / "other", force=True)
    assert (tmp_path / "other" / "thesis.txt").exists()


def test_two_exports_are_not_mixed(reach: ub.Reach, tmp_path: Path) -> None:
    """Tests that bags of an earlier export are refused, or all removed with ``force``, and none if a folder among them is no bag."""
    underbrush.ros2.export([reach, reach], tmp_path)
    with pytest.raises(ub.InputError, match="reach-000000: exists already"):
        underbrush.ros2.export([reach], tmp_path)
    (tmp_path / "reach-000000.mcap").write_text("of another tool")
    underbrush.ros2.export([reach], tmp_path, force=True)
    assert sorted(own.name for own in tmp_path.iterdir()) == ["reach-000000", "reach-000000.mcap"]
    (tmp_path / "reach-000001").mkdir()
    with pytest.raises(ub.InputError, match="reach-000001: exists already; choose another name"):
        underbrush.ros2.export([reach], tmp_path, force=True)
    assert (tmp_path / "reach-000000" / "metadata.yaml").exists()


def test_a_data_set_has_the_urdf_of_its_arm(tmp_path: Path) -> None:
    """Tests that the bags of a data set hold the URDF of its arm, also those that the command writes, and another URDF if it is given."""
    cody = (ROOT / "sim" / "arms" / "cody" / "cody.urdf").read_text()
    one = ub.generate(quick("leaf"), 1, tmp_path / "one", seed=1, progress=False)
    underbrush.ros2.export(one, tmp_path / "bags")
    assert (tmp_path / "bags" / "reach-000000" / "robot.urdf").read_text() == cody
    (tmp_path / "other.urdf").write_text(URDF)
    for options, urdf in (([], cody), (["--urdf", str(tmp_path / "other.urdf"), "--force"], URDF)):
        assert underbrush.ros2.main(["export", str(one.path), "--out", str(tmp_path / "bag"), *options]) == 0
        assert (tmp_path / "bag" / "robot.urdf").read_text() == urdf
        with rosbag2.Reader(tmp_path / "bag") as reader:
            assert "/robot_description" in {connection.topic for connection in reader.connections}


def test_a_urdf_that_cannot_be_read_is_refused(reach: ub.Reach, tmp_path: Path) -> None:
    """Tests that a missing URDF, a folder and a file that is no text are errors that name it, and that nothing is written."""
    (tmp_path / "binary.urdf").write_bytes(b"\xff\xff")
    for urdf in ("nowhere.urdf", "binary.urdf", "."):
        with pytest.raises(ub.InputError, match="urdf: found"):
            underbrush.ros2.export(reach, tmp_path / "bag", urdf=tmp_path / urdf)
    assert not (tmp_path / "bag").exists()


def test_a_recording_of_the_arm_that_ships_has_its_urdf(reach: ub.Reach, tmp_path: Path) -> None:
    """Tests that the bag of one recording holds Cody's URDF if the arm is Cody's, and none if the skin is another's."""
    reach.save(tmp_path / "reach.parquet")
    assert underbrush.ros2.main(["export", str(tmp_path / "reach.parquet"), "--out", str(tmp_path / "bag")]) == 0
    assert (tmp_path / "bag" / "robot.urdf").read_text() == (ROOT / "sim" / "arms" / "cody" / "cody.urdf").read_text()
    scene = ROOT / "benchmarks" / "incidental-contact-1" / "scenes" / "other-arm" / "other-arm.toml"
    other = ub.reach(ub.Scene(scene).changed(QUICK, name="other"))
    underbrush.ros2.export(other, tmp_path / "other")
    assert not (tmp_path / "other" / "robot.urdf").exists()


def test_a_bag_becomes_csv(bag: Path, reach: ub.Reach, tmp_path: Path) -> None:
    """Tests that the folder of a bag gives the forces in its file, and that a folder with two files is refused."""
    out, two = tmp_path / "log.csv", tmp_path / "two"
    assert underbrush.mcap.main(["csv", str(bag), "--topic", "/skin/forearm", "--out", str(out)]) == 0
    forces_n = np.loadtxt(out, delimiter=",", skiprows=1)[:, 1:]
    assert np.array_equal(forces_n, reach.sensed_force_n("forearm", dtype="float32"))
    two.mkdir()
    for name in ("a.mcap", "b.mcap"):
        (two / name).touch()
    with pytest.raises(ub.InputError, match="found 2 files .mcap; allowed: one"):
        underbrush.mcap.csv_of(two, out, "/skin/forearm", force=True)
