"""The same pushes on one leaf and on the arm in both engines, which show that the two models are the same."""

import sys

import mujoco
import numpy as np

from engines import Peer, ours

# Largest relative difference allowed. Leaves and arms of both engines are equal up to the integrators' errors at this
# step.
TOLERANCE = 0.01


def compare_statics():
    """Prints the table; ends the program if the models differ."""
    expected = ours("statics")
    setup = ours("setup", 1, 0)
    peer = Peer(setup, expected["step_s"], {"integrator": "implicitfast"}, {"sleep": "disable"})
    model = peer.model
    data = peer.start()
    data.ctrl[:] = setup["arm"]["start_rad"]
    body = model.body(f"body{expected['tip_body']}").id
    offset = np.array(expected["tip_of_body_m"])

    def tip():
        return data.xpos[body] + data.xmat[body].reshape(3, 3) @ offset

    def push(which, force, point, seconds):
        track = []
        for _ in range(round(seconds / model.opt.timestep)):
            data.qfrc_applied[:] = 0
            place = data.xpos[which] + data.xmat[which].reshape(3, 3) @ point
            mujoco.mj_applyFT(model, data, np.array(force), np.zeros(3), place, which, data.qfrc_applied)
            mujoco.mj_step(model, data)
            mujoco.mj_kinematics(model, data)
            track.append(tip())
        return np.array(track)

    mujoco.mj_forward(model, data)
    straight = tip()
    rows = []
    for name, given in zip(("leaf's tip, 0.05 N across the blade", "leaf's tip, 0.05 N along the blade"),
                           expected["pushes"]):
        there = push(body, given["force_world_n"], offset, 10)[-1] - straight
        here = np.array(given["displacement_world_m"])
        rows.append((name, "mm", 1e3 * np.linalg.norm(here), 1e3 * np.linalg.norm(there),
                     np.linalg.norm(there - here) / np.linalg.norm(here)))
    across = np.array(expected["pushes"][0]["force_world_n"])
    push(body, across, offset, 10)
    swing = (push(body, np.zeros(3), offset, 2.0) - straight) @ (across / np.linalg.norm(across))
    here = frequency(np.array(expected["swing_m"]), expected["step_s"])
    there = frequency(swing, model.opt.timestep)
    rows.append(("leaf's first frequency", "Hz", here, there, abs(there / here - 1)))
    push(model.body(f"body{expected['wrist_body']}").id, expected["wrist_force_world_n"], np.zeros(3), 10)
    start = np.array(setup["arm"]["start_rad"])
    here, there = np.array(expected["joint_angle_rad"]) - start, peer.joint_angle_rad(data) - start
    rows.append(("arm's joints, 7 N at the wrist", "mrad", 1e3 * np.linalg.norm(here), 1e3 * np.linalg.norm(there),
                 np.linalg.norm(there - here) / np.linalg.norm(here)))
    print("| the same push | unit | underbrush | MuJoCo | relative difference |\n|---|---|---|---|---|")
    for name, unit, here, there, difference in rows:
        print(f"| {name} | {unit} | {here:.4f} | {there:.4f} | {difference:.1e} |")
    print(flush=True)
    if max(row[-1] for row in rows) > TOLERANCE:
        sys.exit("the two models are not the same: a comparison of their speeds would mean nothing")


def frequency(swing, step_s):
    """Frequency in Hz, from the first to the last upward zero crossing, each interpolated."""
    up = np.flatnonzero((swing[:-1] < 0) & (swing[1:] >= 0))
    crossings = (up + swing[up] / (swing[up] - swing[up + 1])) * step_s
    return (len(crossings) - 1) / (crossings[-1] - crossings[0])
