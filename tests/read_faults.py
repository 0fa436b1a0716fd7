#!/usr/bin/env python3
"""Makes every system call that reads files of a set, a scene or a model fail once, in each command that reads them.

    python3 tests/read_faults.py [--underbrush target/release/underbrush] [--only COMMAND]

For each n, strace makes the n-th call of `openat` (for reading), `read`, `pread64`, `mmap`, `statx`, `getdents64`, …
fail with EIO, if the call is on a file in the folder of the command or on a scene file. One of these must hold; if
neither does, the script prints what is wrong and ends with exit status 1:

* an error: the exit status is 1 (2 would say that the input is bad), and the message names the file or its folder and
  says that it could not be read;
* success: what is printed and written is the same, byte for byte, as without the fault.

In both cases the inputs must be unchanged, and the same command without a fault (for sets, with --resume) must lead to
the same bytes. After that, for every n, the n-th `read` of all threads returns only half of what was asked for
(cut_short.c), and the command must succeed as usual.

Needs Linux, strace and a C compiler, but no Python packages; TMPDIR=/dev/shm makes it faster.
"""

import argparse
import collections
import errno
import glob
import os
import re
import subprocess
import sys
import tempfile

from faults import ROOT, SCENE, SECONDS, Complaints, Job, compiled, contents, cut, jobs, judge, summary

CALLS = ["openat", "read", "pread64", "mmap", "statx", "newfstatat", "lseek", "getdents64"]
# The calls that have a path as an argument.
WITH_PATH = ["openat", "statx", "newfstatat"]
SCENES = os.path.dirname(SCENE)


def path_of(call, line):
    """The path of the file that a line of `strace -y` names; None if it names none."""
    file = re.search(r"(?:\d+|AT_FDCWD)<(/[^>]*)>", line)
    named = re.search(r'"([^"]*)"', line) if call in WITH_PATH else None
    if not file:
        return None
    return os.path.join(file.group(1), named.group(1)) if named and named.group(1) else file.group(1)


class Reader:
    """Runs a command under strace, which lists its calls. Only calls on files in `folders` are tried."""

    def __init__(self, job, place, folders):
        self.job, self.place, self.folders = job, place, folders
        self.log = os.path.join(os.path.dirname(place), "calls")
        self.answer = None

    def run(self, prefix, variables):
        """Runs the command from a fresh start; returns exit status and standard error. Stores what it prints."""
        self.job.fresh(self.place)
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        command, env = [*prefix, *self.job.command], os.environ | variables
        done = subprocess.run(command, cwd=self.place, timeout=SECONDS, check=False, env=env, **pipes)
        self.answer = done.stdout
        return done.returncode, done.stderr.decode(errors="replace")

    def traced(self, *inject):
        """Runs the command under strace. Also returns each thread's calls: name, path, and the line of strace."""
        for old in glob.glob(f"{self.log}.*"):
            os.remove(old)
        # One file for each thread, so that no line is broken in two.
        status, errors = self.run(["strace", "-ff", "-y", "-o", self.log, "-e", f"trace={','.join(CALLS)}", *inject], {})
        threads = []
        for name in sorted(glob.glob(f"{self.log}.*")):
            with open(name, encoding="utf-8", errors="replace") as lines:
                found = [(re.match(r"(\w+)\(", line), line) for line in lines]
            calls = [(match.group(1), line) for match, line in found if match]
            threads.append([(call, path_of(call, line), line) for call, line in calls])
        return status, errors, threads

    def counts(self, path):
        """Whether calls on this file are tried."""
        return path is not None and any(path == folder or path.startswith(f"{folder}/") for folder in self.folders)

    def points(self, threads):
        """The calls to be tried: {call: sorted numbers}, counted from 1 in each thread, as strace counts."""
        points = collections.defaultdict(set)
        for calls in threads:
            numbers = collections.Counter()
            for call, path, line in calls:
                numbers[call] += 1
                if self.counts(path) and not re.search("O_WRONLY|O_RDWR|O_CREAT", line):
                    points[call].add(numbers[call])
        return {call: sorted(numbers) for call, numbers in sorted(points.items())}


def shown(path, place):
    """A path in the table: within the folder of the command, and without the random part of a temporary name."""
    if path.startswith(SCENES):
        return os.path.basename(path)
    return re.sub(r"[^/]*underbrush-unfinished[^/]*", "(temporary file)", os.path.relpath(path, place))


