#!/usr/bin/env python3
"""Makes every system call that changes files fail once, while a set is generated, assembled or merged.

    python3 tests/faults.py [--underbrush target/release/underbrush] [--every N] [--only COMMAND]

For each n, strace makes the n-th call of `openat` (for writing), `write`, `fsync`, `renameat`, `mkdir`, … fail with
ENOSPC and with EIO, or kills the program there. The n-th `write` is also cut short (cut_short.c): half of its bytes are
written, and after that everything works as usual, or the disk is full, or it fails, or the program is killed. After
each run one of these must hold; if neither does, the script prints what is wrong and ends with exit status 1:

* whole: the output is there, with the bytes of a run without faults (beside a set, the empty file incomplete/lock may
  be left, which readers ignore and the next run removes);
* unfinished: `inspect` refuses the set as unfinished, or there is no set yet.

In both cases the same command without a fault (with --resume) must lead to the same bytes, without leftovers.
A program that was not killed must not report success unless the output is whole, and must name what failed, without a
panic. A write that is cut short and followed by no fault must change nothing.

read_faults.py does the same with the calls that read. Both need Linux, strace and a C compiler, but no
Python packages; TMPDIR=/dev/shm makes them faster. `--every N` tries only every N-th write; all other calls are always tried.
"""

import argparse
import collections
import errno
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
# A finger of two joints, whose reaches take milliseconds.
SCENE = os.path.join(ROOT, "fuzz/seeds/reached.toml")
CALLS = ["openat", "write", "pwrite64", "writev", "fsync", "fdatasync", "ftruncate", "renameat", "renameat2", "rename"]
CALLS += ["mkdir", "mkdirat", "unlink", "unlinkat", "rmdir", "linkat", "copy_file_range"]
# Without --seccomp-bpf, because strace 6.1 does not deliver signals with it.
STRACE = ["strace", "-f"]
FAULTS = {"ENOSPC": "error=ENOSPC", "EIO": "error=EIO", "kill": "signal=KILL"}
# What happens after a call that was cut short.
AFTER_CUT = {"ENOSPC": str(errno.ENOSPC), "EIO": str(errno.EIO), "kill": "kill", "nothing": "nothing"}
# Parts of what `inspect` says about a set that is unfinished or that is not there yet.
UNFINISHED = ["unfinished", "no such file or folder", "no meta/info.json"]
SECONDS = 120


def contents(path, without=None):
    """One hash over the names and bytes of all files at a path, except the file `without`; None if nothing is there."""
    if not os.path.exists(path):
        return None
    files = [path]
    if os.path.isdir(path):
        files = sorted(os.path.join(place, name) for place, _, names in os.walk(path) for name in names)
        files = [file for file in files if os.path.relpath(file, path) != without]
    digest = hashlib.sha256()
    for file in files:
        with open(file, "rb") as bytes_of:
            own = bytes_of.read()
        digest.update(f"{os.path.relpath(file, path)} {len(own)}\n".encode() + own)
    return digest.hexdigest()


