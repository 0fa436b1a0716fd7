"""Gymnasium environments."""

import threading
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from conftest import quick
from gymnasium.utils.env_checker import check_env

import underbrush as ub
from underbrush import gym as ub_gym

SCENE = quick("leaf")


def actions(steps: int, count: int = 1) -> np.ndarray:
    return np.random.default_rng(5).uniform(-1, 1, (steps, count, 7)).astype(np.float32)


def same(first: dict[str, np.ndarray], second: dict[str, np.ndarray]) -> bool:
    return first.keys() == second.keys() and all(np.array_equal(first[name], second[name]) for name in first)


@pytest.mark.parametrize("action", ["equilibrium", "waypoint"])
def test_check_env(action: str) -> None:
    """Tests that the environment passes Gymnasium's own checks without a warning."""
    env = gymnasium.make("underbrush/Reach-v0", scene=SCENE, action=action, disable_env_checker=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)
    images = {name: space.shape for name, space in env.observation_space.items() if "sensed" in name}
    assert images["sensed_force_n.forearm"] == (16, 24)


def test_vector_numbers_are_single_numbers() -> None:
    """Tests that a vector environment gives the numbers of single environments with consecutive seeds, which may be NumPy's, for one
    thread and for two, and beyond the end of an episode."""
    options: dict[str, Any] = {"scene": SCENE, "time_limit_s": 0.6}
    steps = actions(40, 3)
    singles = [gymnasium.make("underbrush/Reach-v0", **options) for _ in range(3)]
    for jobs in (1, 2):
        many = gymnasium.make_vec("underbrush/Reach-v0", num_envs=3, jobs=jobs, **options)
        observations, _ = many.reset(seed=np.int64(11))
        ended = [False] * 3
        first = [env.reset(seed=11 + index)[0] for index, env in enumerate(singles)]
        for index in range(3):
            assert same({name: own[index] for name, own in observations.items()}, first[index])
        ends = 0
        for row in steps:
            observations, rewards, terminated, truncated, info = many.step(row)
            for index, env in enumerate(singles):
                if ended[index]:
                    expected, single_info = env.reset()
                    own = (0.0, False, False)
                    ends += 1
                else:
                    expected, *own, single_info = env.step(row[index])
                assert same({name: part[index] for name, part in observations.items()}, expected)
                assert (rewards[index], terminated[index], truncated[index]) == tuple(own)
                assert info["contact_force_n"][index] == single_info["contact_force_n"]
                ended[index] = bool(own[1] or own[2])
        assert ends >= 3
        many.close()


def test_truth_is_in_info_only() -> None:
    """Tests the keys of observations and of info: ground truth is not observed."""
    env = gymnasium.make("underbrush/Reach-v0", scene=SCENE)
    observation, info = env.reset(seed=1)
    assert set(observation) == {
        "joint_angle_rad",
        "joint_velocity_rad_per_s",
        "equilibrium_angle_rad",
        "joint_torque_nm",
        "end_effector_position_world",
        "goal_position_world",
        "sensed_force_n.forearm",
        "sensed_force_n.flipper",
    }
    assert set(info) == {"distance_m", "sensed_force_n", "contact_force_n", "reach_index", "outcome"}
    way = observation["goal_position_world"] - observation["end_effector_position_world"]
    assert np.linalg.norm(way) == pytest.approx(info["distance_m"], abs=1e-6)


def test_episodes_follow_the_seed() -> None:
    """Tests that a reset with a seed begins with its first reach, that a reset without one takes the next reach, and
    that episodes end at their time limit."""
    env = gymnasium.make("underbrush/Reach-v0", scene=SCENE, time_limit_s=0.2)
    first = [env.reset(seed=3)[1], env.reset()[1], env.reset()[1]]
    assert [info["reach_index"] for info in first] == [0, 1, 2]
    assert env.reset(seed=3)[1] == first[0]
    assert env.unwrapped.reset(seed=np.int64(3))[1] == first[0]  # type: ignore[arg-type]
    still = np.zeros(7, np.float32)
    results = [env.step(still) for _ in range(5)]
    assert [found[3] for found in results] == [False] * 4 + [True] and results[-1][4]["outcome"] == "timed_out"
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.unwrapped.step(still)


