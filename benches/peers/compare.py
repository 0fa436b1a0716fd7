"""The sweep of `benches/peers/sweep.rs` here and in MuJoCo: the same statics, the force error over the step, the speed.

    pip install -r benches/peers/requirements.txt
    python benches/peers/compare.py [--leaves 24 48] [--layouts 3]

Run it from the workspace. Each engine's forces are compared with its own run at a fine step, so that speeds can be
compared at equal error; a speed is simulated seconds per second of processor time of one core, physics alone, the
quickest of several runs.
"""

import argparse
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

from engines import Peer, our_run, ours
from statics import compare_statics

# Ours: step, s. References step 0.1 ms, without dormancy here and without sleeping there.
OUR_STEPS = [0.01, 0.005, 0.0025, 0.001]
OUR_REFERENCE = 0.0001

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
# Length of the windows, frames, of which the middle error is taken.
WINDOW = 30


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


def compare_sweep(leaves, layouts, repeats):
    setups = [ours("setup", leaves, layout) for layout in range(layouts)]
    default = setups[0]["default_step_s"]
    print(f"| {leaves} leaves | step | middle error | RMS error | peak error | simulated s/s |\n|---|---|---|---|---|---|")
    references = [forces_of(our_run(leaves, layout, OUR_REFERENCE, False)) for layout in range(layouts)]
    our_rows = []
    for step in OUR_STEPS:
        runs = [[our_run(leaves, layout, step, True) for _ in range(repeats)] for layout in range(layouts)]
        found = errors([forces_of(of_layout[0]) for of_layout in runs], references)
        cost_s = [min(run["processor_time_s"] for run in of_layout) for of_layout in runs]
        name = f"{1e3 * step:g} ms{' (default)' if step == default else ''}"
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
    """At the middle error of each of our steps, MuJoCo's speed with the best settings for it."""
    print(f"| {leaves} leaves: ours | middle error | simulated s/s | MuJoCo at equal error | with | ours / MuJoCo |\n"
          "|---|---|---|---|---|---|")
    for name, middle, _, _, speed in our_rows:
        there, settings = max((at_error(peer_rows, settings, middle), settings) for settings in PEER_SETTINGS)
        if there > 0:
            print(f"| {name} | {middle:.3f} | {speed:.1f} | {there:.1f} | {settings} | {speed / there:.2f} |")
        else:
            print(f"| {name} | {middle:.3f} | {speed:.1f} | not reached | | |")
    print(flush=True)


def at_error(peer_rows, settings, error):
    """Speed of one kind of settings at a given error, between the steps measured as a power law; 0 where none of them is
    as exact, the quickest where all that hold together are."""
    points = [(row[1], row[-1]) for row in peer_rows if row[0].endswith(f", {settings}") and math.isfinite(row[1])]
    # From the finest step on, only those that are coarser and quicker.
    points.sort(key=lambda point: point[1])
    if not points or points[0][0] > error:
        return 0.0
    for (exact, slow), (coarse, quick) in zip(points, points[1:]):
        if coarse > error:
            share = math.log(error / exact) / math.log(coarse / exact)
            return slow * (quick / slow) ** share
    return points[-1][1]


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