def said_wrong(status, errors, paths, out):
    """What is wrong with the error of a run that failed because of one of these files, or of `out` under its temporary name."""
    if status != 1:
        yield f"exit status {status}: {errors.strip()[:300]}"
    names = {os.path.basename(path) for path in paths} | {os.path.basename(os.path.dirname(path)) for path in paths}
    if any("underbrush-unfinished" in path for path in paths):
        names.add(out)
    if not any(name in errors for name in names):
        yield f"names none of {' '.join(sorted(names))}: {errors.strip()[:300]}"
    if os.strerror(errno.EIO) not in errors:
        yield f"does not say what failed: {errors.strip()[:300]}"


def try_all(reader, underbrush, library, complaints):
    """Makes each call of a command fail, and prints a row for each kind of call."""
    job, place = reader.job, reader.place
    status, errors, threads = reader.traced()
    if status != 0:
        sys.exit(f"{job.name} without a fault: {errors}")
    # The summary of a new set is not compared, because it has the time that the run took.
    expected, answer = job.whole(place), None if job.is_set else reader.answer
    before = [contents(folder) for folder in reader.folders if folder != place]
    reads = sum(call == "read" for calls in threads for call, _, _ in calls)

    def judged(where, status, errors):
        outcome, wrong = judge(job, "read", place, underbrush, expected, status, errors)
        if status == 0 and answer is not None and reader.answer != answer:
            wrong.append("another answer, and success")
        complaints.add(where, wrong)
        return outcome

    for call, numbers in reader.points(threads).items():
        outcomes, ignored = collections.Counter(), collections.Counter()
        for number in numbers:
            status, errors, threads = reader.traced("-e", f"inject={call}:error=EIO:when={number}")
            paths = {path for calls in threads for _, path, line in calls if "(INJECTED)" in line and path}
            where = f"{job.name}, EIO at {call} {number}, {' '.join(sorted(paths))}"
            if status == 0:
                ignored.update(shown(path, place) for path in paths)
            elif any(map(reader.counts, paths)):
                complaints.add(where, said_wrong(status, errors, paths, job.out))
            outcomes[judged(where, status, errors)] += 1
        does_not_matter = ", ".join(f"{count} {path}" for path, count in sorted(ignored.items()))
        print(f"| {job.name} | {call} | {len(numbers)} | {summary(outcomes)} | {does_not_matter} |", flush=True)
    outcomes = collections.Counter()
    for number in range(1, reads + 1):
        status, errors = reader.run([], cut(library, "read", number, "nothing"))
        if status != 0:
            complaints.add(f"{job.name}, read {number} cut short", [errors.strip()[:300]])
        outcomes[judged(f"{job.name}, read {number} cut short", status, errors)] += 1
    print(f"| {job.name} | read, cut short | {reads} | {summary(outcomes)} | |", flush=True)
    if before != [contents(folder) for folder in reader.folders if folder != place]:
        complaints.add(job.name, ["the inputs have changed"])


def readers(underbrush, folder):
    """All commands of faults.py, and those that only read a set."""
    made = jobs(underbrush, folder)
    whole, model = os.path.join(folder, "whole"), os.path.join(folder, "model.json")
    subprocess.run([underbrush, "train", whole, "--out", model], check=True, stdout=subprocess.DEVNULL)
    others = {
        "inspect": ([underbrush, "inspect", whole], "none"),
        "inspect of a scene": ([underbrush, "inspect", SCENE], "none"),
        "train": ([underbrush, "train", whole, "--out", "own.json"], "own.json"),
        "classify": ([underbrush, "classify", model, whole], "none"),
        "replay to a file": ([underbrush, "replay", whole, "--model", model, "--out", "page.html"], "page.html"),
    }

    def other(name, command, out):
        again = command if out == "none" else [*command, "--force"]
        return Job(name, command, out, again=again, is_set=False)

    return [*made, *(other(name, *what) for name, what in others.items())]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--underbrush", default=os.path.join(ROOT, "target/release/underbrush"))
    parser.add_argument("--only", help="part of a command's name")
    options = parser.parse_args()
    underbrush = os.path.abspath(options.underbrush)
    complaints = Complaints()
    print("| command | call | tried | outcomes | calls without consequence |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        library = compiled(folder)
        place = os.path.join(folder, "place")
        made = readers(underbrush, folder)
        folders = [place, SCENES, *(os.path.join(folder, name) for name in ("parts", "whole", "model.json"))]
        for job in made:
            if not options.only or options.only in job.name:
                try_all(Reader(job, place, folders), underbrush, library, complaints)
    print(f"{complaints.count} findings")
    sys.exit(1 if complaints.count else 0)


if __name__ == "__main__":
    main()
