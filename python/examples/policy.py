"""A small policy that learns to reach with less force, and the published controller as the baseline.

The policy sets waypoints for the hand, and the controller `blind`, which ignores the skin, drives it there. The six numbers of
the policy say how fast to go, and how to slow down, draw back and give way when the skin is pressed. They are found by the
cross-entropy method: candidates run side by side in one vector environment, each through the same reaches.

    python examples/policy.py              # some minutes on two cores
    python examples/policy.py --quick      # a few seconds; learns nothing that lasts
"""

# %%
import sys
from collections.abc import Callable
from typing import Any

import gymnasium
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import underbrush as ub

QUICK = "--quick" in sys.argv
CANDIDATES = 8 if QUICK else 16
ROUNDS = 2 if QUICK else 9
REACHES = 1 if QUICK else 4
LIMIT_S = 1.0 if QUICK else 12.0
# Seeds that were not trained on, and reaches of each.
TESTING = range(1, 3 if QUICK else 9)
TEST_REACHES = 1 if QUICK else 5
STEP_S = 0.04

Numbers = NDArray[np.float64]
Seen = dict[str, NDArray[np.float32]]
Policy = Callable[[Numbers, Seen], NDArray[np.float32]]

scene = ub.Scene("mixed").changed({"goals": {"count": 1, "retries": 0}}, name="policy")
# Up to 3 N, the published controller's own limit, force costs nothing. Reaching the goal must be worth pressing for: with 5 for the
# goal, and 2 for every newton above 1 N and every second, the policy learned to stop at the first leaf.
options: dict[str, Any] = {
    "scene": scene,
    "action": "waypoint",
    "time_limit_s": LIMIT_S,
    "reward": {"free_force_n": 3.0, "force_per_n_s": 1.0, "reached": 20.0},
}


def act(numbers: Numbers, seen: Seen) -> NDArray[np.float32]:
    """An action for each row of numbers. F is the largest force that the skin senses, N.

    Ahead, towards the goal: exp(n0) exp(-exp(n1) F), less within exp(n2) m of the goal, minus n3 F. To the left: n4 F. Up: n5 F.
    """
    way = seen["goal_position_world"].astype(float) - seen["end_effector_position_world"]
    distance = np.linalg.norm(way, axis=1, keepdims=True)
    ahead = way / np.maximum(distance, 1e-9)
    left = np.stack([-ahead[:, 1], ahead[:, 0], np.zeros(len(ahead))], axis=1)
    images = [image.reshape(len(image), -1).max(axis=1) for name, image in seen.items() if name.startswith("sensed")]
    force = np.maximum.reduce(images)[:, np.newaxis].astype(float)
    fast, slower, near, back, aside, up = (numbers[:, [index]] for index in range(6))
    speed = np.exp(fast - np.exp(slower) * force) * np.minimum(1.0, distance / np.exp(near))
    action = ahead * (speed - back * force) + left * aside * force + np.array([0.0, 0.0, 1.0]) * up * force
    return np.asarray(np.clip(action, -1, 1), np.float32)


def towards_goal(numbers: Numbers, seen: Seen) -> NDArray[np.float32]:
    """The goal itself as the waypoint, as far as one can be set."""
    way = seen["goal_position_world"].astype(float) - seen["end_effector_position_world"]
    return np.asarray(np.clip(way * 10.0, -1, 1), np.float32)


def episodes(
    numbers: Numbers, seeds: list[int], reaches: int, controller: str = "blind", act: Policy = act
) -> dict[str, Numbers]:
    """What the first reaches of a seed give with each row of numbers: arrays (rows, reaches)."""
    env: gymnasium.vector.VectorEnv[Any, Any, Any] = gymnasium.make_vec(
        "underbrush/Reach-v0", num_envs=len(numbers), controller=controller, **options
    )
    start: Any = seeds
    seen, _ = env.reset(seed=start)
    names = ("return", "peak force", "mean force", "time", "reached")
    found = {name: np.zeros((len(numbers), reaches)) for name in names}
    rows, place, begins = np.arange(len(numbers)), np.zeros(len(numbers), int), np.zeros(len(numbers), bool)
    while (place < reaches).any():
        seen, reward, terminated, truncated, info = env.step(act(numbers, seen))
        # The step after the end of an episode only begins the next one.
        own = rows[(place < reaches) & ~begins]
        at = (own, place[own])
        found["return"][at] += reward[own]
        found["peak force"][at] = np.maximum(found["peak force"][at], info["contact_force_n"][own])
        found["mean force"][at] += info["contact_force_n"][own] * STEP_S
        found["time"][at] += STEP_S
        found["reached"][at] = info["outcome"][own] == "reached"
        begins = terminated | truncated
        place[begins] += 1
    found["mean force"] /= found["time"]
    return found


