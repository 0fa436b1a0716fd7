"""Pictures and films of reaches, and data sets with a camera, decoded again."""

from __future__ import annotations

import inspect
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import underbrush as ub
import underbrush.video
from conftest import quick

av = pytest.importorskip("av")
pa = pytest.importorskip("pyarrow")
pq = pytest.importorskip("pyarrow.parquet")

# The page's colour of arrows.
ARROW = (0x1C, 0x23, 0x29)
CAMERA = ub.Camera((0.9, -1.5, 0.7), (0.55, -0.05, -0.15), size_px=(96, 64))


def _decoded(path: Path) -> tuple[list[float], NDArray[np.uint8]]:
    """The times of the pictures of a film, s, and the pictures."""
    with av.open(str(path)) as file:
        frames = list(file.decode(video=0))
    return [float(frame.time) for frame in frames], np.array([frame.to_ndarray(format="rgb24") for frame in frames])


def _webp(path: Path) -> list[int]:
    """The durations of the pictures of an animated WebP, ms, from its chunks (developers.google.com/speed/webp)."""
    content, place, found = path.read_bytes(), 12, []
    while place < len(content):
        size = int.from_bytes(content[place + 4 : place + 8], "little")
        if content[place : place + 4] == b"ANMF":
            found.append(int.from_bytes(content[place + 20 : place + 23], "little"))
        place += 8 + size + size % 2
    return found


def _difference(found: NDArray[np.uint8], drawn: NDArray[np.uint8]) -> float:
    """The mean difference of two pictures, of 255."""
    return float(np.abs(found.astype(float) - drawn).mean())


def test_a_frame_is_drawn_in_colour_depth_and_labels(data: ub.Dataset) -> None:
    """Tests the shapes, that the background is infinitely far and has label 0, that the arm is seen, and that a frame beyond
    the end is refused."""
    reach = data[0]
    size = {"width": 96, "height": 64, "camera": CAMERA}
    colours = reach.render([0, len(reach) - 1], **size)
    depth, labels = (reach.render([0, len(reach) - 1], kind=kind, **size) for kind in ("depth", "segmentation"))
    assert colours.shape == (2, 64, 96, 3) and depth.shape == labels.shape == (2, 64, 96)
    assert np.array_equal(np.isinf(depth), labels == 0)
    seen = {reach.labels[label] for label in np.unique(labels)}
    assert any(label.startswith("link ") for label in seen) and any(label.startswith("object ") for label in seen)
    assert not np.array_equal(colours[0], colours[1])
    with pytest.raises(ub.InputError, match=f"found {len(reach)}; allowed: 0 to {len(reach) - 1}"):
        reach.render([len(reach)])