def run(command, folder, **variables):
    """Runs a command with more environment variables; returns exit status (negative for signals) and standard error."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    done = subprocess.run(command, cwd=folder, timeout=SECONDS, check=False, env=os.environ | variables, **pipes)
    return done.returncode, done.stderr.decode(errors="replace")


def compiled(folder):
    """The library that cuts calls short, made in a folder."""
    library = os.path.join(folder, "cut_short.so")
    source = os.path.join(os.path.dirname(os.path.abspath(__file__)), "cut_short.c")
    subprocess.run(["cc", "-O1", "-shared", "-fPIC", "-o", library, source], check=True)
    return library


def cut(library, call, number, then):
    """The environment variables that make the library cut a call short."""
    return {"LD_PRELOAD": library, "CUT_CALL": call, "CUT_NUMBER": str(number), "CUT_THEN": then}


class Job:
    """A command that writes `out`, a set or a file, in a folder in which `prepare` has made its inputs. `again` continues it."""

    def __init__(self, name, command, out, prepare=None, again=None, is_set=True):
        self.name, self.command, self.out, self.is_set = name, command, out, is_set
        self.writes = 0
        self.prepare = prepare or (lambda folder: None)
        self.again = again or command

    def fresh(self, folder):
        """Makes the folder anew, with the inputs of the command."""
        start = f"{folder} of {self.name}"
        if not os.path.exists(start):
            os.makedirs(start)
            self.prepare(start)
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(start, folder)

    def points(self, folder):
        """The calls that change files: {call: sorted numbers}, counted from 1 in each thread, as strace counts. Stores
        the number of writes of all threads as `writes`."""
        self.fresh(folder)
        log = os.path.join(folder, "..", "trace")
        status, errors = run([*STRACE, "-o", log, "-e", f"trace={','.join(CALLS)}", *self.command], folder)
        if status != 0:
            sys.exit(f"{self.name} without a fault: {errors}")
        counts = collections.Counter()
        points = collections.defaultdict(set)
        with open(log, encoding="utf-8", errors="replace") as lines:
            for line in lines:
                found = re.match(r"(\d+) +(\w+)\(", line)
                if found:
                    counts[found.groups()] += 1
                    call = found.group(2)
                    if call != "openat" or re.search("O_WRONLY|O_RDWR|O_CREAT", line):
                        points[call].add(counts[found.groups()])
        self.writes = sum(count for (_, call), count in counts.items() if call == "write")
        return {call: sorted(numbers) for call, numbers in points.items()}

    def whole(self, folder, without=None):
        return contents(os.path.join(folder, self.out), without)


def judge(job, call, folder, underbrush, expected, status, errors):
    """The outcome of a faulty run, and what is wrong with it."""
    wrong = []
    if "panicked" in errors:
        wrong.append(f"a panic: {errors.strip()[:300]}")
    whole = job.whole(folder, "incomplete/lock") == expected
    if status == 0 and not whole:
        wrong.append("success is reported, but the output is not whole")
    # The message is also written, and this may be the write that fails.
    if status > 0 and call != "write" and not errors.strip():
        wrong.append("no message")
    if not whole and job.is_set:
        inspected, said = run([underbrush, "inspect", job.out], folder)
        if inspected == 0 or not any(text in said for text in UNFINISHED):
            wrong.append(f"inspect ends with {inspected}: {said.strip()[:300]}")
    again, said = run(job.again, folder)
    if again != 0:
        wrong.append(f"the next run ends with {again}: {said.strip()[:300]}")
    elif job.whole(folder) != expected:
        listing = sorted(os.path.relpath(os.path.join(place, name), folder) for place, _, names in os.walk(folder) for name in names)
        wrong.append(f"the next run leads to other bytes: {' '.join(listing)[:600]}")
    outcome = "killed, " if status < 0 or status == 137 else "success, " if status == 0 else "error, "
    return outcome + ("whole" if whole else "unfinished"), wrong


def jobs(underbrush, folder):
    """The commands to try, as `Job`s."""
    generate = [underbrush, "generate", SCENE, "--reaches", "2", "--seed", "0", "--jobs", "1", "--out", "set"]
    parts = os.path.join(folder, "parts")
    for part in (1, 2):
        own = [*generate[:-1], os.path.join(parts, str(part)), "--shard", f"{part}/2"]
        subprocess.run(own, check=True, stdout=subprocess.DEVNULL)
    whole = os.path.join(folder, "whole")
    subprocess.run([*generate[:-1], whole], check=True, stdout=subprocess.DEVNULL)

    def staged(place):
        """Stages all reaches and assembles none: kills the program when it makes the first folder for the tables."""
        for number in range(1, 20):
            run([*STRACE, "-o", "/dev/null", "-e", "trace=mkdir", "-e", f"inject=mkdir:signal=KILL:when={number}", *generate], place)
            if os.path.exists(os.path.join(place, "set/incomplete/reach-000001.json")):
                return
            shutil.rmtree(os.path.join(place, "set"), ignore_errors=True)
        sys.exit("the reaches are not staged where this script expects them")

    shared = [*generate, "--shared", "--shard"]

    def first_part(place):
        """Runs the first of two parts, which leaves its reach in the folder."""
        subprocess.run([*shared, "1/2"], cwd=place, check=True, stdout=subprocess.DEVNULL)

    merge = [underbrush, "merge", f"{parts}/1", f"{parts}/2", "--out", "set"]
    return [
        Job("generate", generate, "set", again=[*generate, "--resume"]),
        Job("generate --resume, all staged", [*generate, "--resume"], "set", prepare=staged),
        Job("generate --shared, last part", [*shared, "2/2"], "set", prepare=first_part),
        Job("merge", merge, "set", again=[*merge, "--resume"]),
    ]


class Complaints:
    """Prints complaints, and counts them."""

    def __init__(self):
        self.count = 0

    def add(self, where, wrong):
        for complaint in wrong:
            self.count += 1
            print(f"{where}: {complaint}", file=sys.stderr, flush=True)


def summary(outcomes):
    """A cell of the table."""
    return ", ".join(f"{count} {outcome}" for outcome, count in sorted(outcomes.items()))


def try_all(job, underbrush, place, library, every, complaints):
    """Makes each call of a command fail in each way, and prints a row for each kind of call."""
    points = job.points(place)
    expected = job.whole(place)

    def row(call, name, tried, faults):
        """Prints a row. `faults` has a function for each fault, which runs the command with it at the n-th call."""
        cells = []
        for fault, faulty in faults.items():
            outcomes = collections.Counter()
            for number in tried:
                job.fresh(place)
                status, errors = faulty(number)
                outcome, wrong = judge(job, call, place, underbrush, expected, status, errors)
                outcomes[outcome] += 1
                if fault == "nothing" and outcome != "success, whole":
                    wrong.append(f"{outcome} without an error: {errors.strip()[:300]}")
                complaints.add(f"{job.name}, {fault} at {name} {number}", wrong)
            cells.append(summary(outcomes))
        print(f"| {job.name} | {name} | {len(tried)} | " + " | ".join(cells + [""] * (len(AFTER_CUT) - len(cells))) + " |", flush=True)

    def failing(call, injected):
        trace = [*STRACE, "-o", "/dev/null", "-e", f"trace={call}"]
        return lambda number: run([*trace, "-e", f"inject={call}:{injected}:when={number}", *job.command], place)

    def cutting(then):
        return lambda number: run(job.command, place, **cut(library, "write", number, then))

    for call, numbers in points.items():
        tried = numbers[:: every if call == "write" else 1]
        row(call, call, tried, {fault: failing(call, injected) for fault, injected in FAULTS.items()})
    tried = range(1, job.writes + 1, every)
    row("write", "write, cut short", tried, {fault: cutting(then) for fault, then in AFTER_CUT.items()})


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--underbrush", default=os.path.join(ROOT, "target/release/underbrush"))
    parser.add_argument("--every", type=int, default=1, metavar="N")
    parser.add_argument("--only", help="part of a command's name")
    options = parser.parse_args()
    underbrush = os.path.abspath(options.underbrush)
    complaints = Complaints()
    print("| command | call | tried | " + " | ".join(AFTER_CUT) + " |\n|---|---|---|" + "---|" * len(AFTER_CUT))
    with tempfile.TemporaryDirectory() as folder:
        library = compiled(folder)
        for job in jobs(underbrush, folder):
            if not options.only or options.only in job.name:
                try_all(job, underbrush, os.path.join(folder, "place"), library, options.every, complaints)
    print(f"{complaints.count} findings")
    sys.exit(1 if complaints.count else 0)


if __name__ == "__main__":
    main()
