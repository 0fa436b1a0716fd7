"""Scenes: loading, changing, drawing, refusing."""

import pickle
import shutil
from pathlib import Path

import numpy as np
import pytest

import underbrush as ub


def test_shipped_scenes_are_those_of_the_repository() -> None:
    """Tests that every scene that ships loads by its name, with the text of its file."""
    folder = Path(__file__).parents[2] / "scenes"
    files = {path.stem: path for path in folder.rglob("*.toml")}
    assert sorted(ub.Scene.names()) == sorted(files)
    for name, path in files.items():
        assert ub.Scene(name).text == path.read_text()
        assert ub.Scene(path).text == ub.Scene(name).text


def test_changes_are_merged() -> None:
    """Tests that a change of one key leaves its neighbours, and that a new name makes another scene."""
    scene = ub.Scene("mixed")
    changed = scene.changed({"goals": {"count": 2}}, name="two")
    assert (changed.name, changed.to_dict()["goals"]["count"]) == ("two", 2)
    assert changed.to_dict()["goals"]["patience_s"] == scene.to_dict()["goals"]["patience_s"]
    assert len(changed.clutter(seed=3)["goals"]) == 2
    assert scene.changed({"goals": {"count": 2}}).name == "mixed"


def test_changes_that_hold_themselves_are_refused() -> None:
    """Tests that a dictionary and a list that hold themselves are refused."""
    table: dict[str, object] = {}
    table["goals"] = table
    items: list[object] = []
    items.append(items)
    for changes in (table, {"goals": items}):
        with pytest.raises(ub.InputError, match="16 dictionaries and lists within each other"):
            ub.Scene("leaf").changed(changes)


def test_infinity_stays_infinity() -> None:
    """Tests that a saturation that is switched off by infinity comes back from the dictionary of a scene, and that the
    dictionary can be given as a change."""
    scene = ub.Scene("mixed").changed({"sensor": {"saturation_n": float("inf")}})
    assert scene.to_dict()["sensor"]["saturation_n"] == float("inf")
    assert ub.Scene("mixed").changed(scene.to_dict()).to_dict() == scene.to_dict()


def test_materials_are_drawn_or_given() -> None:
    """Tests that the constants of the file that ships enter the scene, that drawn ones are stored with the objects, differ from
    reach to reach and leave objects and goals where they are, and that a scene takes them once."""
    scene = ub.Scene("trunk")
    drawn = scene.with_materials(randomize=True)
    usual, first, second = scene.clutter(1, 0), drawn.clutter(1, 0), drawn.clutter(1, 1)
    assert [own["position_world"] for own in first["objects"]] == [own["position_world"] for own in usual["objects"]]
    assert np.array_equal(first["goals"], usual["goals"])
    stored = [clutter["objects"][0]["parameters"] for clutter in (usual, first, second)]
    constants = stored[1].keys() - stored[0].keys()
    assert "arm_friction" in constants and constants <= stored[2].keys()
    assert all(stored[1][name] != stored[2][name] for name in constants)
    given = scene.with_materials().to_dict()["materials"]
    assert given.keys() == drawn.to_dict()["materials"].keys() and given != drawn.to_dict()["materials"]
    with pytest.raises(ub.InputError, match="a section of its own"):
        drawn.with_materials()


def test_pictures_are_png(tmp_path: Path) -> None:
    """Tests that scenes and simulations can be drawn as PNG, which a notebook shows, and that both draw the same start."""
    scene = ub.Scene("leaf")
    assert scene._repr_png_().startswith(b"\x89PNG")
    scene.draw(seed=2).save(tmp_path / "leaf.png")
    assert (tmp_path / "leaf.png").read_bytes() == scene.draw(seed=2).png
    assert ub.Simulation(scene, seed=2).draw().png == scene.draw(seed=2).png != scene.draw(seed=3).png


def test_clutter_is_drawn_by_seed() -> None:
    """Tests that the same seed and index draw the same clutter, and that another index draws another."""
    scene = ub.Scene("mixed")
    first, again, other = scene.clutter(1, 0), scene.clutter(1, 0), scene.clutter(1, 1)
    assert first["objects"] == again["objects"] != other["objects"]
    assert np.array_equal(first["goals"], again["goals"])
    kinds = {found["kind"] for found in first["objects"]}
    assert {"leaf", "trunk", "foam_block"} <= kinds


def test_bad_scenes_are_refused_with_their_place(tmp_path: Path) -> None:
    """Tests that an error names file, line, field, what was found, what is allowed and the remedy."""
    path = tmp_path / "bad.toml"
    path.write_text('summary = "x"\n[[objects.leaf]]\ncount = 5\nwidth_m = { uniform = [0.02, -0.05] }\n')
    with pytest.raises(ub.InputError) as found:
        ub.Scene(path)
    error = found.value
    assert (error.file, error.line, error.field) == (str(path), 4, "objects.leaf[0].width_m")
    assert error.found == "{ uniform = [0.02, -0.05] }"
    assert error.allowed == "the lower bound first" and error.remedy
    assert isinstance(error, ValueError) and str(path) in str(error)
    copied = pickle.loads(pickle.dumps(error))
    assert (str(copied), copied.line, copied.remedy) == (str(error), 4, error.remedy)
    with pytest.raises(ub.InputError, match="leaf-clump"):
        ub.Scene("no-such-scene")
    with pytest.raises(ub.InputError, match="scene"):
        ub.Scene(3)  # type: ignore[arg-type]


def test_scenes_are_pickled() -> None:
    """Tests that a scene survives pickling with its text and name."""
    scene = ub.Scene("leaf").changed({"goals": {"count": 1}}, name="one")
    copied = pickle.loads(pickle.dumps(scene))
    assert (copied.text, copied.name) == (scene.text, scene.name)


def test_a_pickled_scene_finds_its_own_arm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests that a scene that was loaded by a relative path, and its copies, find the arm beside it in another folder."""
    (tmp_path / "else").mkdir()
    (tmp_path / "own.toml").write_text('summary = "x"\narm = "cody/cody.toml"\ngoals = { count = 1 }\n')
    shutil.copytree(Path(__file__).parents[2] / "sim/arms/cody", tmp_path / "cody")
    monkeypatch.chdir(tmp_path)
    scene = ub.Scene("own.toml")
    pickled, drawn = pickle.dumps(scene), scene.draw().png
    monkeypatch.chdir(tmp_path / "else")
    copied = pickle.loads(pickled)
    assert (copied.name, copied.draw().png) == ("own", drawn)
    assert scene.draw().png == drawn == pickle.loads(pickle.dumps(scene)).draw().png
