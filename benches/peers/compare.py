"""The sweep of `benches/peers/sweep.rs` here and in MuJoCo: the same statics, the force error over the step, the speed.

    pip install -r benches/peers/requirements.txt
    python benches/peers/compare.py [--leaves 24 48] [--quick]

Run it from the workspace. Each engine's forces are compared with its own run at a fine step; speeds are simulated
seconds per second of processor time of one core, physics alone, the quickest of several runs.
"""

import argparse
import json
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

# Ours: (step, s; substeps). The reference steps 0.1 ms.
OUR_STEPS = [(0.01, 1), (0.01, 2), (0.01, 4), (0.005, 1), (0.005, 2), (0.005, 4), (0.0025, 1), (0.0025, 2),
             (0.001, 1), (0.001, 4)]
OUR_REFERENCE = (0.0001, 1)
# MuJoCo's: every combination, then the pair that is best at its error. `discrete` has implicit springs; the others
# take them explicitly, `implicitfast` is the usual recommendation and `Euler` the default.
PEER_STEPS = [0.005, 0.0025, 0.002, 0.00125, 0.001, 0.0005]
PEER_SETTINGS = [
    {"integrator": integrator, "solver": solver, "cone": cone}
    for integrator in ("discrete", "implicitfast", "Euler")
    for solver, cone in (("Newton", "pyramidal"), ("Newton", "elliptic"), ("CG", "pyramidal"))
]
PEER_REFERENCE_STEP = 0.0001
# The inertia that a contact adds is d/(1 − d) of the effective mass: none would be best, a half is where the
# explicit integrators are still stable at a millisecond.
IMPEDANCE = 0.5


def ours(*words):
    command = ["cargo", "run", "--release", "--quiet", "--example", "foliage_peer", "--", *map(str, words)]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)


def our_run(leaves, step_s, substeps, dormancy):
    return ours("run", leaves, step_s, substeps, str(dormancy).lower())


class Peer:
    """One MuJoCo model of the sweep with its settings."""

    def __init__(self, setup, step_s, settings, sleep=True):
        self.setup = setup
        options = {"timestep": step_s, **settings}
        flags = {"sleep": "enable" if sleep else "disable", "diagexact": "enable"}
        self.model = mujoco.MjModel.from_xml_string(Builder(setup, options, flags, IMPEDANCE, sleep).xml())
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


def errors(forces, reference, link):
    """Relative to the reference: RMS over all links, RMS on one link, peak over all links."""
    def rms(x):
        return np.sqrt((x**2).sum(axis=2).mean())

    difference = forces - reference
    return (rms(difference) / rms(reference),
            rms(difference[:, [link]]) / rms(reference[:, [link]]),
            np.linalg.norm(difference, axis=2).max() / np.linalg.norm(reference, axis=2).max())


def quickest(run, repeats, simulated_s):
    return simulated_s / min(run() for _ in range(repeats))


def compare_statics():
    """The same pushes on one leaf and on the arm in both engines."""
    expected = ours("statics")
    setup = ours("setup", 1)
    peer = Peer(setup, expected["step_s"], {"integrator": "implicitfast"}, sleep=False)
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


def compare_sweep(leaves, repeats, quick):
    setup = ours("setup", leaves)
    forearm = setup["arm"]["links"].index("forearm")
    simulated_s = len(setup["equilibrium_rad"]) * setup["frame_period_s"]
    rows = []
    reference = np.array(our_run(leaves, *OUR_REFERENCE, False)["force_on_links_n"])
    for step_s, substeps in OUR_STEPS:
        runs = [our_run(leaves, step_s, substeps, True) for _ in range(repeats)]
        speed = simulated_s / min(run["processor_time_s"] for run in runs)
        name = f"{1e3 * step_s:g} ms × {substeps}"
        if (step_s, substeps) == (setup["default_step_s"], setup["default_substeps"]):
            name += " (default)"
        rows.append(("underbrush", name, *errors(np.array(runs[0]["force_on_links_n"]), reference, forearm), speed))
        show(rows[-1])
    peer_references = {}
    for settings in PEER_SETTINGS[:1] if quick else PEER_SETTINGS:
        # One reference a physics: integrator and solver converge to the same, the cones do not.
        cone = settings["cone"]
        if cone not in peer_references:
            fine = {"integrator": "implicitfast", "solver": "Newton", "cone": cone}
            peer_references[cone] = Peer(setup, PEER_REFERENCE_STEP, fine, sleep=False).forces()
        for step_s in PEER_STEPS:
            peer = Peer(setup, step_s, settings)
            found = errors(peer.forces(), peer_references[cone], forearm)
            speed = quickest(peer.processor_time_s, repeats, simulated_s)
            rows.append(("MuJoCo", f"{1e3 * step_s:g} ms, {', '.join(settings.values())}", *found, speed))
            show(rows[-1])
    agree = errors(peer_references["pyramidal"], reference, forearm)
    print(f"\nMuJoCo's reference against ours: {agree[0]:.2f} RMS, {agree[1]:.2f} on the forearm; mean force on the arm "
          f"{mean_force(reference):.3f} N here, {mean_force(peer_references['pyramidal']):.3f} N there\n")
    summary(leaves, rows)


def mean_force(forces):
    return np.linalg.norm(forces, axis=2).sum(axis=1).mean()


def show(row):
    engine, name, rms, on_forearm, peak, speed = row
    print(f"| {engine} | {name} | {rms:.3f} | {on_forearm:.3f} | {peak:.3f} | {speed:.1f} |", flush=True)


def summary(leaves, rows):
    """At each of our settings, MuJoCo's quickest setting whose RMS error is no larger."""
    print(f"| {leaves} leaves: ours | RMS error | ours, sim. s/s | MuJoCo at no larger error | its error | sim. s/s | ratio |")
    print("|---|---|---|---|---|---|---|")
    for engine, name, rms, _, _, speed in rows:
        if engine != "underbrush":
            continue
        equal = [row for row in rows if row[0] == "MuJoCo" and row[2] <= rms]
        if equal:
            best = max(equal, key=lambda row: row[-1])
            print(f"| {name} | {rms:.3f} | {speed:.1f} | {best[1]} | {best[2]:.3f} | {best[-1]:.1f} | "
                  f"{speed / best[-1]:.2f} |")
        else:
            print(f"| {name} | {rms:.3f} | {speed:.1f} | none of the settings above | | | |")
    print(flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--leaves", type=int, nargs="+", default=[24, 48])
    parser.add_argument("--repeats", type=int, default=5, help="runs of which the quickest counts")
    parser.add_argument("--quick", action="store_true", help="only MuJoCo's best settings")
    given = parser.parse_args()
    subprocess.run(["cargo", "build", "--release", "--example", "foliage_peer"], check=True)
    if hasattr(os, "sched_setaffinity"):
        # One core for both; the last, as interrupts prefer the first.
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    print(f"{ours('setup', 0)['engine']} against MuJoCo {mujoco.__version__}, Python {platform.python_version()}, "
          f"{processor()}, {time.strftime('%Y-%m-%d')}\n")
    compare_statics()
    print("| engine | step | RMS error | on the forearm | peak error | simulated s/s |\n|---|---|---|---|---|---|")
    for leaves in given.leaves:
        compare_sweep(leaves, given.repeats, given.quick)


def processor():
    try:
        with open("/proc/cpuinfo") as lines:
            return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()


if __name__ == "__main__":
    main()
