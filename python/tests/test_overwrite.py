"""Files and data sets that exist already."""

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
    assert len(ub.Dataset(out)) == 1
