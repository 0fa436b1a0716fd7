"""MCAP: reaches for `Foxglove <https://foxglove.dev>`_, one file for each reach, and logs of other robots as CSV.

    python -m underbrush.mcap export reach.parquet --out reach.mcap
    python -m underbrush.mcap csv log.mcap --topic /skin --out log.csv

Needs mcap: ``pip install 'underbrush[mcap]'``.
"""

from __future__ import annotations

import argparse
import base64
import csv
import json
import re
import struct
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from itertools import combinations
from os import PathLike
from itertools import chain, groupby
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core, _export
from ._errors import InputError, refused
from .results import SceneObject

# The root frame, which is the parent of all others.
_WORLD = "world"
# The name of the field with the forces in grids and point clouds.
_FORCE = "sensed_force_n"
# Bodies of objects are sent in ``/tf`` when they move. All of them are also sent each time this number of frames has passed,
# so that a viewer that starts in the middle soon has them all.
_FRAMES_BETWEEN_ALL = 100
# Radius of the sphere that shows the goal, m. Choice: as large as the hand.
_GOAL_RADIUS_M = 0.03
_GOAL_COLOR = (0.1, 0.4, 0.9, 0.8)
_LINK_COLOR = (0.6, 0.6, 0.65, 1.0)
_OBJECT_COLORS = {"leaf": (0.3, 0.65, 0.25, 1.0), "trunk": (0.5, 0.35, 0.2, 1.0), "block": (0.85, 0.8, 0.65, 1.0)}
_OTHER_COLOR = (0.6, 0.3, 0.7, 1.0)
# Choice: the size up to which messages are compressed together, as the Rust library of MCAP has it.
_CHUNK_BYTES = 768 * 1024

# The message of ROS 2 and those that it refers to, as MCAP requires for the encoding ``ros2msg``.
_JOINT_STATE = f"""std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
{"=" * 80}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{"=" * 80}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""

# Foxglove's messages as far as they are used: https://docs.foxglove.dev/docs/sdk/schemas. A type stands for its JSON Schema.
_TIME = {"sec": int, "nsec": int}
_VECTOR = {"x": float, "y": float, "z": float}
_POSE = {"position": _VECTOR, "orientation": {**_VECTOR, "w": float}}
_COLOR = {"r": float, "g": float, "b": float, "a": float}
_SOLID = {"pose": _POSE, "size": _VECTOR, "color": _COLOR}
_PACKED = {"fields": [{"name": str, "offset": int, "type": int}], "data": bytes}
_ENTITY = {
    "timestamp": _TIME,
    "frame_id": str,
    "id": str,
    # Zero: the entity stays until it is replaced.
    "lifetime": _TIME,
    "frame_locked": bool,
    "metadata": [{"key": str, "value": str}],
    "cubes": [_SOLID],
    "spheres": [_SOLID],
    "cylinders": [{**_SOLID, "bottom_scale": float, "top_scale": float}],
    "triangles": [{"pose": _POSE, "points": [_VECTOR], "color": _COLOR, "colors": [_COLOR], "indices": [int]}],
    # Lists of unused kinds of shapes. Some readers require these keys.
    "arrows": [{}],
    "lines": [{}],
    "texts": [{}],
    "models": [{}],
}
_TRANSFORM = {
    "timestamp": _TIME,
    "parent_frame_id": str,
    "child_frame_id": str,
    "translation": _VECTOR,
    "rotation": {**_VECTOR, "w": float},
}
_SCHEMAS: dict[str, dict[str, Any]] = {
    "foxglove.FrameTransforms": {"transforms": [_TRANSFORM]},
    "foxglove.SceneUpdate": {"deletions": [{}], "entities": [_ENTITY]},
    "foxglove.Grid": {
        "timestamp": _TIME,
        "frame_id": str,
        "pose": _POSE,
        "column_count": int,
        "cell_size": {"x": float, "y": float},
        "row_stride": int,
        "cell_stride": int,
        **_PACKED,
    },
    "foxglove.PointCloud": {"timestamp": _TIME, "frame_id": str, "pose": _POSE, "point_stride": int, **_PACKED},
}
_NAMES = {str: "string", int: "integer", float: "number", bool: "boolean"}
_FLOAT64 = 8


def schema(name: str) -> dict[str, Any]:
    """The JSON Schema of one of Foxglove's messages."""
    return {"title": name, **_schema(_SCHEMAS[name])}


