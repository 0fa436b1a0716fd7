"""Reaches in Rerun, read back by Rerun's own reader. Skipped if Rerun is not installed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import quick

import underbrush as ub
import underbrush.rerun

rr = pytest.importorskip("rerun")


def columns(path: Path) -> dict[str, dict[str, list[Any]]]:
    """All columns of a file: {entity: {column: values}}, in the order of time."""
    from rerun.chunk import RrdReader

    found: dict[str, dict[str, list[Any]]] = {}
    for chunk in RrdReader(path).stream():
        batch = chunk.to_record_batch()
        entity = found.setdefault(chunk.entity_path, {})
        for name in batch.schema.names:
            entity.setdefault(name.split(":")[-1], []).extend(batch.column(name).to_pylist())
    return found


def test_a_reach_comes_back_from_rerun(tmp_path: Path) -> None:
    """Tests that forces, taxels, poses of the arm and goals are in the file with the numbers of the reach."""
    reach = ub.reach(quick("leaf"), seed=3)
    path = tmp_path / "reach.rrd"
    with rr.RecordingStream("underbrush") as recording:
        recording.save(path)
        underbrush.rerun.log(reach, recording=recording)
        recording.flush()
        recording.disconnect()
    found = columns(path)
    forces = found["/reach/force/forearm"]
    assert np.allclose(np.ravel(forces["scalars"]), reach.sensed_force_n("forearm").max(axis=1), rtol=1e-12, atol=0)
    times_s = [time.total_seconds() for time in forces["time"]]
    assert np.allclose(times_s, reach.time_s, atol=1e-6)
    skin = found["/reach/skin/forearm"]
    assert np.allclose(next(p for p in skin["positions"] if p), reach.skin.positions_link("forearm"), atol=1e-6)
    colors = [row for row in skin["colors"] if row]
    assert len(colors) == len(reach)
    # A taxel that senses nothing is grey. The more force it senses, the redder it is.
    red = np.array([[color >> 24 for color in row] for row in colors])
    sensed_n = reach.sensed_force_n("forearm")
    assert 90 * sensed_n.max() / 5.0 > 1
    assert np.all((red == 150) == (90 * np.minimum(sensed_n, 5.0) / 5.0 < 1))
    link = reach.frame(len(reach) - 1).patch_pose_world("forearm")
    assert np.allclose(np.ravel([row for row in skin["translation"] if row][-1]), link[:3], atol=1e-6)
    goal = found["/reach/goal"]
    assert np.allclose(np.ravel(goal["positions"]), reach.goals[0]["position_world"], atol=1e-6)
    images = found["/reach/image/forearm"]
    assert 0 < len(images["data"]) <= len(reach)


def test_bodies_are_where_the_patches_are() -> None:
    """Tests that the link under the forearm's patch has the pose that the last frame gives it, within the step in which
    poses are stored, and that every object has a shape."""
    reach = ub.reach(quick("leaf"), seed=3)
    bodies = reach.bodies
    assert all(body["parts"] for body in bodies if "object" in body["owner"])
    links = {body["owner"]["link"]: body for body in bodies if "link" in body["owner"]}
    objects = {body["owner"]["object"] for body in bodies if "object" in body["owner"]}
    assert objects == set(range(len(reach.objects)))
    last = len(reach) - 1
    expected = reach.frame(last).patch_pose_world("forearm")[:3]
    places = [body["poses_world"][-1][:3] for body in links.values() if body["moved_frames"]]
    assert min(float(np.abs(np.subtract(place, expected)).max()) for place in places) < 0.87 / 8192
