"""The sweep in both engines: this project's runs as a separate program, MuJoCo's through its Python package."""

import json
import math
import subprocess
import time

import mujoco
import numpy as np

from mujoco_model import Builder

# With the impedance d, a MuJoCo contact adds the inertia d/(1 − d) times its effective mass. None would be best, but
# the explicit integrators need some. At 0.5, errors are half as large as at the default of 0.9.
IMPEDANCE = 0.5

# Unstable settings are part of the comparison; without this, MuJoCo would write their warnings to a file.
mujoco.set_mju_user_warning(lambda message: None)


def ours(*words):
    command = ["cargo", "run", "--release", "--quiet", "--example", "foliage_peer", "--", *map(str, words)]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)


def our_run(leaves, layout, step_s, dormancy):
    return ours("run", leaves, layout, step_s, str(dormancy).lower())


class Peer:
    """One MuJoCo model of the sweep with its settings."""

    def __init__(self, setup, step_s, options, flags):
        self.setup = setup
        flags = {"sleep": "enable", **flags}
        builder = Builder(setup, {"timestep": step_s, **options}, flags, IMPEDANCE, flags["sleep"] == "enable")
        self.model = mujoco.MjModel.from_xml_string(builder.xml())
        self.steps = round(setup["frame_period_s"] / step_s)
        self.controls = np.array(setup["equilibrium_rad"])
        self.link_of_body = np.full(self.model.nbody, -1)
        for link, body in enumerate(setup["arm"]["bodies"]):
            self.link_of_body[self.model.body(f"body{body}").id] = link

    def start(self):
        data = mujoco.MjData(self.model)
        for actuator, angle in enumerate(self.setup["arm"]["start_rad"]):
            data.qpos[self.model.jnt_qposadr[self.model.actuator_trnid[actuator, 0]]] = angle
        return data

    def joint_angle_rad(self, data):
        joints = self.model.actuator_trnid[:, 0]
        return data.qpos[self.model.jnt_qposadr[joints]]

    def processor_time_s(self):
        """Of a whole sweep, s; infinite if it is so unstable that MuJoCo gives up."""
        data = self.start()
        start = time.process_time()
        try:
            for control in self.controls:
                data.ctrl[:] = control
                mujoco.mj_step(self.model, data, self.steps)
        except mujoco.FatalError:
            return math.inf
        return time.process_time() - start

    def forces(self, data=None, frames=slice(None)):
        """Mean force of each frame on each link, N, world frame, frames × links × 3; NaN if the run is unstable.
        `data` is the state to continue from; the run begins at the start if it is left out."""
        data = data or self.start()
        controls = self.controls[frames]
        forces = np.zeros((len(controls), len(self.setup["arm"]["links"]), 3))
        wrench = np.zeros(6)
        for frame, control in enumerate(controls):
            data.ctrl[:] = control
            for _ in range(self.steps):
                try:
                    mujoco.mj_step(self.model, data)
                except mujoco.FatalError:
                    # An unstable run may throw the leaves into each other, until the contacts outgrow MuJoCo's memory.
                    return np.full_like(forces, np.nan)
                for number in range(data.ncon):
                    contact = data.contact[number]
                    first, second = self.link_of_body[self.model.geom_bodyid[contact.geom]]
                    if first < 0 and second < 0:
                        continue
                    mujoco.mj_contactForce(self.model, data, number, wrench)
                    force = contact.frame.reshape(3, 3).T @ wrench[:3] / self.steps
                    if second >= 0:
                        forces[frame, second] += force
                    if first >= 0:
                        forces[frame, first] -= force
        if data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number or not np.isfinite(forces).all():
            forces[:] = np.nan
        return forces

    def copy_of(self, data):
        """A copy of the state of a run of the same model with other settings, to continue with this model's
        settings."""
        copy = mujoco.MjData(self.model)
        mujoco.mj_copyData(copy, self.model, data)
        return copy


def restarted(reference, others, window):
    """The forces of a run with `reference`, and, for each of `others`, the forces of copies of that run that continue
    with its settings. The copies begin anew every `window` frames."""
    data = reference.start()
    own, found = [], [[] for _ in others]
    for first in range(0, len(reference.controls), window):
        frames = slice(first, first + window)
        for peer, forces in zip(others, found):
            forces.append(peer.forces(peer.copy_of(data), frames))
        own.append(reference.forces(data, frames))
    return np.concatenate(own), [np.concatenate(forces) for forces in found]
