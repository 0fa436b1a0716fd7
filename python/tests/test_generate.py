"""Making data sets: progress, Ctrl-C, resuming, controllers that fail."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import quick

import underbrush as ub
from underbrush._progress import Bar


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_set_equals_that_of_the_command_line(tmp_path: Path, data: ub.Dataset, command) -> None:
    """Tests that a data set from Python is the same, byte for byte, as one from the command line, and one made again
    from itself."""
    files = []
    for name in ("leaf", "trunk"):
        files.append(tmp_path / f"{name}-quick.toml")
        files[-1].write_text(quick(name).text)
    command("generate", *files, "--reaches", 4, "--seed", 1, "--out", tmp_path / "cli")
    assert contents(tmp_path / "cli") == contents(data.path)
    again = ub.generate_again(data.path, tmp_path / "again", progress=False)
    assert contents(again.path) == contents(data.path)


def test_progress_is_reported(tmp_path: Path) -> None:
    """Tests that a progress function sees the count rise to the total, on the calling thread."""
    seen, threads = [], set()

    def progress(done: int, total: int, text: str) -> None:
        seen.append((done, total, text))
        threads.add(threading.get_ident())

    ub.generate(quick("leaf"), 3, tmp_path / "set", seed=2, progress=progress, jobs=1)
    counts = [done for done, _, _ in seen]
    assert counts == sorted(counts) and seen[-1][:2] == (3, 3) and "of 3 goals reached" in seen[-1][2]
    assert threads == {threading.get_ident()}


def test_progress_needs_no_standard_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests that a program without a standard error, such as pythonw, can make a progress bar."""
    monkeypatch.setattr(sys, "stderr", None)
    Bar("reaches")(1, 2, "leaf")


def test_skin_that_nothing_touches_is_warned_of(tmp_path: Path) -> None:
    """Tests that the warnings of `underbrush reach` and `underbrush generate` about the reaches are Python warnings."""
    scene = ub.Scene.parse('summary = "Free space"\ngoals = { count = 1, x_m = 0.6, y_m = 0.0, z_m = -0.2 }\n', "free.toml")

    def still(given: ub.ControllerInput) -> np.ndarray:
        return given.equilibrium_angle_rad

    with pytest.warns(UserWarning, match="^nothing touched the skin in any frame of the reach"):
        ub.reach(scene, controller=still)
    with pytest.warns(UserWarning, match="^nothing touched the skin in any frame of the reach"):
        ub.generate(scene, 1, tmp_path / "set", controller=still, progress=False)


def test_an_exception_at_the_end_is_raised(tmp_path: Path) -> None:
    """Tests that an exception of the function for progress is raised even if the set is complete by then, once."""
    calls: list[int] = []

    def once(done: int, total: int, text: str) -> None:
        if done == total and not calls:
            calls.append(done)
            raise RuntimeError("mine")

    with pytest.raises(RuntimeError, match="mine"):
        ub.generate(quick("trunk"), 1, tmp_path / "set", progress=once)


class Nested:
    """A controller that simulates a reach of its own before it begins."""

    def __init__(self, arm: ub.Arm) -> None:
        ub.reach(quick("trunk"), controller=lambda input: input.equilibrium_angle_rad)

    def __call__(self, input: ub.ControllerInput) -> np.ndarray:
        return input.equilibrium_angle_rad


def test_controllers_may_call_the_package(tmp_path: Path) -> None:
    """Tests that controllers on all threads may simulate reaches themselves: none waits for a thread that another one keeps."""
    reaches = 2 * (os.cpu_count() or 1)
    made = ub.generate(quick("trunk"), reaches, tmp_path / "set", controller=Nested, progress=False)
    assert len(made) == reaches


def test_an_interrupted_set_is_resumed(tmp_path: Path) -> None:
    """Tests that Ctrl-C ends a run soon, that finished reaches are kept and the set is reported as unfinished, and that
    resuming gives the bytes of a run that was not interrupted."""
    scene, out = quick("mixed"), tmp_path / "set"

    def progress(done: int, total: int, text: str) -> None:
        if done >= 2:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        ub.generate(scene, 6, out, seed=4, progress=progress, jobs=2)
    with pytest.raises(ub.InputError, match="unfinished"):
        ub.Dataset(out)
    with pytest.raises(ub.InputError, match="unfinished"):
        ub.generate(scene, 6, out, seed=4, progress=False)
    staged = {path: path.stat().st_mtime_ns for path in (out / "incomplete").glob("reach-*.bin")}
    assert len(staged) >= 2
    resumed = ub.generate(scene, 6, out, seed=4, progress=False, resume=True)
    whole = ub.generate(scene, 6, tmp_path / "whole", seed=4, progress=False)
    assert contents(resumed.path) == contents(whole.path)
    assert len(ub.generate(scene, 6, out, seed=4, progress=False, resume=True)) == 6


class Planner:
    """A controller that steps simulations of its own, and counts how many controllers are at work on this thread."""

    working = 0
    most = 0

    def __init__(self, arm: ub.Arm) -> None:
        self.simulations = [ub.Simulation("trunk", seed) for seed in (0, 1)]

    def __call__(self, input: ub.ControllerInput) -> np.ndarray:
        Planner.working += 1
        Planner.most = max(Planner.most, Planner.working)
        ub.step_many(self.simulations, [input.equilibrium_angle_rad] * 2)
        Planner.working -= 1
        return input.equilibrium_angle_rad


def test_no_controller_runs_inside_another(tmp_path: Path) -> None:
    """Tests that a thread that waits for what its controller calls does not begin another reach meanwhile."""
    ub.generate(quick("trunk"), 8, tmp_path / "set", controller=Planner, progress=False, jobs=1)
    assert Planner.most == 1


