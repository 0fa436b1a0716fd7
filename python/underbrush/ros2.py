"""Bags of ROS 2: one reach as a folder that ``ros2 bag play``, RViz and the package rosbags read.

    python -m underbrush.ros2 export reach.parquet --out bag

Needs rosbags: ``pip install 'underbrush[ros2]'``. ROS itself is not needed.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Callable, Iterable
from os import PathLike, getpid
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core, _export, mcap
from ._errors import InputError, refused

_WORLD = "world"
_KINDS = {"cubes": "CUBE", "spheres": "SPHERE", "cylinders": "CYLINDER", "triangles": "TRIANGLE_LIST"}


class _Bag:
    """Writes the messages of a reach."""

    def __init__(self, folder: Path, reach: _core.Reach) -> None:
        try:
            from rosbags.rosbag2 import StoragePlugin, Writer
            from rosbags.typesys import Stores, get_typestore
        except ImportError as error:
            raise ImportError("underbrush.ros2 needs rosbags: pip install 'underbrush[ros2]'") from error
        # Humble's messages have not changed since. Version 9 of metadata.yaml is that of Jazzy and later.
        self.store: Any = get_typestore(Stores.ROS2_HUMBLE)
        self.writer: Any = Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP)
        self.reach = reach
        self.connections: dict[str, Any] = {}
        self.nanoseconds = 0

    def make(self, kind: str, **fields: Any) -> Any:
        """A message. A kind without a package is one of ``geometry_msgs``."""
        package, name = kind.split("/") if "/" in kind else ("geometry_msgs", kind)
        return self.store.types[f"{package}/msg/{name}"](**fields)

    def send(self, topic: str, message: Any) -> None:
        kind = message.__msgtype__
        if topic not in self.connections:
            self.connections[topic] = self.writer.add_connection(topic, kind, typestore=self.store)
        self.writer.write(self.connections[topic], self.nanoseconds, self.store.serialize_cdr(message, kind))

    def header(self, frame: str) -> Any:
        seconds, rest = divmod(self.nanoseconds, 10**9)
        return self.make("std_msgs/Header", stamp=self.make("builtin_interfaces/Time", sec=seconds, nanosec=rest), frame_id=frame)

    def joint_state(self, topic: str, *numbers: NDArray[np.float64]) -> None:
        rows = dict(zip(("position", "velocity", "effort"), numbers))
        names = self.reach.joint_names
        self.send(topic, self.make("sensor_msgs/JointState", header=self.header(""), name=names, **rows))

    def markers(self, topic: str, entities: Iterable[dict[str, Any]]) -> None:
        """Sends the shapes of entities. Each marker moves with its frame."""
        markers: list[Any] = []
        for entity in entities:
            for field, kind in _KINDS.items():
                for shape in entity[field]:
                    markers.append(self.marker(entity, shape, kind, len(markers)))
        self.send(topic, self.make("visualization_msgs/MarkerArray", markers=markers))

    def marker(self, entity: dict[str, Any], shape: dict[str, Any], kind: str, number: int) -> Any:
        pose, none = shape["pose"], self.make("builtin_interfaces/Duration", sec=0, nanosec=0)
        marker = self.store.types["visualization_msgs/msg/Marker"]
        return marker(
            header=self.header(entity["frame_id"]),
            ns=entity["id"],
            id=number,
            type=getattr(marker, kind),
            action=marker.ADD,
            pose=self.make(
                "Pose",
                position=self.make("Point", **pose["position"]),
                orientation=self.make("Quaternion", **pose["orientation"]),
            ),
            scale=self.make("Vector3", **shape.get("size", {"x": 1.0, "y": 1.0, "z": 1.0})),
            color=self.make("std_msgs/ColorRGBA", **shape["color"]),
            lifetime=none,
            frame_locked=entity["frame_locked"],
            points=[self.make("Point", **point) for point in shape.get("points", [])],
            colors=[],
            texture_resource="",
            texture=self.make(
                "sensor_msgs/CompressedImage", header=self.header(""), format="", data=np.zeros(0, np.uint8)
            ),
            uv_coordinates=[],
            text="",
            mesh_resource="",
            mesh_file=self.make("visualization_msgs/MeshFile", filename="", data=np.zeros(0, np.uint8)),
            mesh_use_embedded_materials=False,
        )

    def transforms(self, message: dict[str, Any]) -> None:
        sent = [
            self.make(
                "TransformStamped",
                header=self.header(one["parent_frame_id"]),
                child_frame_id=one["child_frame_id"],
                transform=self.make(
                    "Transform",
                    translation=self.make("Vector3", **one["translation"]),
                    rotation=self.make("Quaternion", **one["rotation"]),
                ),
            )
            for one in message["transforms"]
        ]
        self.send("/tf", self.make("tf2_msgs/TFMessage", transforms=sent))

    def skin(self, patch: dict[str, Any], force_n: NDArray[np.float64]) -> None:
        """Sends what a patch senses."""
        grid = patch["grid"]
        shape = [("taxel", len(force_n))] if grid is None else [("row", grid["rows"]), ("column", grid["columns"])]
        strides = np.cumprod([size for _, size in reversed(shape)])[::-1]
        dimensions = [
            self.make("std_msgs/MultiArrayDimension", label=label, size=size, stride=int(stride))
            for (label, size), stride in zip(shape, strides)
        ]
        layout = self.make("std_msgs/MultiArrayLayout", dim=dimensions, data_offset=0)
        topic = f"/skin/{patch['name']}"
        self.send(topic, self.make("std_msgs/Float32MultiArray", layout=layout, data=force_n.astype(np.float32)))
        pressed = np.flatnonzero(force_n > 0)
        points = [[*patch["taxels"][taxel]["position_link"], force_n[taxel]] for taxel in pressed]
        float32 = 7
        fields = [
            self.make("sensor_msgs/PointField", name=name, offset=4 * place, datatype=float32, count=1)
            for place, name in enumerate(("x", "y", "z", "sensed_force_n"))
        ]
        data = np.frombuffer(np.array(points, dtype="<f4").tobytes(), np.uint8)
        cloud = {"is_bigendian": False, "point_step": 16, "row_step": 16 * len(points), "is_dense": True}
        size = {"height": 1, "width": len(points)}
        header = self.header(patch["link"])
        self.send(f"{topic}/pressed", self.make("sensor_msgs/PointCloud2", header=header, fields=fields, data=data, **size, **cloud))

    def run(self, urdf: str | None) -> None:
        """Writes the whole bag."""
        reach, column = self.reach, self.reach.column
        patches, bodies, objects = reach.skin.layout["patches"], reach.bodies, reach.objects
        joints = [column(name) for name in ("observation.state", "observation.velocity", "observation.torque")]
        equilibrium, goals, none = column("action"), column("goal_position"), np.zeros(0)
        sensed_n = {patch["name"]: reach.sensed_force_n(patch["name"], dtype="float64") for patch in patches}
        contact_n = {patch["name"]: column(f"truth.contact_force.{patch['name']}") for patch in patches}
        transforms, is_new_goal = mcap._Transforms(bodies, objects, []), mcap.new_goals(reach)
        zero = self.make("Vector3", x=0.0, y=0.0, z=0.0)
        with self.writer:
            for frame, time_s in enumerate(reach.time_s):
                self.nanoseconds = round(float(time_s) * 1e9)
                if frame == 0:
                    self.markers("/scene", mcap._scene(bodies, objects)["entities"])
                    if urdf is not None:
                        self.send("/robot_description", self.make("std_msgs/String", data=urdf))
                self.joint_state("/joint_states", *(table[frame] for table in joints))
                self.joint_state("/equilibrium", equilibrium[frame], none, none)
                self.transforms(transforms.message(self.nanoseconds, frame))
                if is_new_goal[frame]:
                    self.markers("/goal", [mcap._goal(self.nanoseconds, goals[frame])])
                for patch in patches:
                    self.skin(patch, sensed_n[patch["name"]][frame])
                    force = self.make("Vector3", **mcap._named("xyz", contact_n[patch["name"]][frame]))
                    wrench = self.make("Wrench", force=force, torque=zero)
                    topic = f"/truth/contact_force/{patch['name']}"
                    self.send(topic, self.make("WrenchStamped", header=self.header(_WORLD), wrench=wrench))


def _of_cody(reach: _core.Reach) -> str | None:
    """The URDF of the arm that ships, if the joints and the skin are that arm's. A recording does not hold the files of its arm."""
    cody = _core.Arm.cody()
    is_cody = reach.joint_names == cody.joints and reach.skin.layout == cody.skin.layout
    return cody.files["cody.urdf"] if is_cody else None


