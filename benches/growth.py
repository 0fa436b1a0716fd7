#!/usr/bin/env python3
"""How the time and memory for merging, inspecting and opening a data set grow with its number of reaches.

    python3 benches/growth.py [--underbrush target/release/underbrush] [--folder DIR] 10 100 1000

For each of the numbers, makes that many short reaches in four parts, merges the parts to a set, and prints one row:
processor time (user and system) in seconds and largest resident memory in MB of each command. Other work on the
machine hardly changes processor time, but waiting for a disk is not in it. `generate` is the sum of all parts, and
`open` is `merge --resume` on the finished set, which opens all parts and the set and does nothing else. Exits with
status 1 if time per reach or memory grows by more than is allowed from one set to the next. Needs Linux and no
packages.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile

SCENE = """summary = "Nothing but a goal"

[goals]
count = 1
retries = 0
patience_s = 0.1
x_m = { uniform = [0.60, 0.72] }

[[objects.trunk]]
count = 1
place = { x_m = { uniform = [0.45, 0.60] }, y_m = { uniform = [-0.40, -0.20] } }
"""
PARTS = 4
# Time per reach and memory may be larger by this factor in the larger set, and memory by `MEMORY_KB_PER_REACH` more.
# Choice: a quadratic algorithm would be ten times slower per reach from one size to the next.
MOST_TIME = 1.5
# Memory that each reach of a set may need: its row in the table of episodes and its entry in the plan, kB.
MEMORY_KB_PER_REACH = 12


def measured(command):
    """Runs a command; returns its processor time in seconds and its largest resident memory in megabytes."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{' '.join(command)} ended with {process.returncode}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def row(underbrush, folder, reaches):
    """Makes one set and measures the commands on it."""
    scene = os.path.join(folder, "short.toml")
    with open(scene, "w", encoding="utf-8") as file:
        file.write(SCENE)
    parts = [os.path.join(folder, f"part-{part}") for part in range(1, PARTS + 1)]
    generate = [underbrush, "generate", scene, "--reaches", str(reaches), "--seed", "1", "--jobs", "1"]
    generated = [
        measured([*generate, "--shard", f"{index}/{PARTS}", "--out", part]) for index, part in enumerate(parts, 1)
    ]
    whole = os.path.join(folder, "whole")
    merge = [underbrush, "merge", *parts, "--out", whole]
    figures = {
        "generate": (sum(seconds for seconds, _ in generated), max(memory for _, memory in generated)),
        "merge": measured(merge),
        "open": measured([*merge, "--resume"]),
        "inspect": measured([underbrush, "inspect", whole]),
    }
    files = [os.path.join(place, name) for place, _, names in os.walk(whole) for name in names]
    megabytes = sum(os.path.getsize(file) for file in files) / 1e6
    for path in [*parts, whole]:
        shutil.rmtree(path)
    return megabytes, figures


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--underbrush", default="target/release/underbrush")
    parser.add_argument("--folder", help="where to make the sets; a temporary folder if not given")
    parser.add_argument("reaches", nargs="+", type=int)
    options = parser.parse_args()
    commands = ["generate", "merge", "open", "inspect"]
    print("| reaches | set / MB | " + " | ".join(f"{name} / s | / MB" for name in commands) + " |")
    print("|---" * (2 + 2 * len(commands)) + "|")
    before = None
    complaints = []
    for reaches in sorted(options.reaches):
        with tempfile.TemporaryDirectory(dir=options.folder) as folder:
            megabytes, figures = row(options.underbrush, folder, reaches)
        cells = " | ".join(f"{figures[name][0]:.2f} | {figures[name][1]:.0f}" for name in commands)
        print(f"| {reaches} | {megabytes:.1f} | {cells} |", flush=True)
        for name in commands if before else []:
            seconds, memory = figures[name]
            seconds_before, memory_before = before[1][name]
            # Starting a process takes a few hundredths of a second, which would dominate the time of small sets.
            if seconds > 0.5 and seconds / reaches > MOST_TIME * max(seconds_before, 0.05) / before[0]:
                complaints.append(f"{name} of {reaches} reaches: {seconds:.2f} s, after {seconds_before:.2f} s")
            allowed = MOST_TIME * memory_before + MEMORY_KB_PER_REACH * reaches / 1024
            if memory > allowed:
                complaints.append(f"{name} of {reaches} reaches: {memory:.0f} MB; allowed: {allowed:.0f} MB")
        before = (reaches, figures)
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    sys.exit(1 if complaints else 0)


if __name__ == "__main__":
    main()