def test_a_failing_controller_leaves_the_set_sound(tmp_path: Path) -> None:
    """Tests that a controller that raises ends the run with its exception, and that the set can be finished once the
    controller is mended."""
    scene, out = quick("leaf"), tmp_path / "set"
    broken = True

    class Fragile:
        name = "fragile"

        def __init__(self, arm: ub.Arm) -> None:
            self.calls = 0

        def __call__(self, given: ub.ControllerInput) -> np.ndarray:
            self.calls += 1
            if broken and given.goal_position_world[0] > 0 and self.calls == 8:
                raise ZeroDivisionError("in the eighth call")
            return given.equilibrium_angle_rad

    with pytest.raises(ZeroDivisionError, match="eighth"):
        ub.generate(scene, 2, out, seed=1, controller=Fragile, progress=False, jobs=1)
    broken = False
    done = ub.generate(scene, 2, out, seed=1, controller=Fragile, progress=False, jobs=1, resume=True)
    assert len(done) == 2 and done[0].controller == "fragile"
    done.verify()


def test_parts_share_a_folder(tmp_path: Path) -> None:
    """Tests that parts in one folder make the set of one call, byte for byte. The part that ends last returns the set,
    the other returns None. A part that is run again finds the set. Parts of other campaigns and bad parts are
    refused."""
    whole = ub.generate(quick("leaf"), 2, tmp_path / "whole", seed=3, progress=False)
    seen: list[tuple[int, int]] = []

    def part(number: int, seed: int = 3) -> ub.Dataset | None:
        return ub.generate_shared(
            quick("leaf"), 2, tmp_path / "set", (number, 2), seed=seed, progress=lambda done, total, _: seen.append((done, total))
        )

    assert part(2) is None
    assert seen[-1] == (1, 1)
    with pytest.raises(ub.InputError, match="unfinished"):
        ub.Dataset(tmp_path / "set")
    with pytest.raises(ub.InputError, match="seed"):
        part(1, seed=4)
    with pytest.raises(ub.InputError, match="I <= N"):
        part(3)
    made = part(1)
    assert made is not None and contents(made.path) == contents(whole.path)
    again = part(2)
    assert again is not None and again.path == made.path


def test_shards_make_the_whole(tmp_path: Path) -> None:
    """Tests that two shards hold the reaches of the whole set and merge into it byte for byte, and that bad shards,
    scenes with equal names, bad numbers of threads or reaches, and other objects are refused."""
    whole = ub.generate(quick("leaf"), 2, tmp_path / "whole", seed=3, progress=False)
    parts = [ub.generate(quick("leaf"), 2, tmp_path / str(part), seed=3, shard=(part, 2), progress=False) for part in (1, 2)]
    assert [len(part) for part in parts] == [1, 1]
    for part, reach in zip(parts, whole, strict=True):
        assert np.array_equal(part[0].column("action"), reach.column("action"))
    merged = ub.merge([parts[1].path, parts[0].path], tmp_path / "merged")
    assert contents(merged.path) == contents(whole.path)
    with pytest.raises(ub.InputError, match="2"):
        ub.merge([parts[0].path], tmp_path / "none")
    for shard in ((3, 2), (-1, 2), (1, 2, 3), 1):
        with pytest.raises(ub.InputError, match="shard: found .* allowed: .* I <= N"):
            ub.generate(quick("leaf"), 2, tmp_path / "none", shard=shard, progress=False)
    with pytest.raises(ub.InputError, match="given twice"):
        ub.generate([quick("leaf"), quick("leaf")], 1, tmp_path / "none", progress=False)
    for reaches in (0, 10**9):
        with pytest.raises(ub.InputError, match=f"^{reaches} reaches of each scene; allowed: 1 to 1000000"):
            ub.generate("leaf", reaches, tmp_path / "none")
    with pytest.raises(ub.InputError, match="threads"):
        ub.generate(quick("leaf"), 1, tmp_path / "none", progress=False, jobs=0)
    for given, text in (
        ({"scenes": 3}, "scenes: found an object of type int"),
        ({"reaches": 1.5}, "reaches: found 1.5; allowed: a whole number"),
        ({"seed": 2**64}, "seed: found 18446744073709551616; allowed: a whole number"),
        ({"progress": 3}, "progress: found an object of type int"),
    ):
        with pytest.raises(ub.InputError, match=text):
            ub.generate(**{"scenes": "leaf", "reaches": 1, "out": tmp_path / "none", "progress": False, **given})
    with pytest.raises(ub.InputError, match="parts: found .*; allowed: a list"):
        ub.merge(str(merged.path), tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_an_interpreter_that_is_killed_leaves_a_set_to_resume(tmp_path: Path) -> None:
    """Tests that a process that is killed in the middle leaves a set that is refused and can be finished."""
    out = tmp_path / "set"
    program = (
        "import sys; sys.path.insert(0, sys.argv[2]); from conftest import quick; import underbrush as ub;"
        "ub.generate(quick('leaf'), 6, sys.argv[1], seed=9, progress=False, jobs=1)"
    )
    words = [sys.executable, "-P", "-c", program, str(out), str(Path(__file__).parent)]
    process = subprocess.Popen(words)
    waited = time.monotonic() + 120
    while not list((out / "incomplete").glob("reach-*.bin")) and time.monotonic() < waited and process.poll() is None:
        time.sleep(0.02)
    assert process.poll() is None
    process.kill()
    process.wait()
    with pytest.raises(ub.InputError):
        ub.Dataset(out)
    assert len(ub.generate(quick("leaf"), 6, out, seed=9, progress=False, resume=True)) == 6