# %%
random = np.random.default_rng(0)
# At the start it goes ahead at full speed, whatever the skin senses.
START = np.array([0.0, -4.0, -3.0, 0.0, 0.0, 0.0])
mean, spread = START.copy(), np.array([0.7, 1.5, 0.5, 0.1, 0.1, 0.1])
history = []
for number in range(ROUNDS):
    candidates = mean + spread * random.standard_normal((CANDIDATES, len(mean)))
    candidates[0] = mean
    # Other reaches in every round, the same for all candidates.
    returns = episodes(candidates, [100 + number] * CANDIDATES, REACHES)["return"].mean(axis=1)
    history.append(returns)
    best = candidates[np.argsort(-returns)[: CANDIDATES // 4]]
    # Half a step towards the best, because few reaches say little.
    mean, spread = (mean + best.mean(axis=0)) / 2, np.maximum((spread + best.std(axis=0)) / 2, 0.02)
    print(f"round {number}: mean return {returns.mean():6.2f}, best {returns.max():6.2f}, numbers {mean.round(2)}", flush=True)


# %%
def interval(values: Numbers) -> tuple[float, float, float]:
    """Mean and 95 % interval by the bootstrap over seeds, whose reaches are kept together."""
    drawn = random.integers(0, len(values), (2000, len(values)))
    low, high = np.percentile(values[drawn].mean(axis=(1, 2)), [2.5, 97.5])
    return float(values.mean()), float(low), float(high)


def told(found: dict[str, Numbers]) -> str:
    """The intervals of all that was measured, as text."""
    return ", ".join("{} {:6.2f} ({:.2f} to {:.2f})".format(what, *interval(values)) for what, values in found.items())


compared: dict[str, tuple[Numbers, str, Policy]] = {
    "policy before": (START, "blind", act),
    "policy after": (mean, "blind", act),
    "blind, goal": (START, "blind", towards_goal),
    "published, goal": (START, "cody-2013", towards_goal),
}
seeds = list(TESTING)
results = {
    name: episodes(np.tile(numbers, (len(seeds), 1)), seeds, TEST_REACHES, controller, how)
    for name, (numbers, controller, how) in compared.items()
}
print(f"{len(seeds) * TEST_REACHES} reaches of {len(seeds)} seeds that were not trained on; mean (95 % interval)")
for name, found in results.items():
    print(f"{name}: {told(found)}")
for other in ("policy before", "published, goal"):
    pairs = {what: results["policy after"][what] - values for what, values in results[other].items()}
    print(f"policy after minus {other}: {told(pairs)}")

# %%
# Left: the candidates of each round, and their mean. Each round has other reaches, so what learning does is seen in the spread, and
# right: the force and the time of reaches that were not trained on.
figure, (left, *right) = plt.subplots(1, 3, figsize=(10, 3), layout="constrained", width_ratios=(2, 1, 1))
for number, returns in enumerate(history):
    left.plot(np.full(len(returns), number), returns, ".", color="tab:gray", alpha=0.5)
left.plot([returns.mean() for returns in history], "o-", color="tab:blue")
left.set(xlabel="round", ylabel="return")
for axes, what, unit in zip(right, ("mean force", "time"), ("N", "s")):
    for row, (name, found) in enumerate(results.items()):
        middle, low, high = interval(found[what])
        axes.plot([low, high], [row, row], "-", middle, row, "o", color="tab:blue")
    axes.set(xlabel=f"{what} / {unit}", xlim=(0, None))
    axes.set_yticks(range(len(results)), list(results) if axes is right[0] else [""] * len(results))
plt.show()
