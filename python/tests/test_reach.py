"""Reaches and controllers."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from conftest import quick

import underbrush as ub


def same(first: ub.Reach, second: ub.Reach) -> bool:
    """Whether two reaches have the same frames, ground truth and audit, bit for bit."""
    frames = [reach.frames.to_polars() for reach in (first, second)]
    truth = [(reach.goals, reach.objects, reach.contacts, reach.audit) for reach in (first, second)]
    return frames[0].equals(frames[1]) and truth[0] == truth[1]


def test_a_reach_knows_its_force_limit() -> None:
    """Tests that a reach that was simulated here, also after pickling, is drawn with the force limit of its scene."""
    reach = ub.reach(quick("trunk").changed({"robot": {"force_limit_scale": 2.0}}))
    assert reach._limit_n == pickle.loads(pickle.dumps(reach))._limit_n == 6.0


def test_the_shipped_controller_called_from_python_moves_the_same() -> None:
    """Tests that a reach with the shipped controller called through Python is the same, bit for bit, as with the controller
    itself, also in a scene with factors on its speed and its force limit."""
    for name, factors in (("cody-2013", {}), ("ijrr-foliage", {"hand_speed_scale": 1.5, "force_limit_scale": 0.5})):
        # The rules that end a reach come from the scene's controller, so both reaches name it in the scene.
        own = quick("mixed").changed({"controller": name, "robot": factors})

        def made(arm: ub.Arm, name: str = name, scene: ub.Scene = own) -> ub.ShippedController:
            return ub.ShippedController(arm, name, scene=scene)

        class Twin:
            def __init__(self, arm: ub.Arm) -> None:
                self.own = made(arm)
                self.rate_hz = self.own.rate_hz

            def __call__(self, given: ub.ControllerInput) -> np.ndarray:
                assert given.end_effector_jacobian.shape == (3, 7)
                assert given.contact_jacobian.shape == (len(given.contact_force_n), 3, 7)
                return self.own(given)

        assert same(ub.reach(own, seed=3), ub.reach(own, seed=3, controller=Twin))


def test_the_mapped_controller_called_from_python_moves_the_same() -> None:
    """Tests that a reach with the mapped controller called through Python, with its scene and its intents, moves as with the
    controller itself, up to a goal that it gives up."""
    scene = quick("trunk").changed({"controller": "mapped"})

    class Twin:
        def __init__(self, arm: ub.Arm) -> None:
            self.own = ub.ShippedController(arm, "mapped", scene=scene)

        def __call__(self, given: ub.ControllerInput) -> tuple[np.ndarray, str]:
            return self.own(given), self.own.intent

    shipped, called = ub.reach(scene, seed=3), ub.reach(scene, seed=3, controller=Twin)
    assert np.array_equal(shipped.joint_angle_rad, called.joint_angle_rad)
    assert shipped.outcome == called.outcome


def test_a_controller_that_tells_its_intent_has_a_type() -> None:
    """Tests that the types of the package allow a controller that answers with its angles and a text."""
    mypy = pytest.importorskip("mypy.api")
    code = """import numpy as np, underbrush as ub
def control(given: ub.ControllerInput) -> tuple[np.ndarray, str]:
    return given.equilibrium_angle_rad, "turning round"
