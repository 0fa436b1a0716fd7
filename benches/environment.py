"""Steps per second of the Gymnasium environments, compared with the same loop in Rust.

Both take the same actions through the same clutter. They run alternately, and the best of several runs counts, because
other work on the machine can only slow a run down.

    python benches/environment.py [--runs N] [--steps N]
"""

from __future__ import annotations

import argparse
import time

import gymnasium
import numpy as np
import underbrush  # registers the environments
from numpy.typing import NDArray
from underbrush import _core

SCENE = "mixed"


def single(actions: NDArray[np.float32]) -> tuple[float, float]:
    """Wall time for stepping one environment, s, and processor time including making and resetting it, s."""
    used = time.process_time()
    env = gymnasium.make("underbrush/Reach-v0", scene=SCENE, disable_env_checker=True).unwrapped
    env.reset(seed=0)
    start = time.perf_counter()
    for row in actions[:, 0]:
        _, _, terminated, truncated, _ = env.step(row)
        if terminated or truncated:
            env.reset()
    return time.perf_counter() - start, time.process_time() - used


def vector(actions: NDArray[np.float32]) -> tuple[float, float]:
    """As `single`, but for a vector environment."""
    used = time.process_time()
    env = gymnasium.make_vec("underbrush/Reach-v0", num_envs=actions.shape[1], scene=SCENE)
    env.reset(seed=0)
    start = time.perf_counter()
    for row in actions:
        env.step(row)
    return time.perf_counter() - start, time.process_time() - used


def rust(actions: NDArray[np.float32]) -> tuple[float, float]:
    """As `vector`, but for the loop in Rust."""
    used = time.process_time()
    environments = _core.Environments(SCENE, actions.shape[1])
    environments.reset()
    return environments.seconds_of_steps(actions), time.process_time() - used


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--steps", type=int, default=200)
    given = parser.parse_args()
    random = np.random.default_rng(0)
    for name, count, own in (("single", 1, single), ("vector", 1, vector), ("vector", 4, vector), ("vector", 16, vector)):
        actions = random.uniform(-1, 1, (given.steps, count, 7)).astype(np.float32)
        pairs = [(rust(actions), own(actions)) for _ in range(given.runs)]
        best = [min(wall for wall, _ in column) for column in zip(*pairs, strict=True)]
        cpu = [min(used for _, used in column) for column in zip(*pairs, strict=True)]
        rates = [given.steps * count / seconds for seconds in best]
        print(
            f"{name} {count:2}: Rust {rates[0]:6.0f} steps/s, Python {rates[1]:6.0f}, ratio {rates[1] / rates[0]:.3f}; "
            f"processor time {1e6 * cpu[0] / (given.steps * count):.0f} and {1e6 * cpu[1] / (given.steps * count):.0f} us a step"
        )


if __name__ == "__main__":
    main()
