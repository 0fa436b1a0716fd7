"""Compares the sweep of `benches/peers/sweep.rs` here and in MuJoCo: the statics, and the speeds at equal error.

    pip install -r benches/peers/requirements.txt
    python benches/peers/compare.py [--leaves 24 48] [--layouts 3]

Run it from the root of the workspace. Each engine is compared with its own run at a fine step: every 0.3 s a copy of
that run continues with a coarser step for 0.3 s. In so short a time leaves seldom follow a different path, so the
difference is the error due to the step. A speed is the simulated seconds per second of processor time on one core over
whole sweeps, physics alone, in the fastest of several runs.
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

from engines import Peer, our_run, ours, restarted
from statics import compare_statics

# Step of both reference runs, s. MuJoCo's reference runs without sleeping.
REFERENCE = 0.0001
OUR_STEPS = [0.01, 0.005, 0.0025, 0.00125, 0.001, 0.0005]
PEER_STEPS = [0.01, 0.005, 0.0025, 0.00125, 0.001, 0.0005, 0.00025]
# MuJoCo's options and flags. `discrete` has implicit springs and is the fastest that stays stable at steps over 2 ms;
# `implicitfast` is the usual recommendation. Other settings were tried before and are no better: Euler, PGS, fewer
# iterations, a dense Jacobian and exact constraint inertia.
PEER_SETTINGS = {
    "discrete, elliptic": ({"integrator": "discrete", "cone": "elliptic"}, {}),
    "discrete, elliptic, one contact a pair": (
        {"integrator": "discrete", "cone": "elliptic"}, {"multiccd": "disable"}),
    "implicitfast, elliptic": ({"integrator": "implicitfast", "cone": "elliptic"}, {}),
    "discrete, pyramidal": ({"integrator": "discrete", "cone": "pyramidal"}, {}),
}
# Length of a window, frames of 10 ms, and the least RMS force in it, N: as in `benches/time_step.rs`.
WINDOW = 30
LEAST_N = 0.05
# Errors at which speeds are compared.
ERRORS = [0.01, 0.02, 0.05, 0.1]


def window_errors(reference, other):
    """RMS difference of the forces on all links divided by their RMS, for each window with contact."""
    found = []
    for first in range(0, len(reference), WINDOW):
        own, difference = (forces[first:first + WINDOW] for forces in (reference, other - reference))
        square = (own**2).sum() / len(own)
        if math.sqrt(square) >= LEAST_N:
            found.append(math.sqrt((difference**2).sum() / len(own) / square))
    return found


def here(leaves, layouts, repeats):
    """For each step, the errors of the windows and the processor times, s; and the forces of the reference runs."""
    rows, references = {step: ([], []) for step in OUR_STEPS}, []
    for layout in range(layouts):
        found = ours("windows", leaves, layout, WINDOW, REFERENCE, *OUR_STEPS)
        references.append(np.array(found["reference"]))
        for (step, (errors, costs)), forces in zip(rows.items(), found["restarted"]):
            errors += window_errors(references[-1], np.array(forces))
            costs.append(min(our_run(leaves, layout, step, True)["processor_time_s"] for _ in range(repeats)))
    return rows, references


def there(setups, repeats):
    """As `here`, but in MuJoCo and for each of its settings."""
    found, references = {}, {}
    for name, (options, flags) in PEER_SETTINGS.items():
        rows = found[name] = {step: ([], []) for step in PEER_STEPS}
        options = {"solver": "Newton", **options}
        # All integrators converge to the same solution; other cones and numbers of contacts are other models.
        fine = ({**options, "integrator": "implicitfast"}, {**flags, "sleep": "disable"})
        for setup in setups:
            peers = [Peer(setup, step, options, flags) for step in PEER_STEPS]
            reference, forces = restarted(Peer(setup, REFERENCE, *fine), peers, WINDOW)
            references.setdefault(name, []).append(reference)
            for (errors, costs), peer, own in zip(rows.values(), peers, forces):
                errors += window_errors(reference, own)
                costs.append(min(peer.processor_time_s() for _ in range(repeats)))
    return found, references


def points(rows, simulated_s):
    """Step, median error and speed of each row; an unstable step has no median and is left out."""
    found = [(step, float(np.median(errors)), simulated_s / sum(costs)) for step, (errors, costs) in rows.items()]
    return [point for point in found if math.isfinite(point[1])]


def speed_at(found, error):
    """The best speed with at most this error, interpolated between the measured steps by a power law; 0 if no step is
    as exact."""
    best = 0.0
    for (_, coarse, quick), (_, exact, slow) in zip(found, found[1:]):
        if exact <= error < coarse:
            best = max(best, slow * (quick / slow)**(math.log(error / exact) / math.log(coarse / exact)))
    return max([best, *(speed for _, own, speed in found if own <= error)])


def compare_sweep(leaves, layouts, repeats):
    setups = [ours("setup", leaves, layout) for layout in range(layouts)]
    simulated_s = sum(len(setup["equilibrium_rad"]) * setup["frame_period_s"] for setup in setups)
    rows, references = here(leaves, layouts, repeats)
    mine = points(rows, simulated_s)
    windows = len(next(iter(rows.values()))[0])
    print(f"| {leaves} leaves, {windows} windows | step / ms | median error | simulated s/s |\n|---|---|---|---|")
    show("underbrush", mine)
    found, peer_references = there(setups, repeats)
    peers = {name: points(rows, simulated_s) for name, rows in found.items()}
    for name, own in peers.items():
        show(f"MuJoCo, {name}", own)
    print("\nMean force on the arm at the fine step: "
          + "; ".join(f"{name} {mean_force(own):.3f} N" for name, own in {"underbrush": references, **peer_references}.items()))
    print(f"\n| {leaves} leaves, error | underbrush, simulated s/s | MuJoCo | with | ratio |\n|---|---|---|---|---|")
    for error in ERRORS:
        own = speed_at(mine, error)
        best, name = max((speed_at(points, error), name) for name, points in peers.items())
        ratio = f"{own / best:.2f}" if best > 0 else ""
        print(f"| {100 * error:g} % | {own:.1f} | {best:.1f} | {name if best > 0 else 'not reached'} | {ratio} |")
    print(flush=True)


def mean_force(references):
    return np.mean([np.linalg.norm(forces.sum(axis=1), axis=1).mean() for forces in references])


def show(engine, found):
    for step, error, speed in found:
        print(f"| {engine} | {1e3 * step:g} | {100 * error:.2f} % | {speed:.1f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--leaves", type=int, nargs="+", default=[24, 48])
    parser.add_argument("--layouts", type=int, default=3, help="layouts of the leaves, averaged over")
    parser.add_argument("--repeats", type=int, default=3, help="runs of which the quickest counts")
    given = parser.parse_args()
    subprocess.run(["cargo", "build", "--release", "--workspace", "--example", "foliage_peer"], check=True)
    if hasattr(os, "sched_setaffinity"):
        # Both engines run on one core. It is the last one, because interrupts prefer the first.
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