def test_first_resets_without_a_seed_differ() -> None:
    """Tests that a first reset without a seed draws one, which the environment tells, and that later ones continue."""
    for make in (ub_gym.ReachEnv, lambda scene: ub_gym.ReachVectorEnv(2, scene)):
        one, other = make(SCENE), make(SCENE)
        first = one.reset()[0]
        assert not same(first, other.reset()[0])
        assert same(first, other.reset(seed=one.np_random_seed)[0])
        assert same(one.reset()[0], other.reset()[0])


def test_first_resets_of_some_without_a_seed_differ() -> None:
    """Tests that environments whose seed in a list is None draw one at their first reset."""
    one, other = ub_gym.ReachVectorEnv(3, SCENE), ub_gym.ReachVectorEnv(3, SCENE)
    goals = [many.reset(seed=[1, None, 3])[0]["goal_position_world"] for many in (one, other)]
    assert (goals[0] == goals[1]).all(axis=1).tolist() == [True, False, True]


def test_the_waypoint_controller_reaches_goals() -> None:
    """Tests that waypoints towards the goal bring the hand there: the episode ends as `reached`, with the reward for
    it."""
    env = gymnasium.make("underbrush/Reach-v0", scene=_free(), action="waypoint", time_limit_s=20.0)
    observation, _ = env.reset(seed=0)
    total, ended = 0.0, False
    while not ended:
        way = observation["goal_position_world"] - observation["end_effector_position_world"]
        observation, reward, terminated, truncated, info = env.step(np.clip(way * 10, -1, 1).astype(np.float32))
        total, ended = total + reward, terminated or truncated
    assert info["outcome"] == "reached" and total > 5


def _free() -> ub.Scene:
    text = 'summary = "Free space"\ngoals = { count = 1, x_m = 0.6, y_m = 0.0, z_m = -0.2 }\n'
    return ub.Scene.parse(text, "free.toml")


def test_masked_resets() -> None:
    """Tests that a reset with a mask begins only the episodes that the mask selects."""
    many = gymnasium.make_vec("underbrush/Reach-v0", num_envs=2, scene=SCENE)
    many.reset(seed=1)
    before = many.step(actions(1, 2)[0])[0]
    after, info = many.reset(options={"reset_mask": np.array([False, True])})
    assert same({name: own[0] for name, own in before.items()}, {name: own[0] for name, own in after.items()})
    assert info["reach_index"][1] == 1
    assert info["_reach_index"].tolist() == info["_distance_m"].tolist() == [False, True]


def test_bad_use_is_refused() -> None:
    """Tests that bad options, shapes and NaN are refused with what is allowed."""
    for options, text in (
        ({"goals": 2}, "fewer goals"),
        ({"action": "torque"}, "waypoint"),
        ({"reward": {"speed": 1.0}}, "progress_per_m"),
        ({"frames_per_step": 0}, "frames_per_step"),
        ({"frames_per_step": "4"}, 'frames_per_step: found string "4"; allowed: a whole number from 0'),
        ({"reward": 1}, "reward: found integer `1`; allowed: a dictionary"),
        ({"controller": "none"}, "cody-2013"),
        ({"width": 10}, "64 to 1280 pixels"),
        ({"seed": 3}, "only in reset"),
        ({"largest_waypoint_m": 0.2}, 'largest_waypoint_m: found given with action="equilibrium"'),
        ({"action": "waypoint", "largest_change_rad": 0.1}, 'largest_change_rad: found given with action="waypoint"'),
    ):
        with pytest.raises(ub.InputError, match=text):
            gymnasium.make("underbrush/Reach-v0", scene=SCENE, **options)
    many = gymnasium.make_vec("underbrush/Reach-v0", num_envs=2, scene=SCENE)
    with pytest.raises(gymnasium.error.ResetNeeded):
        many.step(np.zeros((2, 7), np.float32))
    # Each environment must begin.
    many.reset(seed=4, options={"reset_mask": np.array([True, False])})
    with pytest.raises(gymnasium.error.ResetNeeded):
        many.step(np.zeros((2, 7), np.float32))
    many.reset(options={"reset_mask": np.array([False, True])})
    many.step(np.zeros((2, 7), np.float32))
    with pytest.raises(ub.InputError, match=r"shape \(3, 7\)"):
        many.step(np.zeros((3, 7), np.float32))
    with pytest.raises(ub.InputError, match="NaN"):
        many.step(np.full((2, 7), np.nan, np.float32))
    with pytest.raises(ub.InputError, match="seeds"):
        many.reset(seed=[1])
    with pytest.raises(ub.InputError, match="1 to 4096; remedy: change it"):
        gymnasium.make_vec("underbrush/Reach-v0", num_envs=0, scene=SCENE)