def _urdf_of(dataset: _core.Dataset | None, urdf: str | PathLike[str] | None) -> Callable[[_core.Reach], str | None]:
    """The URDF of the arm of a reach: this file, else what the data set was made from."""
    if urdf is not None:
        try:
            text = Path(urdf).read_text(encoding="utf-8")
        except (FileNotFoundError, IsADirectoryError, UnicodeDecodeError) as error:
            raise refused("urdf", str(error), "a readable text file", "check the path", file=str(urdf)) from error
        return lambda reach: text
    if dataset is None:
        return _of_cody
    arms = [{Path(file["name"]).suffix: file["text"] for file in arm["files"]} for arm in dataset.provenance["arms"]]
    texts = {scene["name"]: arms[scene["arm"]].get(".urdf") for scene in dataset.provenance["scenes"]}
    return lambda reach: texts.get(reach.scene)


def export(
    reaches: _core.Reach | _core.Dataset | Iterable[_core.Reach],
    path: str | PathLike[str],
    *,
    urdf: str | PathLike[str] | None = None,
    force: bool = False,
) -> None:
    """Write reaches as bags of ROS 2 with the topics that ``docs/exchange.md`` describes.

    Parameters
    ----------
    reaches : Reach, Dataset or iterable of Reach
        A data set is read reach by reach.
    path : path
        For a single reach, the folder of the bag. Otherwise a folder in which each reach gets a bag ``reach-000000``,
        ``reach-000001``, ….
    urdf : path, optional
        The URDF of the arm. It is copied into each bag as ``robot.urdf`` and sent on ``/robot_description``. A data set
        holds the URDF of its arm, and needs this only for another one. Other reaches need it if their arm is not the one
        that ships.
    force : bool
        Remove a bag that exists. In a folder of several, all bags of an earlier export are removed, so that the two are not
        mixed. Folders that are no bags are never removed.

    Raises
    ------
    InputError
        If the folder of a bag exists, or the folder has bags of another export, and ``force`` is not set or one is no bag.
    """
    dataset = reaches if isinstance(reaches, _core.Dataset) else None
    _export_with(_urdf_of(dataset, urdf), reaches, Path(path), force)