def test_readers_see_forces_as_arrows(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that the frame with the most contacts has the colour of arrows in what `draw` (also of a running simulation) and
    `film` show, and in what `render` draws only with `arrows`."""
    contacts = [[len(own) for own in pa.table(reach.frames)["truth.contact_points"].to_pylist()] for reach in data]
    number = int(np.argmax([max(own) for own in contacts]))
    reach, fullest = data[number], int(np.argmax(contacts[number]))
    size = {"width": 800, "height": 450}

    def has_arrows(picture: NDArray[np.uint8]) -> bool:
        return bool((picture == ARROW).all(-1).any())

    (seed, index), name = reach.seed_and_index, reach.scene.removesuffix("-quick")
    simulation = ub.Simulation(quick(name), seed=seed, index=index)
    for angles in reach.equilibrium_angle_rad[: fullest + 1]:
        simulation.step(angles)
    simulation.draw().save(tmp_path / "now.png")
    assert has_arrows(_decoded(tmp_path / "now.png")[1][0]) and not has_arrows(simulation.render(**size))

    without, found = reach.render([fullest], **size)[0], reach.render([fullest], **size, arrows=True)[0]
    assert has_arrows(found) and not has_arrows(without)
    (tmp_path / "drawn.png").write_bytes(reach.draw(fullest).png)
    assert np.array_equal(_decoded(tmp_path / "drawn.png")[1][0], found)
    for arrows, drawn, other in [(True, found, without), (False, without, found)]:
        # At 100 frames per second its second picture is this frame.
        options: dict[str, Any] = {"fps": 10, "speed": fullest / 10, "size": (800, 450), "arrows": arrows}
        underbrush.video.film(reach, tmp_path / "film.mp4", force=True, **options)
        shown = _decoded(tmp_path / "film.mp4")[1][1]
        assert _difference(shown, drawn) < _difference(shown, other)


def test_a_film_shows_the_frames(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that a film at twice the speed has a picture for each 80 ms of the reach, and shows what `render` draws, within
    the loss of the encoder: up to 2 of 255 by rounding, and at edges half the resolution of colours."""
    reach = data[0]
    options: dict[str, Any] = {"speed": 2, "size": (128, 96), "camera": CAMERA, "arrows": False}
    count = underbrush.video.film(reach, tmp_path / "film.mp4", **options)
    times, pictures = _decoded(tmp_path / "film.mp4")
    assert count == len(pictures) == (len(reach) - 1) // 8 + 1
    assert np.allclose(np.diff(times), 0.04, atol=1e-3)
    middle = count // 2
    drawn = reach.render([8 * middle], 128, 96, camera=CAMERA)[0]
    others = reach.render([0, 8 * (count - 1)], 128, 96, camera=CAMERA)
    assert _difference(pictures[middle], drawn) < min(6.0, *(_difference(pictures[middle], other) for other in others))
    assert underbrush.video.film(reach, tmp_path / "film.webp", **options) == count
    assert _webp(tmp_path / "film.webp") == [40] * count


def test_an_animated_webp_plays_without_end(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that the loop count in the chunk ANIM is 0, which means no end (developers.google.com/speed/webp)."""
    underbrush.video.film(data[0], tmp_path / "film.webp", fps=1, size=(64, 64))
    content = (tmp_path / "film.webp").read_bytes()
    place = content.index(b"ANIM")
    assert content[place + 12 : place + 14] == bytes(2)


def test_what_cannot_be_filmed_is_refused(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests the errors for another ending, odd sizes, a rate that does not divide that of the data set, and the size of a camera
    without its place; nothing is left."""
    with pytest.raises(ub.InputError, match=r"film\.avi"):
        underbrush.video.film(data[0], tmp_path / "film.avi")
    with pytest.raises(ub.InputError, match="97 x 64"):
        underbrush.video.film(data[0], tmp_path / "film.mp4", size=(97, 64))
    arguments = ["lerobot", str(data.path), "--out", str(tmp_path / "set"), "--fps"]
    assert underbrush.video.main([*arguments, "30"]) == 2
    assert underbrush.video.main([*arguments, "25", "--size", "64x64"]) == 2
    assert not list(tmp_path.iterdir())


def test_a_camera_is_added_to_a_data_set(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that every fourth frame is kept with its numbers and its picture, and what LeRobot's loader relies on: the bounds
    of the episodes, the times of the films, and the statistics of the pictures."""
    out = tmp_path / "set"
    count = underbrush.video.lerobot(data.path, out, {"front": CAMERA})
    info = json.loads((out / "meta" / "info.json").read_text())
    table = pq.read_table(out / "data" / "chunk-000" / "file-000.parquet")
    episodes = pq.read_table(out / "meta" / "episodes" / "chunk-000" / "file-000.parquet").to_pylist()
    assert (info["fps"], info["total_frames"], len(table), len(episodes)) == (25, count, count, len(data))
    assert table["index"].to_pylist() == list(range(count))
    key = "observation.images.front"
    assert info["features"][key]["shape"] == [64, 96, 3]
    assert set(info["features"]) == {*table.column_names, key}
    end = 0
    for row, reach in zip(episodes, (data[index] for index in range(len(data)))):
        assert row["dataset_from_index"] == end
        end = row["dataset_to_index"]
        kept = table.slice(row["dataset_from_index"], row["length"])
        assert np.array_equal(np.array(kept["action"].to_pylist()), reach.column("action")[::4])
        path = info["video_path"].format(video_key=key, chunk_index=0, file_index=row[f"videos/{key}/file_index"])
        times, pictures = _decoded(out / path)
        # LeRobot's loader looks for a picture within 0.1 ms.
        assert np.allclose(times, kept["timestamp"].to_numpy(), atol=1e-4)
        assert row[f"videos/{key}/to_timestamp"] == pytest.approx(times[-1] + 0.04)
        assert _difference(pictures[-1], reach.render([4 * (len(times) - 1)], 96, 64, camera=CAMERA)[0]) < 6.0
        mean = np.ravel(row[f"stats/{key}/mean"])
        assert np.allclose(mean, pictures.mean((0, 1, 2)) / 255, atol=0.03)
    assert end == count
    statistics: dict[str, Any] = json.loads((out / "meta" / "stats.json").read_text())
    assert set(statistics) == set(info["features"])
    assert np.array(statistics[key]["std"]).shape == (3, 1, 1)


def test_depth_is_added_to_a_data_set(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that Pillow, with which LeRobot's loader reads pictures, decodes the depth of each frame as what `render` draws, to
    1 mm, with 0 where nothing is, and that feature and statistics are those that the loader expects of a depth map in mm."""
    image = pytest.importorskip("PIL.Image")
    out = tmp_path / "set"
    underbrush.video.lerobot(data.path, out, {"front": CAMERA}, depth=True)
    key = "observation.images.front_depth"
    info = json.loads((out / "meta" / "info.json").read_text())
    assert info["features"][key]["dtype"] == "image" and info["features"][key]["shape"] == [64, 96, 1]
    assert info["features"][key]["info"] == {"is_depth_map": True, "depth_unit": "mm"}
    table = pq.read_table(out / "data" / "chunk-000" / "file-000.parquet")
    assert table["index"].to_pylist() == list(range(len(table))) and {*table.column_names} <= {*info["features"]}
    row = pq.read_table(out / "meta" / "episodes" / "chunk-000" / "file-000.parquet").to_pylist()[1]
    kept = table.slice(row["dataset_from_index"], row["length"])
    pictures = [image.open(io.BytesIO(own["bytes"])) for own in kept[key].to_pylist()]
    assert {picture.mode for picture in pictures} == {"I;16"}
    found_mm = np.array([np.array(picture) for picture in pictures])
    drawn_m = data[1].render(range(0, len(data[1]), 4), 96, 64, camera=CAMERA, kind="depth")
    is_there = np.isfinite(drawn_m)
    assert 0.1 < is_there.mean() < 0.99 and not found_mm[~is_there].any()
    assert np.abs(found_mm[is_there] / 1000 - drawn_m[is_there]).max() <= 0.5e-3 + 1e-6
    statistics: dict[str, Any] = json.loads((out / "meta" / "stats.json").read_text())[key]
    assert np.array(statistics["mean"]).shape == (1, 1, 1)
    # Statistics are of every fourth pixel of a few pictures, so the edges of shapes of 20 pixels are off by up to two.
    assert np.ravel(row[f"stats/{key}/mean"]) == pytest.approx(found_mm.mean(), rel=0.1)
    other = {"front": CAMERA, "front_depth": CAMERA}
    with pytest.raises(ub.InputError, match="front_depth"):
        underbrush.video.lerobot(data.path, tmp_path / "refused", other, depth=True)


def test_the_cameras_of_a_scene_take_the_pictures(tmp_path: Path) -> None:
    """Tests that a data set of a scene with two cameras gets the pictures of both, that the one which a link carries sees the
    link at the same place of the picture in every frame, and what is refused: a second scene with other cameras, names of cameras
    that cannot be those of features, and links and names of cameras that do not exist."""
    cameras = [
        {"name": "front", "eye_m": [0.9, -1.5, 0.7], "target_m": [0.55, -0.05, -0.15], "size_px": [96, 64]},
        {"name": "hand", "link": "forearm", "eye_m": [0.25, 0, 0.13], "target_m": [0, 0, 0.13], "size_px": [64, 64]},
    ]
    one_goal = {"goals": {"count": 1}}
    scene = ub.Scene("trunk").changed(one_goal | {"cameras": cameras})
    assert list(scene.cameras) == ["front", "hand"] and scene.cameras["hand"].size_px == (64, 64)
    # Cameras of scenes and of Python have the same default angle.
    stated = inspect.signature(ub.Camera).parameters["vertical_fov_deg"].default
    assert scene.cameras["front"].vertical_fov_deg == CAMERA.vertical_fov_deg == stated
    data = ub.generate(scene, 1, tmp_path / "one", seed=1, progress=False)
    count = underbrush.video.lerobot(data.path, tmp_path / "pictures")
    info = json.loads((tmp_path / "pictures" / "meta" / "info.json").read_text())
    shapes = {name: feature["shape"] for name, feature in info["features"].items() if "images" in name}
    assert shapes == {"observation.images.front": [64, 96, 3], "observation.images.hand": [64, 64, 3]}
    assert info["total_frames"] == count
    reach = data[0]
    label = reach.labels.index("link forearm")
    seen = reach.render([0, len(reach) - 1], 64, 64, camera=scene.cameras["hand"], kind="segmentation") == label
    assert seen[0].any() and (seen[0] != seen[1]).mean() < 0.02
    assert not np.array_equal(*reach.render([0, len(reach) - 1], 64, 64, camera=scene.cameras["hand"]))
    other = ub.generate([scene, ub.Scene("leaf").changed(one_goal)], 1, tmp_path / "two", seed=1, progress=False)
    with pytest.raises(ub.InputError, match="the same names and sizes as in trunk"):
        underbrush.video.lerobot(other.path, tmp_path / "refused")
    for name in ("a/b", "../out", ""):
        with pytest.raises(ub.InputError, match="letters, digits, - and _"):
            underbrush.video.lerobot(data.path, tmp_path / "refused", {name: scene.cameras["hand"]})
    with pytest.raises(ub.InputError, match="found the link \"thumb\""):
        reach.render([0], camera=ub.Camera((1, 0, 0), (0, 0, 0), link="thumb"))
    film = ["film", str(data.path), "--out", str(tmp_path / "film.mp4"), "--size", "96x64", "--camera"]
    assert [underbrush.video.main([*film, name]) for name in ("back", "front")] == [2, 0]
