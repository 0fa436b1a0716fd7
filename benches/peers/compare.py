"""The sweep of `benches/peers/sweep.rs` here and in MuJoCo: the same statics, the force error over the step, the speed.

    pip install -r benches/peers/requirements.txt
    python benches/peers/compare.py [--leaves 24 48] [--layouts 3]

Run it from the workspace. Each engine's forces are compared with its own run at a fine step, so that speeds can be
compared at equal error; a speed is simulated seconds per second of processor time of one core, physics alone, the
quickest of several runs.
"""

import argparse
import json
import math
import os
import platform
import subprocess
import sys
import time

try:
    import mujoco
    import numpy as np
except ImportError as missing:
    sys.exit(f"{missing}: install the peers first, `pip install -r benches/peers/requirements.txt`")

from mujoco_model import Builder

# Ours: step, s, and substeps. References step 0.1 ms, without dormancy here and without sleeping there.
OUR_STEPS = [(0.01, 1), (0.01, 2), (0.01, 4), (0.01, 8), (0.005, 1), (0.005, 2), (0.005, 4), (0.0025, 1), (0.001, 1)]
OUR_REFERENCE = (0.0001, 1)

# MuJoCo's options and flags. `discrete` has implicit springs and is the quickest that holds together over 2 ms;
# `implicitfast` is the usual recommendation. Elliptic cones converge far better here than pyramidal ones. More than
# these were tried: Euler, PGS, fewer iterations, a dense Jacobian and exact constraint inertia are no better.
PEER_SETTINGS = {
    "discrete, Newton, elliptic": ({"integrator": "discrete", "solver": "Newton", "cone": "elliptic"}, {}),
    "discrete, CG to 1e-5, elliptic, one contact a pair": (
        {"integrator": "discrete", "solver": "CG", "cone": "elliptic", "tolerance": "1e-5"}, {"multiccd": "disable"}),
    "discrete, Newton, elliptic, no sleeping": (
        {"integrator": "discrete", "solver": "Newton", "cone": "elliptic"}, {"sleep": "disable"}),
    "implicitfast, Newton, elliptic": ({"integrator": "implicitfast", "solver": "Newton", "cone": "elliptic"}, {}),
    "discrete, Newton, pyramidal": ({"integrator": "discrete", "solver": "Newton", "cone": "pyramidal"}, {}),
}
PEER_STEPS = [0.01, 0.005, 0.01 / 3, 0.0025, 0.002, 0.00125, 0.001]
PEER_REFERENCE_STEP = 0.0001
# A MuJoCo contact adds the inertia d/(1 − d) of its effective mass: none would be best, but the explicit integrators
# need some. At 0.5 errors are half of those at the default 0.9.
IMPEDANCE = 0.5

# Length of the windows, frames, of which the middle error is taken.
WINDOW = 30


def ours(*words):
    command = ["cargo", "run", "--release", "--quiet", "--example", "foliage_peer", "--", *map(str, words)]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)


def our_run(leaves, layout, step_s, substeps, dormancy):
    return ours("run", leaves, layout, step_s, substeps, str(dormancy).lower())


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
        data = self.start()
        start = time.process_time()
        for control in self.controls:
            data.ctrl[:] = control
            mujoco.mj_step(self.model, data, self.steps)
        return time.process_time() - start

    def forces(self):
        """Mean force of each frame on each link, N, world frame, frames × links × 3."""
        data = self.start()
        forces = np.zeros((len(self.controls), len(self.setup["arm"]["links"]), 3))
        wrench = np.zeros(6)
        for frame, control in enumerate(self.controls):
            data.ctrl[:] = control
            for _ in range(self.steps):
                mujoco.mj_step(self.model, data)
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


def errors(runs, references):
    """Of the forces on all links, runs against references layout by layout, relative to each reference's RMS (its peak
    for the last): middle over all windows with contact of the RMS in each, RMS, peak.

    The middle tells of the step. A leaf that slips off the arm another way is off for the rest of the sweep, in the
    other two.
    """
    in_windows, whole, peaks = [], [], []
    for forces, reference in zip(runs, references):
        squares = ((forces - reference)**2).sum(axis=(1, 2))
        own = (reference**2).sum(axis=(1, 2))
        for first in range(0, len(own), WINDOW):
            window = slice(first, first + WINDOW)
            if own[window].any():
                in_windows.append(squares[window].mean() / own.mean())
        whole.append(squares.mean() / own.mean())
        peaks.append(np.linalg.norm(forces - reference, axis=2).max() / np.linalg.norm(reference, axis=2).max())
    return math.sqrt(np.median(in_windows)), math.sqrt(np.mean(whole)), np.mean(peaks)


def compare_statics():
    """The same pushes on one leaf and on the arm in both engines."""
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
    if max(row[-1] for row in rows) > 0.01:
        sys.exit("the two models are not the same: a comparison of their speeds would mean nothing")


def frequency(swing, step_s):
    """From the first to the last upward crossing of zero, each interpolated."""
    up = np.flatnonzero((swing[:-1] < 0) & (swing[1:] >= 0))
    crossings = (up + swing[up] / (swing[up] - swing[up + 1])) * step_s
    return (len(crossings) - 1) / (crossings[-1] - crossings[0])


