"""A controller of your own in a reach, and in a data set. It slows down where the skin is pressed."""

# %%
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import underbrush as ub


class Gentle:
    """Moves the hand straight towards the goal, more slowly the harder the skin is pressed. Made anew for every reach."""

    name = "gentle"
    rate_hz = 25.0

    def __init__(self, arm: ub.Arm) -> None:
        self.limits_rad = arm.limits_rad

    def __call__(self, given: ub.ControllerInput) -> NDArray[np.float64]:
        way = given.goal_position_world - given.end_effector_pose_world[:3]
        force_n = max(given.contact_force_n, default=0.0)
        step = way * min(1.0, 0.02 / max(float(np.linalg.norm(way)), 1e-9)) * max(0.0, 1.0 - force_n / 5.0)
        jacobian = given.end_effector_jacobian
        change = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-3 * np.eye(3), step)
        return np.clip(given.equilibrium_angle_rad + change, *self.limits_rad.T)


scene = ub.Scene("leaf").changed({"goals": {"count": 1, "retries": 0}}, name="one-goal")
for controller in ("cody-2013", "blind", Gentle):
    reach = ub.reach(scene, seed=1, controller=controller)
    force_n = max((contact["peak_force_n"] for contact in reach.contacts), default=0.0)
    print(f"{reach.controller}: {reach.outcome} in {reach.time_s[-1]:.1f} s, at most {force_n:.1f} N")

# %%
# The last of these reaches.
reach.draw()

# %%
data = ub.generate(scene, reaches=2, out=Path(tempfile.mkdtemp()) / "gentle", seed=1, controller=Gentle)
assert data.provenance["controller"] == "gentle"
