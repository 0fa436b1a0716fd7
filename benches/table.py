"""Prints what `cargo bench` measured last as one table.

    cargo bench && python benches/table.py [target/criterion]

Simulated seconds per second are frames of 10 ms divided by wall time. If the machine has other work, the quickest
sample says more than the median.
"""

import json
import pathlib
import subprocess
import sys

# Benches whose elements are frames of 10 ms.
FRAMES = ("foliage", "reach", "campaign")
FRAME_S = 0.01
# Control steps per simulated second with the default preset of scenes.
CONTROL_RATE_HZ = 25


def criterion_folder():
    if len(sys.argv) > 1:
        return pathlib.Path(sys.argv[1])
    metadata = subprocess.run(["cargo", "metadata", "--format-version", "1", "--no-deps"], check=True,
                              stdout=subprocess.PIPE)
    return pathlib.Path(json.loads(metadata.stdout)["target_directory"]) / "criterion"


def results(folder):
    """Name, elements of one iteration, median and quickest time of one iteration, s."""
    for path in folder.glob("**/new/benchmark.json"):
        described = json.loads(path.read_text())
        sample = json.loads((path.parent / "sample.json").read_text())
        times = sorted(time / count * 1e-9 for time, count in zip(sample["times"], sample["iters"]))
        elements = (described.get("throughput") or {}).get("Elements")
        yield described["full_id"], elements, times[len(times) // 2], times[0]


def duration(seconds):
    for unit, size in (("s", 1), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def main():
    folder = criterion_folder()
    # Sorts numbers in names by their value: 24 leaves before 384.
    found = sorted(results(folder), key=lambda result: [(not part.isdigit(), int(part) if part.isdigit() else 0, part)
                                                        for part in result[0].split("/")])
    if not found:
        sys.exit(f"no results in {folder}: run `cargo bench` first")
    print("| bench | median | quickest | simulated s/s, median | quickest |\n|---|---|---|---|---|")
    speeds, times = {}, {}
    for name, elements, median, quickest in found:
        speed = ["", ""]
        if name.split("/")[0] in FRAMES and elements:
            speeds[name] = elements * FRAME_S / quickest
            speed = [f"{elements * FRAME_S / time:.1f}" for time in (median, quickest)]
        times[name] = quickest
        print(f"| {name} | {duration(median)} | {duration(quickest)} | {' | '.join(speed)} |")
    few, many = speeds.get("foliage/physics/24"), speeds.get("foliage/physics/384")
    if few and many:
        print(f"\nA step with 384 leaves costs {few / many:.2f} times that with 24, as many of them in touch.")
    control = times.get("controller/step/cody-2013")
    for name, speed in speeds.items():
        if control and name.startswith("reach/"):
            print(f"The controller takes {control * CONTROL_RATE_HZ * speed:.1%} of {name}, were ten taxels always in touch.")


if __name__ == "__main__":
    main()