def _schema(kind: Any) -> dict[str, Any]:
    """The JSON Schema of a message or field, without references, because Foxglove does not follow them."""
    if isinstance(kind, dict):
        properties = {name: _schema(field) for name, field in kind.items()}
        return {"type": "object", "properties": properties, "required": list(kind)}
    if isinstance(kind, list):
        return {"type": "array", "items": _schema(kind[0])}
    return {"type": "string", "contentEncoding": "base64"} if kind is bytes else {"type": _NAMES[kind]}


def _time(nanoseconds: int) -> dict[str, int]:
    return {"sec": nanoseconds // 10**9, "nsec": nanoseconds % 10**9}


def _named(names: str, numbers: Iterable[float]) -> dict[str, float]:
    return {name: float(number) for name, number in zip(names, numbers)}


def _pose(position: Sequence[float] = (0, 0, 0), orientation: Sequence[float] = (0, 0, 0, 1)) -> dict[str, Any]:
    return {"position": _named("xyz", position), "orientation": _named("xyzw", orientation)}


def _packed(names: Sequence[str], numbers: NDArray[np.float64]) -> dict[str, Any]:
    """Numbers of double precision with these names, as bytes in base64."""
    fields = [{"name": name, "offset": 8 * place, "type": _FLOAT64} for place, name in enumerate(names)]
    return {"fields": fields, "data": base64.b64encode(numbers.astype("<f8").tobytes()).decode()}


def _joint_state(nanoseconds: int, names: Sequence[str], *numbers: NDArray[np.float64]) -> bytes:
    """A ``JointState`` in CDR, little-endian (OMG CDR 1.0). A number is aligned to its size."""
    # Seconds, nanoseconds and an empty frame, which is a zero byte after its length.
    message = struct.pack("<iIIx", *divmod(nanoseconds, 10**9), 1)

    def aligned(to: int) -> bytes:
        return message + bytes(-len(message) % to)

    message = aligned(4) + struct.pack("<I", len(names))
    for name in names:
        text = name.encode() + b"\0"
        message = aligned(4) + struct.pack("<I", len(text)) + text
    for row in numbers:
        message = aligned(4) + struct.pack("<I", len(row))
        if len(row) > 0:
            message = aligned(8) + row.astype("<f8").tobytes()
    # The first bytes name the encoding. Alignment counts from the byte after them.
    return b"\0\1\0\0" + message


def _frame_names(bodies: Sequence[dict[str, Any]], objects: Sequence[SceneObject]) -> list[str]:
    """The frame of each body: the name of its link, or the kind and number of its object and its number in the object."""
    names, counts = [], [0] * len(objects)
    for owner in (body["owner"] for body in bodies):
        if "link" in owner:
            names.append(owner["link"])
        else:
            number = owner["object"]
            names.append(f"{objects[number]['kind']}_{number}/{counts[number]}")
            counts[number] += 1
    return names


def _hull(points: NDArray[np.float64]) -> list[dict[str, float]]:
    """The corners of the triangles of a convex hull: all triangles that have the other points on one side. If more than three
    points lie in the plane of a face, its triangles overlap, which looks the same."""
    corners: list[NDArray[np.float64]] = []
    for a, b, c in combinations(points, 3):
        normal = np.cross(b - a, c - a)
        heights = (points - a) @ normal
        # A choice: 1 µm, a thousandth of the height of the smallest shapes.
        slack = 1e-6 * float(np.linalg.norm(normal))
        if slack > 0 and heights.max() <= slack:
            corners += [a, b, c]
        elif slack > 0 and heights.min() >= -slack:
            corners += [a, c, b]
    return [_named("xyz", corner) for corner in corners]


def _add(entity: dict[str, Any], shape: dict[str, Any], pose: dict[str, Any], color: Sequence[float]) -> None:
    """Adds a shape at a pose in the entity's frame."""
    (kind, sizes) = next(iter(shape.items()))
    look = {"color": _named("rgba", color)}
    if kind in ("cylinder", "capsule"):
        width = 2 * sizes["radius_m"]
        size = _named("xyz", (width, width, sizes["length_m"]))
        entity["cylinders"].append({"pose": pose, "size": size, "bottom_scale": 1.0, "top_scale": 1.0, **look})
    if kind == "capsule":
        centre, (x, y, z, w) = np.array(list(pose["position"].values())), pose["orientation"].values()
        axis = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
        for side in (-0.5, 0.5):
            end = {**pose, "position": _named("xyz", centre + side * sizes["length_m"] * axis)}
            _add(entity, {"sphere": sizes}, end, color)
    if kind == "sphere":
        entity["spheres"].append({"pose": pose, "size": _named("xyz", [2 * sizes["radius_m"]] * 3), **look})
    if kind == "box":
        entity["cubes"].append({"pose": pose, "size": _named("xyz", sizes["size_m"]), **look})
    if kind == "hull":
        points = _hull(np.asarray(sizes["points_m"]))
        entity["triangles"].append({"pose": pose, "points": points, **look, "colors": [], "indices": []})


def _entity(name: str, frame: str, nanoseconds: int = 0, **own: Any) -> dict[str, Any]:
    empty: dict[str, Any] = {field: [] for field, kind in _ENTITY.items() if isinstance(kind, list)}
    start = {"timestamp": _time(nanoseconds), "frame_id": frame, "id": name, "lifetime": _time(0), "frame_locked": False}
    return {**start, **empty, **own}


def _scene(bodies: Sequence[dict[str, Any]], objects: Sequence[SceneObject]) -> dict[str, Any]:
    """All bodies, each as one entity that moves with its frame."""
    entities = []
    for body, frame in zip(bodies, _frame_names(bodies, objects)):
        color, metadata = _LINK_COLOR, []
        if "object" in body["owner"]:
            category = objects[body["owner"]["object"]]["category"]
            color, metadata = _OBJECT_COLORS.get(category, _OTHER_COLOR), [{"key": "category", "value": category}]
        entity = _entity(frame, frame, frame_locked=True, metadata=metadata)
        for part in body["parts"]:
            _add(entity, part["shape"], _pose(**part["pose_body"]), color)
        entities.append(entity)
    return {"deletions": [], "entities": entities}


def _goal(nanoseconds: int, position: NDArray[np.float64]) -> dict[str, Any]:
    """The goal of the hand."""
    entity = _entity("goal", _WORLD, nanoseconds)
    _add(entity, {"sphere": {"radius_m": _GOAL_RADIUS_M}}, _pose(position.tolist()), _GOAL_COLOR)
    return entity


def _mcap() -> Any:
    try:
        import mcap.writer
    except ImportError as error:
        raise ImportError("underbrush.mcap needs mcap: pip install 'underbrush[mcap]'") from error
    return mcap.writer


class _Writer:
    """Writes the messages of a reach."""

    def __init__(self, file: Any, reach: _core.Reach) -> None:
        self.writer: Any = _mcap().Writer(file, chunk_size=_CHUNK_BYTES, compression=_mcap().CompressionType.ZSTD)
        self.reach = reach
        self.channels: dict[str, int] = {}
        self.schemas: dict[str, int] = {}
        self.sequence = 0

    def channel(self, topic: str, name: str) -> None:
        """Adds a channel, and the schema of this name unless it is there."""
        is_ros = not name.startswith("foxglove")
        if name not in self.schemas:
            definition = _JOINT_STATE if is_ros else json.dumps(schema(name))
            encoding = "ros2msg" if is_ros else "jsonschema"
            self.schemas[name] = self.writer.register_schema(name, encoding, definition.encode())
        encoding = "cdr" if is_ros else "json"
        self.channels[topic] = self.writer.register_channel(topic, encoding, self.schemas[name])

    def send(self, topic: str, nanoseconds: int, message: bytes | dict[str, Any]) -> None:
        if isinstance(message, dict):
            message = json.dumps(message, allow_nan=False, separators=(",", ":")).encode()
        self.writer.add_message(self.channels[topic], nanoseconds, message, nanoseconds, self.sequence)
        self.sequence += 1

    def run(self) -> None:
        """Writes the whole file."""
        reach = self.reach
        self.writer.start(library="underbrush")
        seed, index = reach.seed_and_index
        facts = {"scene": reach.scene, "seed": str(seed), "reach_index": str(index)}
        self.writer.add_metadata("underbrush.reach", facts | {"controller": reach.controller, "outcome": reach.outcome})
        for topic in ("/joint_states", "/equilibrium"):
            self.channel(topic, "sensor_msgs/msg/JointState")
        self.channel("/tf", "foxglove.FrameTransforms")
        for topic in ("/scene", "/goal"):
            self.channel(topic, "foxglove.SceneUpdate")
        patches = reach.skin.layout["patches"]
        for patch in patches:
            for topic, name in skin_topics(patch):
                self.channel(topic, name)
        # Each of these properties makes its value anew.
        bodies, objects, names = reach.bodies, reach.objects, reach.joint_names
        column = reach.column
        joints = [column(name) for name in ("observation.state", "observation.velocity", "observation.torque")]
        equilibrium, goals, none = column("action"), column("goal_position"), np.zeros(0)
        is_new_goal = new_goals(reach)
        sensed_n = {patch["name"]: reach.sensed_force_n(patch["name"], dtype="float64") for patch in patches}
        transforms = _Transforms(bodies, objects, patches)
        for frame, time_s in enumerate(reach.time_s):
            now = round(float(time_s) * 1e9)
            self.send("/joint_states", now, _joint_state(now, names, *(table[frame] for table in joints)))
            self.send("/equilibrium", now, _joint_state(now, names, equilibrium[frame], none, none))
            self.send("/tf", now, transforms.message(now, frame))
            if frame == 0:
                self.send("/scene", now, _scene(bodies, objects))
            if is_new_goal[frame]:
                self.send("/goal", now, {"deletions": [], "entities": [_goal(now, goals[frame])]})
            for patch in patches:
                for topic, message in skin_messages(now, patch, sensed_n[patch["name"]][frame]):
                    self.send(topic, now, message)
        self.writer.finish()


def new_goals(reach: _core.Reach) -> NDArray[np.bool_]:
    """Whether the goal of each frame is another one than that of the frame before. A robot's log has no goals."""
    goals = reach.column("goal_position")
    return np.any(np.diff(goals, axis=0, prepend=np.nan) != 0, axis=1) & bool(reach.goals)


def skin_topics(patch: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """The topics of what a patch senses, with the names of their schemas."""
    topic = f"/skin/{patch['name']}"
    if patch["grid"] is not None:
        yield topic, "foxglove.Grid"
    yield f"{topic}/pressed", "foxglove.PointCloud"


def skin_messages(nanoseconds: int, patch: dict[str, Any], force_n: NDArray[np.float64]) -> Iterator[tuple[str, dict[str, Any]]]:
    """What a patch senses, as messages with their topics."""
    topic, start = f"/skin/{patch['name']}", {"timestamp": _time(nanoseconds)}
    if patch["grid"] is not None:
        columns = patch["grid"]["columns"]
        cell_m = float(np.sqrt(patch["taxels"][0]["area_m2"])) if patch["taxels"] else 0.0
        grid = {"frame_id": topic[1:], "pose": _pose(), "column_count": columns, "cell_size": _named("xy", (cell_m, cell_m))}
        yield topic, {**start, **grid, "row_stride": 8 * columns, "cell_stride": 8, **_packed([_FORCE], force_n)}
    pressed = np.flatnonzero(force_n > 0)
    points = [[*patch["taxels"][taxel]["position_link"], force_n[taxel]] for taxel in pressed]
    cloud = {"frame_id": patch["link"], "pose": _pose(), "point_stride": 32}
    yield f"{topic}/pressed", {**start, **cloud, **_packed(["x", "y", "z", _FORCE], np.array(points, dtype=np.float64))}


def transform(nanoseconds: int, child: str, position: Iterable[float], orientation: Iterable[float]) -> dict[str, Any]:
    """The pose of a frame in the world."""
    pose = {"translation": _named("xyz", position), "rotation": _named("xyzw", orientation)}
    return {"timestamp": _time(nanoseconds), "parent_frame_id": _WORLD, "child_frame_id": child, **pose}


class _Transforms:
    """The poses of the bodies over time."""

    def __init__(
        self,
        bodies: Sequence[dict[str, Any]],
        objects: Sequence[SceneObject],
        patches: Sequence[dict[str, Any]],
    ) -> None:
        # A link may have the name of the root frame, which has no parent.
        frames = _frame_names(bodies, objects)
        self.bodies = [(body, frame) for body, frame in zip(bodies, frames) if frame != _WORLD]
        numbered = enumerate(patches)
        self.grids = [(f"skin/{patch['name']}", place) for place, patch in numbered if patch["grid"] is not None]
        self.moved = [np.array(body["moved_frames"], dtype=int) for body, _ in self.bodies]

    def message(self, nanoseconds: int, frame: int) -> dict[str, Any]:
        every = frame % _FRAMES_BETWEEN_ALL == 0
        sent = []

        def send(child: str, position: Sequence[float], orientation: Sequence[float]) -> None:
            sent.append(transform(nanoseconds, child, position, orientation))

        for (body, child), moved in zip(self.bodies, self.moved):
            last = int(np.searchsorted(moved, frame, side="right")) - 1
            if every or "link" in body["owner"] or (last >= 0 and moved[last] == frame):
                rest = body["rest_pose_world"]
                pose = body["poses_world"][last] if last >= 0 else [*rest["position"], *rest["orientation"]]
                send(child, pose[:3], pose[3:])
        if every:
            for child, place in self.grids:
                # Choice: beside the arm, one above the other.
                send(child, (0.0, 1.0, 0.5 * place), (0.0, 0.0, 0.0, 1.0))
        return {"transforms": sent}


def _files(folder: Path) -> list[Path]:
    """The files of an export in a folder."""
    return sorted(path for path in folder.iterdir() if re.fullmatch(r"reach-\d+\.mcap", path.name))


def export(
    reaches: _core.Reach | _core.Dataset | Iterable[_core.Reach], path: str | PathLike[str], *, force: bool = False
) -> None:
    """Write reaches to MCAP files with the topics that ``docs/exchange.md`` describes.

    The same reach gives the same bytes with the same versions of the libraries. A file gets its name when it is complete.

    Parameters
    ----------
    reaches : Reach, Dataset or iterable of Reach
        A data set is read reach by reach.
    path : path
        For a single reach, the file to write. Otherwise the folder, in which each reach gets a file
        ``reach-000000.mcap``, ``reach-000001.mcap``, ….
    force : bool
        Overwrite a file that exists. In a folder, the files of an earlier export are removed, so that the two are not mixed.

    Raises
    ------
    InputError
        If the file exists, or the folder has files of another export, and ``force`` is not set.
    """
    path = Path(path)
    if not isinstance(reaches, _core.Reach):
        found = _export.each(reaches)
        _export.make_folder(path)
        for other in _files(path):
            _core._check_free(other, force)
            other.unlink()
        for number, reach in enumerate(found):
            export(reach, path / f"reach-{number:06}.mcap")
        return
    # Python may lose a Ctrl-C that comes while it imports a module.
    _mcap()
    with _export.whole(path, force) as temporary, open(temporary, "wb") as file:
        _Writer(file, reaches).run()


def csv_of(
    path: str | PathLike[str],
    out: str | PathLike[str],
    topic: str,
    field: str = "data",
    *,
    channels: Mapping[str, tuple[str, str]] | None = None,
    force: bool = False,
) -> int:
    """Write the forces in an MCAP file as CSV, which ``underbrush import`` reads with a mapping.

    The columns are ``time`` (s since the first message of the topic) and ``force_0``, ``force_1``, … for the taxels, then those of
    the channels: their name for a single number, or else ``NAME_0``, ``NAME_1``, ….

    Parameters
    ----------
    path, out : path
        The MCAP file, or the folder of a bag of ROS 2 with one, and the CSV file to write.
    topic : str
        The topic of the forces. Its messages are JSON, or any type of ROS 2 in CDR.
    field : str
        Where a message has its numbers: names joined by dots, which lead to a list or a single number, such as ``data`` of
        the arrays of ``std_msgs`` or ``wrench.force.z``. For ``foxglove.Grid`` the name of a field of its cells.
    channels : dict of str to (str, str), optional
        Further columns by their names: topic and field. A row has the numbers of the last message until then; before the first
        one its cells are empty.
    force : bool
        Overwrite a file that exists.

    Returns
    -------
    int
        The number of messages of forces.

    Raises
    ------
    InputError
        If something is not in the file, or has another shape or type, or if ``out`` exists and ``force`` is not set.
    """
    rows = 0
    columns = {"force": (topic, field)} | dict(channels or {})
    if "force" in (channels or {}) or "time" in columns:
        raise _fault(path, "channels", "a channel named force or time", "another name")
    if other := [own for own in columns.values() if not isinstance(own, (tuple, list)) or len(own) != 2]:
        raise _fault(path, "channels", repr(other[0]), "a pair of topic and field for each name")
    path = _log(Path(path))
    sizes = _sizes(path, columns)
    latest: dict[str, list[float] | list[str]] = {name: [""] * size for name, size in sizes.items()}
    with open(path, "rb") as file, _export.whole(Path(out), force, path) as temporary:
        with open(temporary, "w", newline="", encoding="utf-8") as text:
            writer, start = csv.writer(text), 0
            writer.writerow(["time", *_export.column_names(sizes)])
            found = _messages(file, path, {own for own, _ in columns.values()})
            # Of messages of one time, those of the forces come last.
            moments = (sorted(own, key=lambda own: own[1] == topic) for _, own in groupby(found, key=lambda own: own[0]))
            for nanoseconds, of_topic, message in chain.from_iterable(moments):
                for name, (own, own_field) in columns.items():
                    if own == of_topic:
                        numbers = _numbers(path, message, own_field)
                        if len(numbers) != sizes[name]:
                            allowed = f"{sizes[name]}, as in the first message"
                            raise _fault(path, f"{own}, {own_field}", f"{len(numbers)} numbers", allowed)
                        latest[name] = numbers
                if of_topic == topic:
                    start = nanoseconds if rows == 0 else start
                    writer.writerow([(nanoseconds - start) / 10**9, *(cell for cells in latest.values() for cell in cells)])
                    rows += 1
    return rows


def _log(path: Path) -> Path:
    """The file of a bag of ROS 2, which is a folder. A file is its own."""
    if not path.exists():
        raise refused("file", "no such file", "an MCAP file, or the folder of a bag", "check the path", file=str(path))
    if not path.is_dir():
        return path
    files = list(path.glob("*.mcap"))
    if len(files) != 1:
        remedy = "give one file, not the folder"
        message = f"{path}: found {len(files)} files .mcap; allowed: one, as in a bag of ROS 2; {remedy}"
        raise InputError(message, file=str(path), remedy=remedy)
    return files[0]


def _sizes(path: str | PathLike[str], columns: Mapping[str, tuple[str, str]]) -> dict[str, int]:
    """How many numbers each field has in the first message of its topic."""
    sizes: dict[str, int] = {}
    with open(path, "rb") as file:
        for _, of_topic, message in _messages(file, path, {topic for topic, _ in columns.values()}):
            for name, (topic, field) in columns.items():
                if topic == of_topic and name not in sizes:
                    sizes[name] = len(_numbers(path, message, field))
            if len(sizes) == len(columns):
                break
    return {name: sizes.get(name, 1) for name in columns}


def _fault(path: object, field: str, found: str, allowed: str) -> InputError:
    remedy = "`mcap info` lists topics and types"
    message = f"{path}: {field}: found {found}; allowed: {allowed}; {remedy}"
    return InputError(message, file=str(path), field=field, found=found, allowed=allowed, remedy=remedy)


def _messages(file: Any, path: object, topics: Set[str]) -> Iterator[tuple[int, str, Any]]:
    """The times, ns, topics and messages of some topics in the order of their times."""
    try:
        from mcap.exceptions import McapError
        from mcap.reader import make_reader
        from mcap_ros2.decoder import DecoderFactory
    except ImportError as error:
        raise ImportError("underbrush.mcap needs mcap: pip install 'underbrush[mcap]'") from error
    try:
        reader: Any = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        known = sorted({channel.topic for channel in summary.channels.values()}) if summary else []
        for topic in sorted(topics - set(known)):
            raise _fault(path, "topic", repr(topic), ", ".join(known) or "a complete file with topics")
        decoders, decoded = DecoderFactory(), {}
        for schema, channel, message in reader.iter_messages(sorted(topics)):
            if channel.id not in decoded:
                decoder = decoders.decoder_for(channel.message_encoding, schema)
                decoded[channel.id] = json.loads if channel.message_encoding == "json" else decoder
            decode = decoded[channel.id]
            if decode is None:
                raise _fault(path, channel.topic, f"messages of encoding {channel.message_encoding}", "JSON, or ROS 2 in CDR")
            yield message.log_time, channel.topic, decode(message.data)
    except (McapError, ValueError, struct.error, EOFError) as error:
        if isinstance(error, InputError):
            raise
        raise _fault(path, "file", str(error) or type(error).__name__, "a complete MCAP file") from error


# The types of ``foxglove.PackedElementField``.
_PACKED_TYPES = {1: "<u1", 2: "<i1", 3: "<u2", 4: "<i2", 5: "<u4", 6: "<i4", 7: "<f4", 8: "<f8"}


def _numbers(path: object, message: Any, field: str) -> list[float]:
    """The numbers in a field of a message."""
    if isinstance(message, dict) and "cell_stride" in message:
        try:
            fields = {own["name"]: own for own in message["fields"]}
            if field not in fields:
                raise _fault(path, "field", repr(field), ", ".join(fields))
            own, columns, stride = fields[field], message["column_count"], message["cell_stride"]
            rows = np.frombuffer(base64.b64decode(message["data"]), np.uint8).reshape(-1, message["row_stride"])
            cells = rows[:, : columns * stride].reshape(-1, stride)[:, own["offset"] :]
            kind = np.dtype(_PACKED_TYPES[own["type"]])
            return [float(number) for number in np.ascontiguousarray(cells[:, : kind.itemsize]).view(kind).ravel()]
        except (KeyError, TypeError, ValueError) as error:
            if isinstance(error, InputError):
                raise
            raise _fault(path, "field", f"{field!r} in a grid that cannot be read: {error!r}", "a foxglove.Grid") from error
    value = message
    for name in field.split("."):
        value = value.get(name) if isinstance(value, dict) else getattr(value, name, None)
    try:
        numbers = np.atleast_1d(np.asarray(value, dtype=np.float64))
    except (TypeError, ValueError):
        numbers = np.full((1, 1), np.nan)
    if numbers.ndim != 1 or not np.isfinite(numbers).all():
        raise _fault(path, "field", f"{field!r}, which has no numbers", "a list of finite numbers, or one")
    return [float(number) for number in numbers]


def main(arguments: list[str] | None = None) -> int:
    """The command line: ``python -m underbrush.mcap --help``."""
    parser = argparse.ArgumentParser(prog="python -m underbrush.mcap", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    out = "file to write; for several reaches the folder, with one file reach-000000.mcap, ... for each"
    _export.export_parser(commands, "write reaches for Foxglove", out)
    log = commands.add_parser("csv", help="write the forces of a log as CSV, for `underbrush import`")
    log.add_argument("log", type=Path, help="MCAP file, or folder of a bag of ROS 2")
    log.add_argument("--topic", required=True, help="topic of the forces")
    log.add_argument("--field", default="data", help="where a message has them, such as wrench.force.z [default: data]")
    channel = "a further column, such as torque_z=/wrench:wrench.torque.z; may be given more than once"
    log.add_argument("--channel", action="append", default=[], metavar="NAME=TOPIC:FIELD", help=channel)
    _export.output_options(log, "CSV file to write")
    options = parser.parse_args(arguments)

    def run() -> dict[str, int]:
        if options.command == "csv":
            channels: dict[str, tuple[str, str]] = {}
            for text in options.channel:
                name, _, where = text.partition("=")
                topic, _, field = where.rpartition(":")
                if not (name and topic and field) or name in channels:
                    raise _fault("--channel", "text", repr(text), "NAME=TOPIC:FIELD, each NAME once")
                channels[name] = (topic, field)
            frames = csv_of(options.log, options.out, options.topic, options.field, channels=channels, force=options.force)
            return {"frames": frames}
        count, reaches = _export.reaches_in(options.data, options.out)
        export(next(reaches) if count == 1 else reaches, options.out, force=options.force)
        return {"reaches": count}

    return _export.status(run, options)


if __name__ == "__main__":
    sys.exit(main())
