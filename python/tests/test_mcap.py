"""MCAP files, read back with the readers of mcap and of ROS 2's messages."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import quick

import underbrush as ub
import underbrush.mcap

mcap = pytest.importorskip("mcap.reader")
mcap_writer = pytest.importorskip("mcap.writer")
ros2 = pytest.importorskip("mcap_ros2.decoder")


def messages(path: Path, topic: str) -> list[tuple[int, Any]]:
    """The times, ns, and contents of the messages of a topic."""
    with open(path, "rb") as file:
        reader = mcap.make_reader(file, validate_crcs=True, decoder_factories=[ros2.DecoderFactory()])
        if topic.startswith(("/joint", "/equi")):
            return [(found.message.log_time, found.decoded_message) for found in reader.iter_decoded_messages([topic])]
        return [(message.log_time, json.loads(message.data)) for _, _, message in reader.iter_messages([topic])]


def doubles(message: dict[str, Any]) -> np.ndarray[Any, Any]:
    """The doubles of packed data."""
    return np.frombuffer(base64.b64decode(message["data"]), "<f8")


@pytest.fixture(scope="module")
def reach(data: ub.Dataset) -> ub.Reach:
    return data[0]


@pytest.fixture(scope="module")
def path(reach: ub.Reach, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("mcap") / "reach.mcap"
    underbrush.mcap.export(reach, path)
    return path


def test_joints_and_forces_come_back_exactly(reach: ub.Reach, path: Path) -> None:
    """Tests that joint states and forces come back in full precision, at their times."""
    times = [round(time_s * 1e9) for time_s in reach.time_s]
    for topic, columns in (
        ("/joint_states", {"position": "observation.state", "velocity": "observation.velocity", "effort": "observation.torque"}),
        ("/equilibrium", {"position": "action"}),
    ):
        found = messages(path, topic)
        assert [time for time, _ in found] == times
        assert [state.header.stamp.sec * 10**9 + state.header.stamp.nanosec for _, state in found] == times
        assert all(state.name == reach.joint_names and state.header.frame_id == "" for _, state in found)
        for field in ("position", "velocity", "effort"):
            numbers = np.array([getattr(state, field) for _, state in found])
            expected = reach.column(columns[field]) if field in columns else np.zeros((len(reach), 0))
            assert np.array_equal(numbers, expected), field
    for patch in reach.skin.layout["patches"]:
        forces_n = reach.sensed_force_n(patch["name"], dtype="float64")
        pressed = messages(path, f"/skin/{patch['name']}/pressed")
        assert [time for time, _ in pressed] == times
        for (_, cloud), own in zip(pressed, forces_n, strict=True):
            taxels = np.flatnonzero(own > 0)
            places = reach.skin.positions_link(patch["name"])[taxels]
            assert np.array_equal(doubles(cloud).reshape(-1, 4), np.column_stack([places, own[taxels]]))
            assert (cloud["frame_id"], cloud["point_stride"]) == (patch["link"], 32)
        if patch["grid"] is not None:
            grids = messages(path, f"/skin/{patch['name']}")
            assert np.array_equal([doubles(grid) for _, grid in grids], forces_n)
            columns_of = {(grid["column_count"], grid["row_stride"], grid["cell_stride"]) for _, grid in grids}
            assert columns_of == {(patch["grid"]["columns"], 8 * patch["grid"]["columns"], 8)}
    assert reach.sensed_force_n("forearm").max() > 0.03


def test_poses_shapes_and_goals_come_back(reach: ub.Reach, path: Path) -> None:
    """Tests that the poses of all bodies can be followed from the transforms, that all poses are sent again at regular
    intervals, and that shapes and goals are in the scene."""
    poses: dict[str, list[float]] = {}
    bodies = reach.bodies
    ids = underbrush.mcap._frame_names(bodies, reach.objects)
    assert len(set(ids)) == len(bodies)
    grids = [patch for patch in reach.skin.patches if reach.skin.grid(patch) is not None]
    for frame, (_, message) in enumerate(messages(path, "/tf")):
        transforms = message["transforms"]
        assert frame % 100 != 0 or len(transforms) == len(bodies) + len(grids)
        for transform in transforms:
            assert transform["parent_frame_id"] == "world"
            position, rotation = transform["translation"], transform["rotation"]
            poses[transform["child_frame_id"]] = [*map(position.get, "xyz"), *map(rotation.get, "xyzw")]
        for body, name in zip(bodies, ids, strict=True):
            moved = np.searchsorted(body["moved_frames"], frame, side="right")
            rest = body["rest_pose_world"]
            expected = body["poses_world"][moved - 1] if moved else [*rest["position"], *rest["orientation"]]
            assert poses[name] == expected, (name, frame)
    [(_, scene)] = messages(path, "/scene")
    assert [entity["id"] for entity in scene["entities"]] == ids
    for entity, body in zip(scene["entities"], bodies, strict=True):
        kinds = [next(iter(part["shape"])) for part in body["parts"]]
        ends = 2 * kinds.count("capsule")
        assert len(entity["spheres"]) == kinds.count("sphere") + ends
        assert len(entity["cylinders"]) == kinds.count("cylinder") + kinds.count("capsule")
        assert (len(entity["cubes"]), len(entity["triangles"])) == (kinds.count("box"), kinds.count("hull"))
        if "object" in body["owner"]:
            category = reach.objects[body["owner"]["object"]]["category"]
            assert entity["metadata"] == [{"key": "category", "value": category}]
    goals = [goal["entities"][0]["spheres"][0]["pose"]["position"] for _, goal in messages(path, "/goal")]
    column = reach.column("goal_position")
    changes = [frame for frame in range(len(reach)) if frame == 0 or any(column[frame] != column[frame - 1])]
    assert [[*goal.values()] for goal in goals] == column[changes].tolist()


def test_categories_of_scenes_have_names(tmp_path: Path) -> None:
    """Tests that an object of a category that is not built in has its name, in Python and in the file."""
    reach = ub.reach(quick("bottle"), 1)
    assert "bottle" in {found["category"] for found in reach.objects}
    assert "bottle" in {found["category"] for found in quick("bottle").clutter()["objects"]}
    underbrush.mcap.export(reach, tmp_path / "bottle.mcap")
    [(_, scene)] = messages(tmp_path / "bottle.mcap", "/scene")
    assert [{"key": "category", "value": "bottle"}] in [entity["metadata"] for entity in scene["entities"]]


def test_shapes_are_those_of_foxglove() -> None:
    """Tests how a capsule that lies on its side, a box and a hull become Foxglove's shapes."""
    entity = underbrush.mcap._entity("body", "body")
    # A quarter turn about y: the capsule's z axis is the x axis of the body.
    pose = underbrush.mcap._pose((1, 2, 3), (0, np.sqrt(0.5), 0, np.sqrt(0.5)))
    underbrush.mcap._add(entity, {"capsule": {"radius_m": 0.04, "length_m": 0.2}}, pose, (1, 1, 1, 1))
    ends = [list(sphere["pose"]["position"].values()) for sphere in entity["spheres"]]
    assert np.allclose(ends, [[0.9, 2, 3], [1.1, 2, 3]])
    assert [*entity["cylinders"][0]["size"].values()] == [0.08, 0.08, 0.2]
    underbrush.mcap._add(entity, {"box": {"size_m": [1, 2, 3]}}, pose, (1, 1, 1, 1))
    assert [*entity["cubes"][0]["size"].values()] == [1, 2, 3]
    cube = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    underbrush.mcap._add(entity, {"hull": {"points_m": cube}}, pose, (1, 1, 1, 1))
    # Each face of a cube appears as the four triangles of its corners.
    assert len(entity["triangles"][0]["points"]) == 6 * 4 * 3