def _check_free(path: Path, force: bool) -> None:
    """Refuses a path where something is already, unless it is a bag and ``force`` says that it may be removed, and one within a data set."""
    _core._check_free(path, True)
    if path.exists() and not (force and (path / "metadata.yaml").exists()):
        remedy = "choose another name" if force else "choose another name, or overwrite it with --force if it is a bag"
        raise InputError(f"{path}: exists already; {remedy}", file=str(path))


def _export_with(
    urdf_of: Callable[[_core.Reach], str | None], reaches: _core.Reach | _core.Dataset | Iterable[_core.Reach], path: Path, force: bool
) -> None:
    """Writes the bags of reaches with the URDF of each scene."""
    if not isinstance(reaches, _core.Reach):
        found = _export.each(reaches)
        _export.make_folder(path)
        others = sorted(path.glob("reach-??????"))
        for other in others:
            _check_free(other, force)
        for other in others:
            shutil.rmtree(other)
        for number, reach in enumerate(found):
            _export_with(urdf_of, reach, path / f"reach-{number:06}", force=False)
        return
    text = urdf_of(reaches)
    _check_free(path, force)
    path.parent.mkdir(parents=True, exist_ok=True)
    whole = path.with_name(f".{path.name}.{getpid()}")
    try:
        _Bag(whole, reaches).run(text)
        # The metadata names the file, and the file has the name of the folder.
        for file in whole.glob("*.mcap"):
            renamed = f"{path.name}.mcap"
            metadata = whole / "metadata.yaml"
            metadata.write_text(metadata.read_text(encoding="utf-8").replace(file.name, renamed), encoding="utf-8")
            file.rename(whole / renamed)
        if text is not None:
            (whole / "robot.urdf").write_text(text, encoding="utf-8")
        if force and path.exists():
            shutil.rmtree(path)
        whole.rename(path)
    finally:
        shutil.rmtree(whole, ignore_errors=True)


def main(arguments: list[str] | None = None) -> int:
    """The command line: ``python -m underbrush.ros2 --help``."""
    parser = argparse.ArgumentParser(prog="python -m underbrush.ros2", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    out = "folder of the bag; for several reaches the folder, with one bag reach-000000, ... for each"
    own = _export.export_parser(commands, "write reaches as bags of ROS 2", out)
    own.add_argument("--urdf", type=Path, help="URDF of the arm, for /robot_description [default: of a data set that of its arm, else that of Cody if it is the arm]")
    options = parser.parse_args(arguments)

    def run() -> dict[str, int]:
        count, reaches = _export.reaches_in(options.data, options.out)
        place, *others = _core._with_recordings(options.data)
        urdf_of = _urdf_of(_core.Dataset(place) if place.is_dir() and not others else None, options.urdf)
        _export_with(urdf_of, next(reaches) if count == 1 else reaches, options.out, options.force)
        return {"reaches": count}

    return _export.status(run, options)


if __name__ == "__main__":
    sys.exit(main())
