#!/usr/bin/env python3
"""Runs many reaches of all scenes and looks for panics, non-finite numbers, large forces, lost contacts and growing memory.

    python3 benches/endurance.py --reaches 2000 [--underbrush target/release/underbrush] [--folder DIR] [--seed N]

The reaches are divided among the scenes in scenes/ and suites/scenes/, and each scene has a process and a seed of its
own. A number that is not finite cannot be written, so `generate` would fail; so would a panic inside the engine.
`inspect --audit` reads every file again: the largest contact force, the deepest penetration, overlaps without a patch,
and the share of the impulse of the joints that τ = Jᵀf leaves open. The largest force of a leaf comes from
`truth/contacts`. Memory counts as growing if the largest resident
memory in the second half of the simulating time is more than a tenth, and more than 30 MB, above that of the first
half. Assembling the set at the end has a column of its own, because it needs more memory than simulating does
(benches/growth.py measures how that grows). Prints one row for each scene, and exits with status 1 if anything was
found. Needs Linux and the package pyarrow.
"""

import argparse
import glob
import json
import os
import subprocess
import sys
import tempfile
import time

import pyarrow.compute
import pyarrow.dataset

LARGEST_FORCE_N = 1000
# The most that memory may grow from the first half to the second: as a share of the first, or in megabytes.
MOST_GROWTH = 0.1
MOST_GROWTH_MB = 30
SECONDS_BETWEEN_SAMPLES = 0.2


def resident_mb(process):
    """Resident memory of a running process; None once it has ended."""
    try:
        with open(f"/proc/{process}/status", encoding="ascii") as status:
            lines = [line for line in status if line.startswith("VmRSS:")]
    except OSError:
        return None
    return int(lines[0].split()[1]) / 1024 if lines else None


def generate(command, out, log):
    """Runs a command and samples its memory; returns its exit status, seconds, and samples while simulating and assembling."""
    start = time.monotonic()
    simulating, assembling = [], []
    with open(log, "wb") as errors, subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors) as process:
        while process.poll() is None:
            # The tables are begun when all reaches are staged. This is checked before the sample is taken, so every
            # sample that counts for assembling was taken after it began.
            samples = assembling if os.path.exists(os.path.join(out, "meta")) else simulating
            sample = resident_mb(process.pid)
            if sample is not None:
                samples.append(sample)
            time.sleep(SECONDS_BETWEEN_SAMPLES)
    return process.returncode, time.monotonic() - start, simulating, assembling


def largest_leaf_force_n(out):
    """The largest contact force of a leaf in a data set; 0 without any."""
    contacts = pyarrow.dataset.dataset(os.path.join(out, "truth", "contacts"))
    of_leaves = pyarrow.compute.field("category") == "leaf"
    return pyarrow.compute.max(contacts.to_table(["peak_force_n"], filter=of_leaves)["peak_force_n"]).as_py() or 0


def check(underbrush, scene, reaches, seed, folder):
    """Runs reaches of one scene; returns a row of the table and what was found."""
    out = os.path.join(folder, "set")
    log = os.path.join(folder, "log.txt")
    command = [underbrush, "generate", scene, "--reaches", str(reaches), "--seed", str(seed), "--jobs", "1", "--out", out]
    status, seconds, simulating, assembling = generate(command, out, log)
    if status != 0:
        with open(log, encoding="utf-8", errors="replace") as errors:
            return None, [f"{scene}, seed {seed}: exit status {status}: {errors.read().strip()}"]
    done = subprocess.run([underbrush, "inspect", out, "--audit", "--json"], capture_output=True, text=True)
    # If torques and contacts do not explain the motion, `inspect` prints its result and ends with status 1.
    found = [f"{scene}, seed {seed}: {done.stderr.strip()}"] if done.returncode else []
    inspected = json.loads(done.stdout)
    if "error" in inspected:
        return None, found
    force_n = inspected["largest_contact_force_n"]
    if not 0 <= force_n <= LARGEST_FORCE_N:
        found.append(f"{scene}, seed {seed}: a contact force of {force_n} N; allowed: {LARGEST_FORCE_N} N")
    audit = {name: figure["value"] for name, figure in inspected["audit_worst"].items()}
    lost_mm = 1000 * audit["overlap_without_patch_m"]
    if lost_mm > 0:
        found.append(f"{scene}, seed {seed}: an overlap of {lost_mm:.2f} mm without a patch")
    open_share = max((balance["residual_share"] for balance in inspected["torque_balance"].values()), default=0)
    halves = simulating[: len(simulating) // 2], simulating[len(simulating) // 2 :]
    first, second, end = (max(part, default=0) for part in [*halves, assembling])
    if second > first + max(MOST_GROWTH * first, MOST_GROWTH_MB):
        found.append(f"{scene}, seed {seed}: memory grew from {first:.0f} to {second:.0f} MB")
    name = os.path.relpath(scene)
    row = f"| {name} | {seed} | {inspected['reaches']} | {inspected['frames']} | {force_n:.1f} | {largest_leaf_force_n(out):.1f} | {1000 * audit['deepest_penetration_m']:.1f} | {lost_mm:.2f} | {100 * open_share:.2f} | {first:.0f} | {second:.0f} | {end:.0f} | {seconds:.0f} |"
    return row, found


def main():
    root = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--reaches", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=10_000, help="seed of the first scene; each further one has the next")
    parser.add_argument("--underbrush", default=os.path.join(root, "target/release/underbrush"))
    parser.add_argument("--folder", help="where to write the sets; a temporary folder if not given")
    options = parser.parse_args()
    scenes = sorted(glob.glob(f"{root}/scenes/**/*.toml", recursive=True) + glob.glob(f"{root}/suites/scenes/**/*.toml", recursive=True))
    print("| scene | seed | reaches | frames | largest force / N | of a leaf / N | deepest / mm | lost / mm | torques / % | memory, first half / MB | second half / MB | assembling / MB | s |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|---|")
    complaints = []
    for place, scene in enumerate(scenes):
        reaches = options.reaches // len(scenes) + (place < options.reaches % len(scenes))
        if reaches == 0:
            continue
        with tempfile.TemporaryDirectory(dir=options.folder) as folder:
            row, found = check(options.underbrush, scene, reaches, options.seed + place, folder)
        if row:
            print(row, flush=True)
        complaints += found
        for complaint in found:
            print(complaint, file=sys.stderr, flush=True)
    print(f"{len(scenes)} scenes, {len(complaints)} findings")
    sys.exit(1 if complaints else 0)


if __name__ == "__main__":
    main()
