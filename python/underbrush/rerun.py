"""Reaches in the viewer of `Rerun <https://rerun.io>`_: the arm, its skin with forces, the objects and the goals.

    import rerun as rr, underbrush as ub, underbrush.rerun
    rr.init("underbrush", spawn=True)
    underbrush.rerun.log(ub.reach("leaf"))

Needs Rerun: ``pip install 'underbrush[rerun]'``. ``rr.save("reach.rrd")`` instead of ``spawn=True`` writes a file.
"""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core

if TYPE_CHECKING:
    import rerun as rr

# Red, green, blue. A leaf is green and a trunk brown, as in the replay page.
_LINK = (150, 155, 165)
_OBJECTS = {"leaf": (90, 150, 60), "trunk": (130, 95, 65)}
_OTHER_OBJECT = (170, 160, 130)
_GOAL = (230, 150, 0)
# The force at which a taxel has the strongest colour, N. Choice: the limit up to which the published controller lets contacts be.
_FULL_COLOUR_N = 5.0
_TAXEL_RADIUS_M = 0.005
_GOAL_RADIUS_M = 0.02


def log(reach: _core.Reach, *, recording: rr.RecordingStream | None = None, entity: str = "reach") -> None:
    """Log a reach to Rerun.

    Times are on the timeline ``time``, from the start of the reach. Below ``entity`` are:

    * ``links/NAME`` and ``objects/INDEX-KIND``: the shapes of each body, and its pose whenever it moves;
    * ``skin/PATCH``: the taxels at their places, coloured by the force that they sense, from grey at 0 N to red at 5 N;
    * ``image/PATCH``: the sensed forces of a patch with a grid, N, whenever they change;
    * ``force/PATCH``: the largest sensed force of the patch, N, as a plot;
    * ``goal``: the goal, from the moment when the arm starts towards it;
    * ``about``: scene, controller, seed and outcome; of a robot's log its name.

    Parameters
    ----------
    reach : Reach
        A simulated or recorded reach.
    recording : rerun.RecordingStream, optional
        Where to log; by default Rerun's current recording, which ``rerun.init`` makes.
    entity : str
        The path in the recording below which the reach is logged.

    Raises
    ------
    ImportError
        If Rerun is not installed.
    """
    try:
        import rerun as rr
    except ImportError as error:
        raise ImportError("underbrush.rerun needs Rerun: pip install 'underbrush[rerun]'") from error
    rr.log(entity, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True, recording=recording)
    seed, index = reach.seed_and_index
    about = f"scene {reach.scene}, controller {reach.controller}, seed {seed}, reach {index}: {reach.outcome}"
    if reach.is_log:
        about = f"log {reach.scene}, reach {index}"
    rr.log(f"{entity}/about", rr.TextDocument(about), static=True, recording=recording)
    objects = reach.objects
    counts: dict[str, int] = {}
    for body in reach.bodies:
        if "link" in body["owner"]:
            place, color = f"{entity}/links/{body['owner']['link']}", _LINK
        else:
            number = body["owner"]["object"]
            place = f"{entity}/objects/{number:02}-{objects[number]['kind']}"
            color = _OBJECTS.get(objects[number]["category"], _OTHER_OBJECT)
        # A link or an object may have several bodies.
        counts[place] = counts.get(place, 0) + 1
        _log_body(f"{place}/{counts[place]}", body, color, reach.time_s, recording)
    for patch in reach.skin.patches:
        _log_patch(reach, patch, entity, recording)
    goals = reach.goals
    if goals:
        rr.send_columns(
            f"{entity}/goal",
            indexes=[rr.TimeColumn("time", duration=[goal["start_time_s"] for goal in goals])],
            columns=rr.Points3D.columns(
                positions=[goal["position_world"] for goal in goals],
                radii=[_GOAL_RADIUS_M] * len(goals),
                colors=[_GOAL] * len(goals),
            ),
            recording=recording,
        )


def _log_body(
    place: str,
    body: dict[str, Any],
    color: tuple[int, int, int],
    time_s: NDArray[np.float64],
    recording: rr.RecordingStream | None,
) -> None:
    """Logs the shapes of a body once, and its poses over time."""
    import rerun as rr

    for number, part in enumerate(body["parts"]):
        pose = part["pose_body"]
        at, turned = f"{place}/{number}", rr.Quaternion(xyzw=pose["orientation"])
        rr.log(at, rr.Transform3D(translation=pose["position"], quaternion=turned), static=True, recording=recording)
        rr.log(at, _shape(part["shape"], color), static=True, recording=recording)
    rest = body["rest_pose_world"]
    poses = np.vstack([[*rest["position"], *rest["orientation"]], np.reshape(body["poses_world"], (-1, 7))])
    times_s = np.concatenate([time_s[:1], time_s[body["moved_frames"]]])
    if len(body["moved_frames"]) and body["moved_frames"][0] == 0:
        poses, times_s = poses[1:], times_s[1:]
    rr.send_columns(
        place,
        indexes=[rr.TimeColumn("time", duration=times_s)],
        columns=rr.Transform3D.columns(translation=poses[:, :3], quaternion=poses[:, 3:]),
        recording=recording,
    )