ub.reach("leaf", controller=control)"""
    assert mypy.run(["-c", code])[2] == 0


def test_an_own_controller_moves_the_hand() -> None:
    """Tests that a controller in ten lines of NumPy reaches a goal in free space, and that its name is recorded."""
    scene = ub.Scene.parse('summary = "Free space"\ngoals = { count = 1, x_m = 0.6, y_m = 0.0, z_m = -0.2 }\n', "free.toml")

    def straight(given: ub.ControllerInput) -> np.ndarray:
        error = given.goal_position_world - given.end_effector_pose_world[:3]
        step = error * min(1.0, 0.02 / max(float(np.linalg.norm(error)), 1e-9))
        jacobian = given.end_effector_jacobian
        return given.equilibrium_angle_rad + jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-3 * np.eye(3), step)

    found = ub.reach(scene, controller=straight)
    assert (found.outcome, found.controller) == ("reached", "straight")
    assert found.equilibrium_angle_rad.shape == (len(found), 7)


def test_a_controller_that_raises_ends_the_reach() -> None:
    """Tests that an exception of a controller reaches the caller with its traceback, and that bad answers and bad
    controllers are refused with what was found or what is allowed."""

    def broken(_: ub.ControllerInput) -> np.ndarray:
        raise KeyError("no such key")

    with pytest.raises(KeyError, match="no such key") as error:
        ub.reach("leaf", controller=broken)
    assert any(entry.name == "broken" for entry in error.traceback)
    answers = {"shape (6)": np.zeros(6), "NaN": np.full(7, np.nan), "NoneType": None}
    for found, answer in answers.items():
        with pytest.raises(ub.InputError) as refused:
            ub.reach("leaf", controller=lambda _, answer=answer: answer)
        assert found in str(refused.value)
    with pytest.raises(ub.InputError, match="cody-2013"):
        ub.reach("leaf", controller="no-such")
    with pytest.raises(ub.InputError, match="ControllerInput"):
        ub.reach("leaf", controller=3)  # type: ignore[arg-type]
    for rate_hz in (0, -25.0, 101, "fast"):

        class Rated:
            def __init__(self, rate_hz: object = rate_hz) -> None:
                self.rate_hz = rate_hz

            def __call__(self, given: ub.ControllerInput) -> np.ndarray:
                return given.equilibrium_angle_rad

        with pytest.raises(ub.InputError, match="a number above 0 and up to 100 Hz"):
            ub.reach("leaf", controller=Rated())


def test_a_class_is_called_for_every_reach(tmp_path: Path) -> None:
    """Tests that every reach of a data set has a controller of its own that is made with the arm, that the set records
    its name, and that the set is the same for any number of threads."""

    class Counter:
        name = "still"
        made: list[str] = []

        def __init__(self, arm: ub.Arm) -> None:
            self.calls = 0
            self.made.append(arm.name)

        def __call__(self, given: ub.ControllerInput) -> np.ndarray:
            self.calls += 1
            # Depends on how often this controller was called.
            return given.equilibrium_angle_rad + 1e-3 * np.sin(self.calls)

    scene = ub.Scene("leaf").changed({"goals": {"count": 1, "retries": 0, "patience_s": 0.5}}, name="still")
    sets = [ub.generate(scene, 3, tmp_path / str(jobs), controller=Counter, progress=False, jobs=jobs) for jobs in (1, 2)]
    assert len(Counter.made) >= 6 and set(Counter.made) == {"cody"}
    for column in ("action", "observation.state", "observation.tactile.forearm"):
        assert np.array_equal(sets[0].column(column), sets[1].column(column))
    assert [reach.controller for reach in sets[0]] == ["still"] * 3
    assert sets[0].provenance["controller"] == "still"
    with pytest.raises(ub.InputError, match="name of its own"):
        Counter.name = "cody-2013"
        ub.generate(scene, 1, tmp_path / "named", controller=Counter, progress=False)
    with pytest.raises(ub.InputError, match="name of its own"):
        ub.reach(scene, controller=Counter)


def test_reaches_are_saved_and_pickled(tmp_path: Path) -> None:
    """Tests that a reach that is written and read, or pickled, is the same in every column and in its ground truth."""
    reach = ub.reach(quick("mixed"), seed=1)
    reach.save(tmp_path / "reach.parquet")
    for other in (ub.Reach.load(tmp_path / "reach.parquet"), pickle.loads(pickle.dumps(reach))):
        assert other.frames.to_polars().equals(reach.frames.to_polars())
        assert (other.goals, other.objects, other.contacts) == (reach.goals, reach.objects, reach.contacts)
    assert reach.seed_and_index == (1, 0)
    frame = reach.frame(-1)
    assert frame.time_s == reach.time_s[-1]
    assert np.array_equal(frame.sensed_force_n("forearm").astype(np.float32), reach.sensed_force_n("forearm")[-1])
    with pytest.raises(IndexError):
        reach.frame(len(reach))


def test_a_reach_is_saved_under_a_name_that_commands_read(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that a reach is not saved under a name that no command takes for a reach."""
    for name in ("reach.txt", "reach"):
        with pytest.raises(ub.InputError, match="a name that ends in .parquet"):
            data[0].save(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_reach_equals_that_of_the_command_line(tmp_path: Path, command) -> None:
    """Tests that a reach from Python is the same file as one from the command line."""
    command("reach", _scene_file(tmp_path), "--seed", 5, "--out", tmp_path / "cli.parquet")
    ub.reach(tmp_path / "leaf-quick.toml", seed=5).save(tmp_path / "python.parquet")
    assert (tmp_path / "cli.parquet").read_bytes() == (tmp_path / "python.parquet").read_bytes()


def _scene_file(folder: Path) -> Path:
    path = folder / "leaf-quick.toml"
    path.write_text(quick("leaf").text)
    return path


def test_verdicts_reach_a_controller_in_python(data: ub.Dataset, tmp_path: Path, command) -> None:
    """Tests that a touch model works with a controller in Python: the shipped controller called from Python moves as the
    controller itself, whose file is that of the command line, and sees the forces that verdicts allow."""
    touch, scene = tmp_path / "touch.json", quick("mixed")
    ub.TouchModel.fit(list(data)).save(touch)
    allowed_n: list[float] = []

    class Twin:
        def __init__(self, arm: ub.Arm) -> None:
            self.own = ub.ShippedController(arm)

        def __call__(self, given: ub.ControllerInput) -> np.ndarray:
            assert given.contact_position_world.shape == given.contact_normal_world.shape
            assert given.contact_link.shape == given.contact_verdict_probability.shape == given.contact_force_n.shape
            assert len(given.contact_verdict) == len(given.contact_force_n)
            assert given.contact_allowed_force_n.shape == given.contact_force_n.shape
            allowed_n.extend(given.contact_allowed_force_n)
            return self.own(given)

    # The skin meets objects that the model knows in the reach of this seed.
    files = [tmp_path / f"{name}.parquet" for name in ("rust", "cli")]
    shipped = ub.reach(scene, seed=4, verdicts=touch)
    shipped.save(files[0])
    reach = ub.reach(scene, seed=4, controller=Twin, verdicts=touch)
    (tmp_path / "mixed-quick.toml").write_text(scene.text)
    command("reach", tmp_path / "mixed-quick.toml", "--seed", 4, "--verdicts", touch, "--out", files[1])
    assert files[0].read_bytes() == files[1].read_bytes() and same(shipped, reach)
    assert reach.controller != "Twin" and np.isfinite(allowed_n).any()
    # Without a touch model, no contact has a limit of its own.
    allowed_n.clear()
    ub.reach(scene, seed=4, controller=Twin)
    assert allowed_n and np.isnan(allowed_n).all()