def test_a_link_called_world_is_no_transform(reach: ub.Reach) -> None:
    """Tests that a link that is called like the root frame does not make this frame its own parent."""
    bodies = reach.bodies
    links = [body for body in bodies if "link" in body["owner"]]
    links[0]["owner"]["link"] = "world"
    transforms = underbrush.mcap._Transforms(bodies, reach.objects, reach.skin.layout["patches"])
    children = [transform["child_frame_id"] for transform in transforms.message(0, 0)["transforms"]]
    assert children and "world" not in children


def test_the_file_has_known_schemas(reach: ub.Reach, path: Path, tmp_path: Path) -> None:
    """Tests that the file names its schemas as Foxglove and ROS 2 do, without references in them, that its messages have the
    fields of their schema, that it says what reach it is, and that it has the same bytes each time."""
    with open(path, "rb") as file:
        reader = mcap.make_reader(file)
        summary = reader.get_summary()
        [facts] = reader.iter_metadata()
        seed, index = reach.seed_and_index
        expected = {"scene": reach.scene, "seed": str(seed), "reach_index": str(index)}
        assert facts.name == "underbrush.reach"
        assert facts.metadata == expected | {"controller": reach.controller, "outcome": reach.outcome}
        for schema, _, message in reader.iter_messages():
            if schema.encoding == "jsonschema":
                check(json.loads(schema.data), json.loads(message.data))
    found = {
        channel.topic: (summary.schemas[channel.schema_id].name, channel.message_encoding)
        for channel in summary.channels.values()
    }
    topics = {
        "/joint_states": ("sensor_msgs/msg/JointState", "cdr"),
        "/equilibrium": ("sensor_msgs/msg/JointState", "cdr"),
        "/tf": ("foxglove.FrameTransforms", "json"),
        "/scene": ("foxglove.SceneUpdate", "json"),
        "/goal": ("foxglove.SceneUpdate", "json"),
    }
    for patch in reach.skin.patches:
        if reach.skin.grid(patch) is not None:
            topics[f"/skin/{patch}"] = ("foxglove.Grid", "json")
        topics[f"/skin/{patch}/pressed"] = ("foxglove.PointCloud", "json")
    assert found == topics
    for schema in summary.schemas.values():
        is_json = schema.name.startswith("foxglove")
        assert schema.encoding == ("jsonschema" if is_json else "ros2msg")
        if is_json:
            parsed = json.loads(schema.data)
            assert "$ref" not in schema.data.decode() and (parsed["title"], parsed["type"]) == (schema.name, "object")
    again = tmp_path / "again.mcap"
    underbrush.mcap.export(reach, again)
    assert again.read_bytes() == path.read_bytes()


