"""Files and data sets that exist already."""

import pickle
from collections.abc import Callable
from pathlib import Path

import pytest

import underbrush as ub

from conftest import quick


def test_only_force_overwrites(data: ub.Dataset, trials: ub.Trials, tmp_path: Path) -> None:
    """Tests that every call that writes a file or a data set refuses one that exists, and overwrites it with force."""
    kinds = {
        "trials.csv": trials,
        "model.json": ub.fit(trials, "naive-bayes"),
        "reach.parquet": data[0],
        "page.html": ub.replay(data, [0]),
        "scene.png": ub.Scene("leaf").draw(),
    }
    for name, kind in kinds.items():
        path = tmp_path / name
        path.write_text("mine")
        with pytest.raises(ub.InputError, match="exists already"):
            kind.save(path)
        assert path.read_text() == "mine"
        kind.save(path, force=True)
        assert path.read_bytes() != b"mine"
    out = tmp_path / "set"
    for seed in (1, 2):
        ub.generate(quick("leaf"), 1, out, seed=seed, force=True, progress=False)
    with pytest.raises(ub.InputError, match="finished data set"):
        ub.generate(quick("leaf"), 1, out, seed=3, progress=False)
    with pytest.raises(ub.InputError, match="an input of this command"):
        ub.generate_again(out, out, force=True, progress=False)
    with pytest.raises(ub.InputError, match="leave one out"):
        ub.generate(quick("leaf"), 1, out, resume=True, force=True, progress=False)
    part = ub.generate(quick("leaf"), 2, tmp_path / "part", shard=(1, 2), progress=False)
    with pytest.raises(ub.InputError, match="without 2/2"):
        ub.merge([part.path], out, force=True)
    assert len(ub.Dataset(out)) == 1


def test_nothing_is_saved_into_a_data_set(data: ub.Dataset, trials: ub.Trials) -> None:
    """Tests that no file is written into the folder of a data set."""
    kinds = {
        "trials.csv": trials,
        "model.json": ub.fit(trials, "naive-bayes"),
        "reach.parquet": data[0],
        "scene.png": ub.Scene("leaf").draw(),
    }
    for name, kind in kinds.items():
        with pytest.raises(ub.InputError, match="found a place within the data set"):
            kind.save(data.path / "new" / name, force=True)
    assert not (data.path / "new").exists()


def test_remedies_are_those_of_python(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that errors name arguments and functions of Python and no option of the command line, and so do their remedies."""

    def interrupted(done: int, total: int, text: str) -> None:
        raise KeyboardInterrupt

    scene, begun = quick("leaf"), tmp_path / "begun"
    with pytest.raises(KeyboardInterrupt):
        ub.generate(scene, 3, begun, progress=interrupted)
    data[0].save(tmp_path / "reach.parquet")
    wrong = tmp_path / "wrong.toml"
    wrong.write_text("sumary = 1\n")
    controllers = [scene, scene.changed({"controller": "blind"}, name="blind")]
    calls: dict[str, tuple[Callable[[], object], str]] = {
        "finished": (lambda: ub.generate(scene, 1, data.path, progress=False), "force=True"),
        "unfinished": (lambda: ub.generate(scene, 3, begun, progress=False), "resume=True to finish it, or with force=True"),
        "saved": (lambda: data[0].save(tmp_path / "reach.parquet"), "force=True"),
        "no part": (lambda: ub.merge([data.path], tmp_path / "merged"), "underbrush.generate(..., shard=(I, N))"),
        "no suite": (lambda: ub.check("nosuch.toml"), "python -m underbrush schema suite"),
        "key of a suite": (lambda: ub.check(wrong), "python -m underbrush schema suite"),
        "key of a scene": (lambda: ub.Scene(wrong), "python -m underbrush schema"),
        "controllers": (lambda: ub.generate(controllers, 1, tmp_path / "two", progress=False), "the argument controller"),
    }
    for name, (call, named) in calls.items():
        with pytest.raises(ub.InputError) as caught:
            call()
        text, again = str(caught.value), pickle.loads(pickle.dumps(caught.value))
        assert named in text and "--" not in text and "--" not in (caught.value.remedy or ""), f"{name}: {text}"
        assert (str(again), again.remedy, again.allowed) == (text, caught.value.remedy, caught.value.allowed)