def _shape(shape: dict[str, Any], color: tuple[int, int, int]) -> Any:
    """A shape as a Rerun archetype."""
    import rerun as rr

    (kind, sizes), solid = *shape.items(), rr.components.FillMode.Solid
    if kind == "sphere":
        radius_m = sizes["radius_m"]
        return rr.Ellipsoids3D(half_sizes=[[radius_m] * 3], colors=[color], fill_mode=solid)
    if kind == "cylinder":
        return rr.Cylinders3D(radii=[sizes["radius_m"]], lengths=[sizes["length_m"]], colors=[color], fill_mode=solid)
    if kind == "capsule":
        # Rerun's capsules begin at their origin; ours are centred on it.
        begin = [0.0, 0.0, -sizes["length_m"] / 2]
        return rr.Capsules3D(
            radii=[sizes["radius_m"]], lengths=[sizes["length_m"]], translations=[begin], colors=[color], fill_mode=solid
        )
    if kind == "box":
        return rr.Boxes3D(sizes=[sizes["size_m"]], colors=[color], fill_mode=solid)
    points = np.asarray(sizes["points_m"])
    return rr.Mesh3D(vertex_positions=points, triangle_indices=_hull(points), vertex_colors=[color] * len(points))


def _hull(points: NDArray[np.float64]) -> NDArray[np.uint32]:
    """The triangles of the convex hull of points: those with all points on one side. Hulls have a few dozen points."""
    found = []
    for a, b, c in combinations(range(len(points)), 3):
        normal = np.cross(points[b] - points[a], points[c] - points[a])
        # A tolerance of a billionth of the hull's size, so that rounding leaves no holes in it.
        distance = (points - points[a]) @ normal
        most = 1e-9 * np.abs(points).max() * float(np.linalg.norm(normal))
        if most > 0 and (distance.max() <= most or distance.min() >= -most):
            found.append((a, b, c) if distance.max() <= most else (a, c, b))
    return np.array(found, dtype=np.uint32).reshape(-1, 3)


def _log_patch(reach: _core.Reach, patch: str, entity: str, recording: rr.RecordingStream | None) -> None:
    """Logs the taxels of a patch, what they sense, and the patch's image."""
    import rerun as rr

    sensed_n = reach.sensed_force_n(patch)
    frames, taxels = sensed_n.shape
    time = rr.TimeColumn("time", duration=reach.time_s)
    place = f"{entity}/skin/{patch}"
    positions_m = reach.skin.positions_link(patch)
    rr.log(place, rr.Points3D(positions_m, radii=_TAXEL_RADIUS_M), static=True, recording=recording)
    poses = reach.column(f"observation.patch_pose.{patch}")
    rr.send_columns(
        place,
        indexes=[time],
        columns=[
            *rr.Transform3D.columns(translation=poses[:, :3], quaternion=poses[:, 3:]),
            *rr.Points3D.columns(colors=_colors(sensed_n).reshape(-1)).partition([taxels] * frames),
        ],
        recording=recording,
    )
    rr.send_columns(
        f"{entity}/force/{patch}",
        indexes=[time],
        columns=rr.Scalars.columns(scalars=sensed_n.max(axis=1).astype(np.float64)),
        recording=recording,
    )
    grid = reach.skin.grid(patch)
    if grid is None:
        return
    changed = np.flatnonzero(np.any(np.diff(sensed_n, axis=0, prepend=np.nan) != 0, axis=1))
    stream = recording or rr.get_global_data_recording()
    for frame in changed:
        rr.set_time("time", duration=float(reach.time_s[frame]), recording=stream)
        image = rr.Tensor(sensed_n[frame].reshape(grid), dim_names=("row", "column"))
        rr.log(f"{entity}/image/{patch}", image, recording=stream)
    rr.reset_time(recording=stream)


def _colors(force_n: NDArray[np.float32]) -> NDArray[np.uint32]:
    """Colours as 0xRRGGBBAA, from grey at no force to red."""
    share = np.clip(force_n / _FULL_COLOUR_N, 0.0, 1.0)
    red = 150 + 90 * share
    rest = 150 * (1.0 - share)
    channels = [red, rest, rest, np.full_like(share, 255.0)]
    shifted = [channel.astype(np.uint32) << shift for channel, shift in zip(channels, (24, 16, 8, 0), strict=True)]
    return np.bitwise_or.reduce(shifted)