def check(schema: dict[str, Any], value: Any) -> None:
    """Demands that a value has the type and exactly the properties of its schema."""
    kinds: dict[str, Any] = {
        "object": dict, "array": list, "string": str, "integer": int, "number": float, "boolean": bool,
    }  # fmt: skip
    assert isinstance(value, kinds[schema["type"]]), (schema, value)
    if isinstance(value, dict):
        assert set(schema.get("properties", {})) == set(value)
        for name, field in value.items():
            check(schema["properties"][name], field)
    if isinstance(value, list):
        for item in value:
            check(schema["items"], item)


def test_trials_through_mcap_are_those_of_the_reach(
    reach: ub.Reach, path: Path, command: Callable[..., Any], tmp_path: Path
) -> None:
    """Tests that the command line imports the trials that the reach has, from the CSV file of the MCAP file."""
    log, mapping, table = tmp_path / "log.csv", tmp_path / "map.toml", tmp_path / "trials.parquet"
    assert underbrush.mcap.main(["csv", str(path), "--topic", "/skin/forearm", "--field", "sensed_force_n", "--out", str(log)]) == 0
    taxels = len(reach.skin.positions_link("forearm"))
    mapping.write_text(f'[time]\nfrom = "time"\n[force]\nfrom = "force_{{taxel}}"\ntaxels = {taxels}\n')
    assert command("import", log, "--mapping", mapping, "--out", table)["frames"] == len(reach)

    def known(trials: ub.Trials) -> list[tuple[int | None, list[tuple[float, float]]]]:
        samples = [list(zip(trial.time_s.round(6), trial.force_n, strict=True)) for trial in list(trials)]
        return sorted(zip([trial.taxel for trial in trials], samples, strict=True), key=str)

    direct = known(reach.trials(patch="forearm"))
    assert len(direct) > 3 and known(ub.Trials.load(table)) == direct


