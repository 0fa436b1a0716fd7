"""``underbrush/Reach-v0`` for Gymnasium: a reach through clutter, single and vectorized.

An observation is a dictionary of float32 arrays with what a robot could know: joint angles, velocities, equilibrium
angles and torques, the positions of end effector and goal, and the tactile image of each patch of skin. What a robot
could not know is only in ``info``. An episode is one reach, drawn anew from the scene. It terminates when its goals are
reached or a force exceeds the controller's stop force, and it is truncated when a goal takes longer than
``time_limit_s``.

The reward of a step is ``progress_per_m`` times the distance, m, by which the hand came closer to the goal, minus
``force_per_n_s`` times the sum over its frames of the largest force that a taxel senses above ``free_force_n``, N, times the
duration of a frame, 0.01 s, minus ``time_per_s`` times the duration of the step, s. ``reached`` is added for each goal
reached, and ``aborted`` is subtracted if the stop force is exceeded.

``render_mode="rgb_array"`` gives pictures, also for ``gymnasium.wrappers.RecordVideo``.
"""

from __future__ import annotations

import math
import operator
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from . import _core
from ._errors import refused
from ._types import SceneLike

Observation = dict[str, NDArray[np.float32]]

_INFO = ("distance_m", "sensed_force_n", "contact_force_n", "reach_index", "outcome")


def _spaces(environments: _core.Environments) -> tuple[spaces.Space[Any], spaces.Space[Any]]:
    parts: dict[str, spaces.Space[Any]] = {
        name: spaces.Box(low, high, tuple(shape), np.float32) for name, shape, _, low, high in environments.parts
    }
    return spaces.Dict(parts), spaces.Box(-1.0, 1.0, (environments.action_size,), np.float32)


class _Parts:
    """Where the parts of an observation are in a row of numbers. Computed once, to save time in every step."""

    def __init__(self, environments: _core.Environments) -> None:
        # In the order of the space, which sorts its keys.
        self._places = [
            (name, slice(first, first + math.prod(shape)), (-1, *shape))
            for name, shape, first, _, _ in sorted(environments.parts)
        ]

    def split(self, rows: NDArray[np.float32]) -> Observation:
        """Views of the parts of each row."""
        return {name: rows[:, place].reshape(shape) for name, place, shape in self._places}

    def first(self, rows: NDArray[np.float32]) -> Observation:
        """Views of the parts of the first row."""
        return {name: rows[0, place].reshape(shape[1:]) for name, place, shape in self._places}