def compare_sweep(leaves, layouts, repeats):
    setups = [ours("setup", leaves, layout) for layout in range(layouts)]
    default = (setups[0]["default_step_s"], setups[0]["default_substeps"])
    print(f"| {leaves} leaves | step | middle error | RMS error | peak error | simulated s/s |\n|---|---|---|---|---|---|")
    references = [forces_of(our_run(leaves, layout, *OUR_REFERENCE, False)) for layout in range(layouts)]
    our_rows = []
    for step in OUR_STEPS:
        runs = [[our_run(leaves, layout, *step, True) for _ in range(repeats)] for layout in range(layouts)]
        found = errors([forces_of(of_layout[0]) for of_layout in runs], references)
        cost_s = [min(run["processor_time_s"] for run in of_layout) for of_layout in runs]
        name = f"{1e3 * step[0]:g} ms × {step[1]}{' (default)' if step == default else ''}"
        our_rows.append(row(name, found, cost_s, setups))
        show("underbrush", our_rows[-1])
    peer_references, peer_rows = {}, []
    for name, (options, flags) in PEER_SETTINGS.items():
        # Integrators and solvers converge to the same; cones and numbers of contacts are another physics each.
        physics = (options["cone"], flags.get("multiccd", "enable"))
        if physics not in peer_references:
            fine = ({"integrator": "implicitfast", "solver": "Newton", "cone": physics[0]},
                    {"sleep": "disable", "multiccd": physics[1]})
            peer_references[physics] = [Peer(setup, PEER_REFERENCE_STEP, *fine).forces() for setup in setups]
        for step_s in PEER_STEPS:
            peers = [Peer(setup, step_s, options, flags) for setup in setups]
            found = errors([peer.forces() for peer in peers], peer_references[physics])
            cost_s = [min(peer.processor_time_s() for _ in range(repeats)) for peer in peers]
            peer_rows.append(row(f"{1e3 * step_s:.3g} ms, {name}", found, cost_s, setups))
            show("MuJoCo", peer_rows[-1])
    compare_references(setups[0]["arm"]["links"], references, peer_references["elliptic", "enable"])
    summary(leaves, our_rows, peer_rows)


def forces_of(run):
    return np.array(run["force_on_links_n"])


def row(name, found, cost_s, setups):
    """Simulated seconds of all layouts over their costs."""
    simulated_s = sum(len(setup["equilibrium_rad"]) * setup["frame_period_s"] for setup in setups)
    return (name, *found, simulated_s / sum(cost_s))


def compare_references(links, here, there):
    """How far the forces of the two engines agree, both at the fine step."""
    middle, rms, _ = errors(there, here)
    print(f"\nMuJoCo's reference against ours: {middle:.2f} in the middle window, {rms:.2f} RMS. Mean force:")
    for link, name in enumerate(links):
        forces = [np.mean([mean_force(run, link) for run in runs]) for runs in (here, there)]
        if max(forces) > 0:
            print(f"- {name}: {forces[0]:.3f} N here, {forces[1]:.3f} N there")
    print()


def mean_force(forces, link):
    return np.linalg.norm(forces[:, link], axis=1).mean()


def show(engine, measured):
    name, middle, rms, peak, speed = measured
    print(f"| {engine} | {name} | {middle:.3f} | {rms:.3f} | {peak:.3f} | {speed:.1f} |", flush=True)


def summary(leaves, our_rows, peer_rows):
    """At each of our settings, MuJoCo's quickest setting whose middle error is no larger."""
    print(f"| {leaves} leaves: ours | middle error | simulated s/s | MuJoCo at no larger error | its error | simulated s/s "
          "| ours / MuJoCo |\n|---|---|---|---|---|---|---|")
    for name, middle, _, _, speed in our_rows:
        equal = [row for row in peer_rows if row[1] <= middle]
        best = max(equal, key=lambda row: row[-1], default=("none", math.nan, 0, 0, math.nan))
        print(f"| {name} | {middle:.3f} | {speed:.1f} | {best[0]} | {best[1]:.3f} | {best[-1]:.1f} "
              f"| {speed / best[-1]:.2f} |")
    print(flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--leaves", type=int, nargs="+", default=[24, 48])
    parser.add_argument("--layouts", type=int, default=3, help="layouts of the leaves, averaged over")
    parser.add_argument("--repeats", type=int, default=3, help="runs of which the quickest counts")
    given = parser.parse_args()
    subprocess.run(["cargo", "build", "--release", "--example", "foliage_peer"], check=True)
    if hasattr(os, "sched_setaffinity"):
        # One core for both; the last, as interrupts prefer the first.
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    print(f"{ours('setup', 0, 0)['engine']} against MuJoCo {mujoco.__version__}, Python {platform.python_version()}, "
          f"{processor()}, {time.strftime('%Y-%m-%d')}\n")
    compare_statics()
    for leaves in given.leaves:
        compare_sweep(leaves, given.layouts, given.repeats)


def processor():
    try:
        with open("/proc/cpuinfo") as lines:
            return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()


if __name__ == "__main__":
    main()