def test_several_reaches_become_a_folder(data: ub.Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Tests that each reach has a file, that files of another export are refused or removed, that a failed export leaves no
    file, that no input, no folder and no file in place of a folder is overwritten, and that other objects are no reaches."""
    folder, file, recording = tmp_path / "many", tmp_path / "one.mcap", tmp_path / "reach.parquet"
    main = underbrush.mcap.main
    assert main(["export", str(data.path), "--out", str(folder)]) == 0
    names = [path.name for path in sorted(folder.iterdir())]
    assert names == [f"reach-{number:06}.mcap" for number in range(len(data))]
    data[1].save(recording)
    assert main(["export", str(recording), "--out", str(file)]) == 0
    assert file.read_bytes() == (folder / "reach-000001.mcap").read_bytes()
    for arguments in (["export", str(recording), "--out", str(file)], ["export", str(recording), str(recording), "--out", str(folder)]):
        assert main(arguments) == 2
        assert "exists already" in capsys.readouterr().err
    before = recording.read_bytes()
    assert main(["export", str(recording), "--out", str(recording), "--force"]) == 2
    assert "is an input" in capsys.readouterr().err and recording.read_bytes() == before
    assert main(["export", str(recording), "--out", str(folder), "--force"]) == 2
    assert "is a folder or not a regular file" in capsys.readouterr().err
    assert main(["export", str(data.path), "--out", str(file), "--force"]) == 2
    assert "several reaches become a folder" in capsys.readouterr().err
    assert main(["export", str(recording), str(recording), "--out", str(folder), "--force"]) == 0
    assert len(list(folder.iterdir())) == 2
    for wrong, kind in ((str(data.path), "str"), (3, "int"), ([data], "Dataset")):
        with pytest.raises(ub.InputError, match=f"reaches: found an object of type {kind}; allowed: a Reach, a Dataset"):
            underbrush.mcap.export(wrong, tmp_path / "wrong")
    assert main(["export", str(tmp_path / "nowhere"), "--out", str(tmp_path / "new.mcap")]) == 2
    assert "nowhere" in capsys.readouterr().err and not (tmp_path / "new.mcap").exists()


def test_logs_become_csv(reach: ub.Reach, path: Path, tmp_path: Path) -> None:
    """Tests that the forces of a grid in JSON, and numbers of a message of ROS 2, come back at their times."""
    for topic, field, expected in (
        ("/skin/forearm", "sensed_force_n", reach.sensed_force_n("forearm", dtype="float64")),
        ("/joint_states", "effort", reach.column("observation.torque")),
    ):
        out = tmp_path / "log.csv"
        assert underbrush.mcap.csv_of(path, out, topic, field, force=True) == len(reach)
        table = np.loadtxt(out, delimiter=",", skiprows=1)
        assert np.array_equal(table[:, 1:], expected)
        assert np.allclose(table[:, 0], reach.time_s - reach.time_s[0], atol=1e-9)
        assert out.read_text().startswith("time,force_0,force_1,")


def test_channels_hold_the_last_message(reach: ub.Reach, path: Path, tmp_path: Path) -> None:
    """Tests that topics at their own rates become columns: one number under its name, several with their numbers, and nothing
    before the first message."""
    out = tmp_path / "log.csv"
    arguments = ["csv", str(path), "--topic", "/skin/forearm", "--field", "sensed_force_n", "--out", str(out)]
    assert underbrush.mcap.main([*arguments, "--channel", "torque=/joint_states:effort"]) == 0
    header, *rows = out.read_text().splitlines()
    taxels = reach.skin.taxels("forearm")
    assert header.split(",")[taxels + 1 :] == [f"torque_{joint}" for joint in range(len(reach.joint_names))]
    assert np.array_equal([row.split(",")[taxels + 1 :] for row in rows], reach.column("observation.torque").astype(str))
    slow = tmp_path / "slow.mcap"
    with open(slow, "wb") as file:
        writer: Any = mcap_writer.Writer(file)
        writer.start()
        schema = writer.register_schema("numbers", "jsonschema", b"{}")
        topics = {topic: writer.register_channel(topic, "json", schema) for topic in ("/force", "/heat")}
        for topic, time, value in (
            ("/force", 0, [1.0, 2.0]),
            ("/force", 1, [3.0, 4.0]),
            ("/heat", 1, 20.5),
            ("/heat", 2, 21.5),
            ("/force", 3, [5.0, 6.0]),
        ):
            writer.add_message(topics[topic], time * 10**9, json.dumps({"data": value}).encode(), time * 10**9)
        writer.finish()
    assert underbrush.mcap.csv_of(slow, out, "/force", channels={"heat": ("/heat", "data")}, force=True) == 3
    assert out.read_text().splitlines() == ["time,force_0,force_1,heat", "0.0,1.0,2.0,", "1.0,3.0,4.0,20.5", "3.0,5.0,6.0,21.5"]


def test_logs_without_the_forces_are_refused(path: Path, tmp_path: Path) -> None:
    """Tests that a wrong topic or field, a damaged grid, and a file that is cut or missing, are errors which say what there is."""
    out = tmp_path / "log.csv"
    assert underbrush.mcap.main(["csv", str(tmp_path / "nowhere.mcap"), "--topic", "/palm", "--out", str(out)]) == 2
    with pytest.raises(ub.InputError, match=r"'/palm'; allowed: .*/skin/forearm"):
        underbrush.mcap.csv_of(path, out, "/palm")
    with pytest.raises(ub.InputError, match="'depth'; allowed: sensed_force_n"):
        underbrush.mcap.csv_of(path, out, "/skin/forearm", "depth")
    with pytest.raises(ub.InputError, match="'name', which has no numbers"):
        underbrush.mcap.csv_of(path, out, "/joint_states", "name")
    with pytest.raises(ub.InputError, match="'/heat'; allowed: .*/skin/forearm"):
        underbrush.mcap.csv_of(path, out, "/joint_states", "effort", channels={"heat": ("/heat", "data")})
    with pytest.raises(ub.InputError, match="another name"):
        underbrush.mcap.csv_of(path, out, "/joint_states", "effort", channels={"time": ("/joint_states", "position")})
    with pytest.raises(ub.InputError, match="'/heat:data'; allowed: a pair of topic and field"):
        underbrush.mcap.csv_of(path, out, "/joint_states", "effort", channels={"heat": "/heat:data"})
    assert underbrush.mcap.main(["csv", str(path), "--topic", "/joint_states", "--out", str(out), "--channel", "heat"]) == 2
    damaged = tmp_path / "damaged.mcap"
    with open(damaged, "wb") as file:
        writer: Any = mcap_writer.Writer(file)
        writer.start()
        channel = writer.register_channel("/palm", "json", writer.register_schema("grid", "jsonschema", b"{}"))
        grid = {"cell_stride": 8, "fields": [{"name": "force", "offset": 0, "type": 8}]}
        writer.add_message(channel, 0, json.dumps(grid).encode(), 0)
        writer.finish()
    with pytest.raises(ub.InputError, match=r"'force' in a grid that cannot be read: KeyError\('column_count'\)"):
        underbrush.mcap.csv_of(damaged, out, "/palm", "force")
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[:-1000])
    with pytest.raises(ub.InputError, match="cut.mcap"):
        underbrush.mcap.csv_of(cut, out, "/joint_states", "effort")
    assert not out.exists()
