"""Sets of many parts, as far as this needs no Ray. With Ray, see cluster.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from conftest import quick

import underbrush as ub
from underbrush import distributed


def test_parts_of_another_call_are_refused(tmp_path: Path) -> None:
    """Tests that a folder is taken as long as it holds no finished part, that the same call continues with as many
    parts as before, that another call is told in what it differs from the one whose parts are there, and that numbers of parts or
    campaigns that are not possible are refused before anything is run."""
    folder, model = tmp_path / "set.parts", tmp_path / "touch.json"
    model.write_text("a model")

    class Own:
        name = "own"

    def claim(parts: int | None = None, default: int = 4, **changes: Any) -> int:
        call = {"scenes": [["leaf", "hash"]], "reaches": 2, "seed": 1, "controller": Own, "verdicts": model}
        return distributed._claim(folder, distributed._call(**{**call, **changes}), parts, default)

    assert claim(seed=7) == 4
    assert claim(parts=3) == 3
    (folder / "2").mkdir()
    assert claim() == claim(default=9) == claim(parts=3, controller="own") == 3
    for changes, text in (
        ({"seed": 2}, "differs in seed"),
        ({"reaches": 3, "controller": "blind"}, "differs in controller and reaches"),
        ({"verdicts": None}, "differs in verdicts"),
        ({"parts": 2}, "differs in parts"),
    ):
        with pytest.raises(ub.InputError, match=f"{text}; allowed") as found:
            claim(**changes)
        assert (found.value.file, found.value.field) == (str(folder), "out") and "remove" in str(found.value.remedy)
    model.write_text("another model")
    with pytest.raises(ub.InputError, match="differs in verdicts"):
        claim()
    with pytest.raises(ub.InputError, match="parts: found -1; allowed: a whole number, 1 or more"):
        claim(parts=-1)
    with pytest.raises(ub.InputError, match="campaigns: found 20000; allowed: a whole number, 1 to 10000"):
        distributed.reproduce(tmp_path / "study", campaigns=20_000)
    (folder / "call.json").unlink()
    with pytest.raises(ub.InputError, match="unknown call"):
        claim()


def test_verdicts_of_parts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests that parts have a touch model by its absolute path, and the true categories as such."""
    parts: list[Any] = []
    monkeypatch.setattr(distributed, "_connect", lambda address: None)
    monkeypatch.setattr(distributed, "_in_parts", lambda make, *rest: parts.append(make))
    for verdicts in (tmp_path / "touch.json", "touch.json", "truth", None):
        distributed.generate("leaf", 1, tmp_path / "set", verdicts=verdicts)
    found = [make.keywords["verdicts"] for make in parts]
    assert found == [tmp_path / "touch.json", Path("touch.json").absolute(), Path("truth"), None]


def test_a_finished_set_is_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests that a call whose set is finished opens it without any task, and that the set of another call is
    refused."""
    monkeypatch.setattr(distributed, "_connect", lambda address: pytest.fail("a cluster was asked for"))
    scene, out = quick("leaf"), tmp_path / "set"
    made = ub.generate(scene, 1, out, seed=3, progress=False)
    assert distributed.generate(scene, 1, out, seed=3).path == made.path
    with pytest.raises(ub.InputError, match="seed"):
        distributed.generate(scene, 1, out, seed=4)


def test_only_a_missing_or_begun_set_is_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests that a set is made on a cluster if its folder is missing, empty or begun, and that a folder that the disk
    cannot read, a damaged set, other files and a file are refused before any task is run."""

    class Asked(Exception):
        """A cluster was asked for."""

    def connect(address: str | None) -> None:
        raise Asked

    monkeypatch.setattr(distributed, "_connect", connect)
    scene, out = quick("leaf"), tmp_path / "set"
    for prepare in (lambda: None, out.mkdir, (out / "incomplete").mkdir):
        prepare()
        with pytest.raises(Asked):
            distributed.generate(scene, 1, out, seed=3)
    damaged, foreign, file, loop = (tmp_path / name for name in ("damaged", "foreign", "file", "loop"))
    ub.generate(scene, 1, damaged, seed=3, progress=False)
    (damaged / "meta" / "stats.json").unlink()
    foreign.mkdir()
    for path in (foreign / "notes.txt", file):
        path.write_text("notes")
    # The operating system follows a link to itself until it fails.
    loop.symlink_to(loop)
    refusals = ((damaged, ub.InputError), (foreign, ub.InputError), (file, ub.InputError), (loop, ub.StorageError))
    for folder, error in refusals:
        with pytest.raises(error, match=folder.name):
            distributed.generate(scene, 1, folder, seed=3)