def test_pictures_of_environments() -> None:
    """Tests that an environment gives pictures until and after the end of its episode, at the rate of its steps, and that those of a
    vector environment are the same."""
    options: dict[str, Any] = {"scene": SCENE, "time_limit_s": 0.6, "width": 160, "height": 120, "render_mode": "rgb_array"}
    env = gymnasium.make("underbrush/Reach-v0", **options)
    assert env.metadata["render_fps"] == 25
    assert gymnasium.make("underbrush/Reach-v0", frames_per_step=10, **options).metadata["render_fps"] == 10
    many = gymnasium.make_vec("underbrush/Reach-v0", num_envs=2, **options)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.unwrapped.render()
    env.reset(seed=3)
    many.reset(seed=3)
    pictures = [env.render()]
    for row in actions(15, 2):
        _, _, terminated, truncated, _ = env.step(row[0])
        many.step(row)
        pictures.append(env.render())
        first, second = many.render()
        assert np.array_equal(first, pictures[-1]) and not np.array_equal(second, first)
    assert truncated or terminated
    assert all(picture.shape == (120, 160, 3) and picture.dtype == np.uint8 for picture in pictures)
    assert not np.array_equal(pictures[0], pictures[-1])
    env.reset(seed=3)
    assert np.array_equal(env.render(), pictures[0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make("underbrush/Reach-v0", disable_env_checker=True, **options).unwrapped)


def test_two_threads_cannot_use_one_environment() -> None:
    """Tests that environments that another thread is drawing are refused with the advice to wait, and can be used afterwards."""
    environments = ub._core.Environments(SCENE)
    environments.reset()
    refused, drawn = [], []
    start = threading.Barrier(4)

    def work() -> None:
        start.wait()
        # However the machine schedules them, two threads will draw at the same time at some time.
        while not refused and len(drawn) < 5_000:
            try:
                drawn.append(environments.render(0, 160, 120, None))
            except ub.RunError as error:
                refused.append(str(error))

    threads = [threading.Thread(target=work) for _ in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert refused and all("another thread" in text and "wait for it" in text for text in refused)
    assert environments.render(0, 160, 120, None) is not None


def test_record_video_writes_a_film(tmp_path: Path) -> None:
    """Tests that Gymnasium's RecordVideo writes a film of an episode."""
    pytest.importorskip("moviepy")
    env = gymnasium.make("underbrush/Reach-v0", scene=SCENE, time_limit_s=0.6, render_mode="rgb_array")
    film = gymnasium.wrappers.RecordVideo(env, str(tmp_path / "films"), episode_trigger=lambda _: True)
    film.reset(seed=3)
    for row in actions(15):
        film.step(row[0])
    film.close()
    assert [path.suffix for path in (tmp_path / "films").iterdir() if path.stat().st_size > 5000] == [".mp4"]


def test_other_render_modes_are_refused() -> None:
    """Tests that a window is refused, and that an environment without a mode gives no picture."""
    with pytest.raises(ValueError, match="rgb_array"):
        ub_gym.ReachEnv(SCENE, render_mode="human")
    env = ub_gym.ReachEnv(SCENE)
    env.reset(seed=1)
    with pytest.warns(UserWarning, match="rgb_array"):
        assert env.render() is None