class ReachEnv(gymnasium.Env[Any, NDArray[np.float32]]):
    """One arm in one scene.

    Parameters
    ----------
    scene : Scene, name or path
        What the arm reaches through.
    action : {"equilibrium", "waypoint"}
        What an action is. ``"equilibrium"``: the change of every joint's equilibrium angle in a step, as a share of
        ``largest_change_rad``. ``"waypoint"``: where the end effector should go next, relative to its position, as a
        share of ``largest_waypoint_m`` along each axis; the scene's controller drives it there.
    frames_per_step : int, optional
        Frames of 10 ms in a step; 4 by default.
    largest_change_rad, largest_waypoint_m : float, optional
        The change or the distance for an action of 1; each only for its own kind of action.
    goals : int, optional
        Goals of an episode; 1 by default.
    time_limit_s : float, optional
        Longest time for a goal; 20 s by default.
    reward : dict, optional
        Weights of the reward by name; see the module.
    controller : str, optional
        The controller that follows waypoints; the scene's own by default.
    render_mode : {"rgb_array"}, optional
        With it, ``render`` returns a picture.
    width, height : int, optional
        Size of pictures, 64 to 1280 pixels each; 640 x 360 by default.
    camera : Camera, optional
        Where pictures are taken from; to the right of the arm by default.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 25}

    def __init__(
        self,
        scene: SceneLike = "mixed",
        *,
        render_mode: str | None = None,
        width: int = 640,
        height: int = 360,
        camera: _core.Camera | None = None,
        **options: Any,
    ) -> None:
        self.render_mode = _render_mode(render_mode)
        self._picture = _picture(width, height, camera)
        _refuse_unused(options)
        self._environments = _core.Environments(scene, 1, **options)
        self.metadata = _metadata(self.metadata, options)
        self._parts = _Parts(self._environments)
        self.observation_space, self.action_space = _spaces(self._environments)
        self._begun, self._ended = False, True

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode: reach 0 of the seed if one is given, otherwise the next reach. The first reset without a seed draws one."""
        if seed is not None:
            # It may be one of NumPy's integers, which Gymnasium refuses.
            seed = operator.index(seed)
        elif not self._begun:
            seed = _drawn(self.np_random)
        super().reset(seed=seed)
        rows, found = self._environments.reset([seed])
        self._begun, self._ended = True, False
        return self._parts.first(rows), _info(found)

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Take a step."""
        if self._ended:
            raise gymnasium.error.ResetNeeded("the episode has ended or has not begun; call reset()")
        rows, found = self._environments.step(np.asarray(action)[np.newaxis])
        terminated, truncated = bool(found["terminated"][0]), bool(found["truncated"][0])
        self._ended = terminated or truncated
        return self._parts.first(rows), float(found["reward"][0]), terminated, truncated, _info(found)


    def render(self) -> NDArray[np.uint8] | None:  # type: ignore[override]
        """With ``render_mode="rgb_array"`` the present picture, (height, width, 3)."""
        if self.render_mode is None:
            gymnasium.logger.warn('render() needs render_mode="rgb_array"')
            return None
        picture = self._environments.render(0, *self._picture)
        if picture is None:
            raise gymnasium.error.ResetNeeded("no episode has begun; call reset()")
        return picture


def _render_mode(mode: str | None) -> str | None:
    if mode not in (None, "rgb_array"):
        raise ValueError(f'render_mode is {mode!r}; allowed: None and "rgb_array"')
    return mode


def _picture(width: int, height: int, camera: _core.Camera | None) -> tuple[int, int, _core.Camera | None]:
    if not (64 <= width <= 1280 and 64 <= height <= 1280):
        raise refused("width and height", f"{width} x {height} pixels", "64 to 1280 pixels each", "choose such a size")
    return width, height, camera


def _refuse_unused(options: dict[str, Any]) -> None:
    """Refuses a seed, and the size of an action of the other kind."""
    if options.get("seed") is not None:
        raise refused("seed", "given to the environment", "only in reset", "call reset(seed=...)")
    action = options.get("action") or "equilibrium"
    sizes = {"equilibrium": ("largest_waypoint_m", "waypoint"), "waypoint": ("largest_change_rad", "equilibrium")}
    # Another kind is refused where the environments are made.
    unused, other = sizes.get(action, ("", ""))
    if options.get(unused) is not None:
        raise refused(unused, f'given with action="{action}"', f'only for action="{other}"', "leave it out")


def _drawn(generator: np.random.Generator) -> int:
    """A seed."""
    return int(generator.integers(2**32))


def _metadata(metadata: dict[str, Any], options: dict[str, Any]) -> dict[str, Any]:
    """The metadata of an environment, with its own number of steps per second."""
    return {**metadata, "render_fps": round(100 / (options.get("frames_per_step") or 4))}


def _info(found: dict[str, Any]) -> dict[str, Any]:
    def plain(value: Any) -> Any:
        return value.item() if isinstance(value, np.generic) else value

    return {name: plain(found[name][0]) for name in _INFO}


class ReachVectorEnv(gymnasium.vector.VectorEnv[Any, NDArray[np.float32], NDArray[Any]]):
    """Many arms that are stepped together in one native call, without the interpreter's lock.

    Environment i gives the numbers that :class:`ReachEnv` gives with the seed plus i, for any number of threads. The step
    after the end of an episode begins the next one; its action is ignored.

    Parameters
    ----------
    num_envs : int
        Number of environments.
    jobs : int, optional
        Number of threads; all cores by default.
    scene, **options
        As for :class:`ReachEnv`.
    """

    metadata: dict[str, Any] = {
        "render_modes": ["rgb_array"],
        "render_fps": 25,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        num_envs: int = 1,
        scene: SceneLike = "mixed",
        *,
        render_mode: str | None = None,
        width: int = 640,
        height: int = 360,
        camera: _core.Camera | None = None,
        **options: Any,
    ) -> None:
        self.render_mode = _render_mode(render_mode)
        self._picture = _picture(width, height, camera)
        self.num_envs = num_envs
        _refuse_unused(options)
        self._environments = _core.Environments(scene, num_envs, **options)
        self.metadata = _metadata(self.metadata, options)
        self._begun = np.zeros(num_envs, bool)
        self._parts = _Parts(self._environments)
        self.single_observation_space, self.single_action_space = _spaces(self._environments)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode in every environment, or in those that ``options["reset_mask"]`` selects. The first reset without a
        seed draws one."""
        seeds: list[int | None]
        if isinstance(seed, (int, np.integer)):
            seeds = [int(seed) + index for index in range(self.num_envs)]
        else:
            given = [None] * self.num_envs if seed is None else seed
            seeds = [None if own is None else operator.index(own) for own in given]
            # Those that have never begun need a seed.
            missing = [index for index in np.flatnonzero(~self._begun) if index < len(seeds) and seeds[index] is None]
            first = _drawn(self.np_random) if missing else 0
            for index in missing:
                seeds[index] = first + int(index)
        super().reset(seed=seeds[0] if seeds else None)
        mask = (options or {}).get("reset_mask")
        chosen = np.ones(self.num_envs, bool) if mask is None else np.asarray(mask, bool)
        rows, found = self._environments.reset(seeds, None if mask is None else chosen.tolist())
        self._begun |= chosen
        return self._parts.split(rows), self._info(found, chosen)

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[Observation, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Take a step with every environment."""
        if not self._begun.all():
            raise gymnasium.error.ResetNeeded("no episode has begun in some environment; call reset()")
        rows, found = self._environments.step(actions)
        known = np.ones(self.num_envs, bool)
        return self._parts.split(rows), found["reward"], found["terminated"], found["truncated"], self._info(found, known)

    def render(self) -> tuple[NDArray[np.uint8] | None, ...] | None:
        """With ``render_mode="rgb_array"`` the present picture of each environment, (height, width, 3)."""
        if self.render_mode is None:
            return None
        return tuple(self._environments.render(index, *self._picture) for index in range(self.num_envs))

    def _info(self, found: dict[str, Any], known: NDArray[np.bool_]) -> dict[str, Any]:
        info: dict[str, Any] = {}
        for name in _INFO:
            info[name] = np.asarray(found[name], dtype=object if name == "outcome" else None)
            info[f"_{name}"] = known.copy()
        return info
