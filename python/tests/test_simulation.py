"""The simulation, step by step."""

import copy
import pickle
import threading

import numpy as np
import pytest

import underbrush as ub

STEP = 0.002


def angles(simulation: ub.Simulation, step: int) -> np.ndarray:
    start = simulation.arm.start_posture_rad
    return start + 0.2 * np.sin(STEP * step * (1 + np.arange(len(start))))


def state(frame: ub.Frame) -> tuple[bytes, bytes, bytes]:
    return frame.joint_angle_rad.tobytes(), frame.sensed_force_n().tobytes(), frame.contact_force_world().tobytes()


def test_a_saved_state_continues_bit_for_bit() -> None:
    """Tests that a restored simulation, and a copy, continue with the same bits."""
    first = ub.Simulation("mixed", seed=1)
    for step in range(40):
        first.step(angles(first, step))
    saved, copies = first.save(), [first.copy(), copy.copy(first), copy.deepcopy(first)]
    expected = [state(first.step(angles(first, step))) for step in range(40, 60)]
    for copied in copies:
        assert [state(copied.step(angles(copied, step))) for step in range(40, 60)] == expected
    other = ub.Simulation("mixed", seed=1)
    other.restore(saved)
    assert np.array_equal(other.frame_now.equilibrium_angle_rad, angles(first, 39))
    assert [state(other.step(angles(other, step))) for step in range(40, 60)] == expected
    with pytest.raises(ub.InputError, match="another arm, clutter"):
        ub.Simulation("mixed", seed=2).restore(saved)
    with pytest.raises(ub.InputError, match="not a saved state"):
        other.restore(b"nothing")


def test_many_at_once_equal_one_by_one() -> None:
    """Tests that simulations stepped together, with one thread and with two, give the same bits as each one alone."""
    alone = [ub.Simulation("leaf", seed=seed) for seed in range(3)]
    expected = [[state(own.step(angles(own, step))) for own in alone] for step in range(25)]
    for jobs in (None, 1, 2):
        together = [ub.Simulation("leaf", seed=seed) for seed in range(3)]
        for step in range(25):
            rows = np.array([angles(own, step) for own in together])
            assert [state(frame) for frame in ub.step_many(together, rows, jobs=jobs)] == expected[step]
    with pytest.raises(ub.InputError, match="twice"):
        ub.step_many([alone[0], alone[0]], np.zeros((2, 7)))
    assert ub.step_many([], np.zeros((0, 7))) == []


@pytest.mark.parametrize(
    ("value", "found"),
    [
        (np.zeros(6), r"shape \(6\)"),
        (np.zeros((1, 7)), r"shape \(1, 7\)"),
        (np.full(7, np.nan), "NaN"),
        (np.full(7, np.inf), "inf"),
        (np.array(["a"] * 7), "array of <U1"),
        (np.zeros(7, complex), "array of complex128"),
        ("angles", "type"),
        (None, "type"),
    ],
)
def test_bad_angles_are_refused(value: object, found: str) -> None:
    """Tests that angles of a wrong shape or type, NaN and infinity are refused with what was expected, and that nothing
    moves."""
    simulation = ub.Simulation("leaf", seed=1)
    with pytest.raises(ub.InputError, match=found) as error:
        simulation.step(value)  # type: ignore[arg-type]
    assert error.value.field == "equilibrium_rad" and error.value.allowed
    assert simulation.frame_now.time_s == 0


def test_any_array_of_numbers_will_do() -> None:
    """Tests that lists, and arrays that are not contiguous, read-only, of another number type or in another byte order,
    all give the same step."""
    wanted = np.round(ub.Arm.cody().start_posture_rad, 1).astype(np.float32).astype(np.float64)
    spread = np.zeros((7, 3))
    spread[:, 1] = wanted
    backwards = wanted[::-1].copy()[::-1]
    read_only = wanted.copy()
    read_only.setflags(write=False)
    given = [wanted, spread[:, 1], backwards, wanted.astype(np.float32), wanted.astype(">f8"), wanted.tolist(), read_only]
    found = {state(ub.Simulation("leaf", seed=1).step(own)) for own in given}
    assert len(found) == 1


