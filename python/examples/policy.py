"""A small policy that learns to reach with less force, and the published controller as the baseline.

The policy sets waypoints for the hand, and the controller `blind`, which ignores the skin, drives it there. The five numbers of
the policy say how fast to go, and how to slow down, draw back and go round when the skin is pressed. They are found by the
cross-entropy method: candidates run side by side in one vector environment, through the same clutter.

    python examples/policy.py              # minutes on two cores
    python examples/policy.py --quick      # a few seconds; learns nothing that lasts
"""

# %%
import sys
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

import underbrush as ub

QUICK = "--quick" in sys.argv
COUNT = 8 if QUICK else 16
ROUNDS = 2 if QUICK else 8
LIMIT_S = 1.0 if QUICK else 12.0
TRAINING = range(100, 101 if QUICK else 103)
TESTING = range(1, 2 if QUICK else 9)
Numbers = NDArray[np.float64]
Policy = Callable[[Numbers, dict[str, NDArray[np.float32]]], NDArray[np.float32]]

scene = ub.Scene("mixed").changed({"goals": {"count": 1, "retries": 0}}, name="policy")
options: dict[str, Any] = {
    "scene": scene,
    "action": "waypoint",
    "time_limit_s": LIMIT_S,
    "reward": {"free_force_n": 1.0, "force_per_n_s": 2.0},
}


def act(numbers: Numbers, seen: dict[str, NDArray[np.float32]]) -> NDArray[np.float32]:
    """An action for each row of numbers: fast, slower with force, back with force, sideways with force, near the goal."""
    way = seen["goal_position_world"].astype(float) - seen["end_effector_position_world"]
    distance = np.linalg.norm(way, axis=1, keepdims=True)
    ahead = way / np.maximum(distance, 1e-9)
    aside = np.stack([-ahead[:, 1], ahead[:, 0], np.zeros(len(ahead))], axis=1)
    images = [image.reshape(len(image), -1).max(axis=1) for name, image in seen.items() if name.startswith("sensed")]
    force = np.maximum.reduce(images)[:, np.newaxis].astype(float)
    fast, slower, back, sideways, near = (numbers[:, [index]] for index in range(5))
    speed = np.exp(fast) * np.exp(-np.exp(slower) * force) * np.minimum(1.0, distance / np.exp(near))
    action = ahead * (speed - back * force) + aside * sideways * force
    return np.asarray(np.clip(action, -1, 1), np.float32)


def episodes(
    numbers: Numbers, seed: int, controller: str = "blind", act: Policy = act
) -> tuple[Numbers, Numbers, NDArray[np.bool_]]:
    """Return, largest contact force and success of one episode for each row of numbers, all through the same clutter."""
    env: gymnasium.vector.VectorEnv[Any, Any, Any] = gymnasium.make_vec(
        "underbrush/Reach-v0", num_envs=len(numbers), controller=controller, **options
    )
    seeds: Any = [seed] * len(numbers)
    seen, _ = env.reset(seed=seeds)
    total, force_n, done = np.zeros(len(numbers)), np.zeros(len(numbers)), np.zeros(len(numbers), bool)
    reached = done.copy()
    while not done.all():
        seen, reward, terminated, truncated, info = env.step(act(numbers, seen))
        total += np.where(done, 0.0, reward)
        force_n = np.where(done, force_n, np.maximum(force_n, info["contact_force_n"]))
        reached |= ~done & (info["outcome"] == "reached")
        done |= terminated | truncated
    return total, force_n, reached


# %%
random = np.random.default_rng(0)
START = np.array([0.0, -2.0, 0.0, 0.0, -2.0])
mean, spread = START.copy(), np.array([0.7, 1.0, 0.3, 0.3, 0.5])
for number in range(ROUNDS):
    candidates = mean + spread * random.standard_normal((COUNT, len(mean)))
    candidates[0] = mean
    returns = np.mean([episodes(candidates, seed)[0] for seed in TRAINING], axis=0)
    best = candidates[np.argsort(-returns)[: COUNT // 4]]
    mean, spread = best.mean(axis=0), best.std(axis=0) + 0.05
    print(f"round {number}: mean return {returns.mean():.2f}, best {returns.max():.2f}")


# %%
def towards_goal(numbers: Numbers, seen: dict[str, NDArray[np.float32]]) -> NDArray[np.float32]:
    """The goal itself as the waypoint, as far as one can be set."""
    way = seen["goal_position_world"].astype(float) - seen["end_effector_position_world"]
    return np.asarray(np.clip(way * 10.0, -1, 1), np.float32)


rows: dict[str, tuple[Numbers, str, Policy]] = {
    "policy before": (START, "blind", act),
    "policy after": (mean, "blind", act),
    "blind controller": (START, "blind", towards_goal),
    "published controller": (START, "cody-2013", towards_goal),
}
print("on clutter that was not trained on:")
for name, (numbers, controller, how) in rows.items():
    found = [episodes(numbers[np.newaxis], seed, controller, how) for seed in TESTING]
    total, force_n, reached = (np.array([own[index][0] for own in found]) for index in range(3))
    print(f"{name:21} return {total.mean():6.2f}, peak force {force_n.mean():5.2f} N, reached {reached.sum()} of {len(found)}")