def test_two_threads_cannot_step_one_simulation() -> None:
    """Tests that a simulation refuses to step while another thread is stepping it, and that it can continue
    afterwards."""
    simulation = ub.Simulation("mixed", seed=1)
    refused, stepped = [], []
    start = threading.Barrier(4)

    def work() -> None:
        start.wait()
        # However the machine schedules them, two threads will be in the same step at some time.
        while not refused and len(stepped) < 20_000:
            try:
                simulation.step(simulation.arm.start_posture_rad)
                stepped.append(1)
            except ub.RunError as error:
                refused.append(str(error))

    threads = [threading.Thread(target=work) for _ in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert refused and all("another thread" in text for text in refused)
    # Each step that was not refused has advanced the time by one frame.
    assert simulation.frame_now.time_s == pytest.approx(0.01 * len(stepped))
    assert simulation.step(simulation.arm.start_posture_rad).time_s == pytest.approx(0.01 * (len(stepped) + 1))


def test_the_jacobian_is_that_of_the_end_effector() -> None:
    """Tests the Jacobian of an arm against central differences of the position, within their error."""
    arm = ub.Arm.cody()
    angles = arm.start_posture_rad + 0.1
    _, jacobian = arm.end_effector(angles)
    step = 1e-6
    for joint in range(len(angles)):
        moved = np.eye(len(angles))[joint] * step
        difference = (arm.end_effector(angles + moved)[0] - arm.end_effector(angles - moved)[0]) / (2 * step)
        assert np.allclose(difference, jacobian[:, joint], atol=1e-8)


def test_an_arm_is_pickled_with_its_springs() -> None:
    """Tests that a pickled arm of a scene with stiffer joints is the same arm, bit for bit, also for its controller."""
    scene = ub.Scene("leaf").changed({"robot": {"stiffness_scale": 1.7}})
    arm = ub.Simulation(scene, seed=1).arm
    again = pickle.loads(pickle.dumps(arm))
    assert again.files == arm.files and again.skin == arm.skin and again.joints == arm.joints
    assert np.array_equal(again.stiffness_nm_per_rad, arm.stiffness_nm_per_rad)
    assert not np.array_equal(again.stiffness_nm_per_rad, ub.Arm.cody().stiffness_nm_per_rad)
    both = [ub.ShippedController(own) for own in (arm, again)]
    same = []

    def controller(given: ub.ControllerInput) -> np.ndarray:
        answers = [own(given) for own in both]
        same.append(np.array_equal(*answers))
        return answers[0]

    ub.reach(scene.changed({"goals": {"count": 1, "retries": 0, "patience_s": 1.0}}), seed=1, controller=controller)
    assert same and all(same)


def test_pictures_have_the_things_that_are_there() -> None:
    """Tests that the kinds of pictures have their shapes and types, that a link is as far away as it is, that labels name it,
    and that a picture changes with the arm and with the camera."""
    simulation = ub.Simulation("trunk", seed=1)
    rgb = simulation.render(320, 240)
    assert rgb.shape == (240, 320, 3) and rgb.dtype == np.uint8 and rgb.flags.writeable
    tip = simulation.frame_now.end_effector_pose_world[:3]
    camera = ub.Camera(tip + [0, -0.8, 0], tip)
    camera = pickle.loads(pickle.dumps(camera))
    depth = simulation.render(320, 240, camera=camera, kind="depth")
    labels = simulation.render(320, 240, camera=camera, kind="segmentation")
    assert depth.shape == labels.shape == (240, 320)
    assert depth.dtype == np.float32 and labels.dtype == np.uint16
    assert simulation.labels[labels[120, 160]].startswith("link ")
    # The end effector is in the hand, which is not 15 cm thick.
    assert 0.65 < depth[120, 160] < 0.8
    assert np.all(np.isinf(depth) == (labels == 0))
    assert labels.max() < len(simulation.labels)
    for _ in range(30):
        simulation.step(simulation.arm.start_posture_rad + 0.2)
    assert not np.array_equal(simulation.render(320, 240), rgb)
    for arguments, said in [
        ({"kind": "colour"}, "segmentation"),
        ({"width": 10}, "64 to 1280"),
        ({"camera": ub.Camera(tip, tip)}, "another direction"),
    ]:
        with pytest.raises(ub.InputError, match=said):
            simulation.render(**arguments)
