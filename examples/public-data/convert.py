#!/usr/bin/env python3
"""Makes a table of trials from a public data set of a real robot. It needs Python 3.9 or later and no packages.

    python3 convert.py failures lp4.data lp4.csv
    python3 convert.py grasps iCubGraspDataset grasps.csv
    python3 convert.py slides compiled_data slides.csv

Nothing is downloaded. If the data are not there, it says where to get them.
"""

import argparse
import ast
import array
import csv
import hashlib
import sys
from pathlib import Path

FINGERS = ("thumb", "index", "middle", "ring", "little")
OBJECTS = (
    "blue_bear book empty_coke empty_vitamin_water full_vitamin_water lotion med_coke med_vitamin_water monkey_toy none"
).split()


class Reader:
    """Reads files of a set and keeps their common checksum."""

    def __init__(self) -> None:
        self.sha256 = hashlib.sha256()

    def __call__(self, path: Path) -> bytes:
        content = path.read_bytes()
        self.sha256.update(content)
        return content


def failures(path: Path, read: Reader):
    """The wrench at a gripper, 15 samples in 315 ms: a line with the category, then lines of three forces and torques."""
    trials = []
    for line in read(path).decode("ascii").splitlines():
        words = line.split()
        if len(words) == 1:
            trials.append((words[0], []))
        elif len(words) == 6:
            force = sum(float(word) ** 2 for word in words[:3]) ** 0.5
            trials[-1][1].append([f"{force:.4f}", *words])
    return ["fx", "fy", "fz", "tx", "ty", "tz"], 0.021, trials


def grasps(folder: Path, read: Reader):
    """A hand closes on an object. Each fingertip has 12 taxels; what counts is by how much they rose since the first
    sample of the grasp. Their readings in that sample differ from object to object, before the touch tells anything."""
    trials = []
    for name in OBJECTS:
        for number in range(1, 21):
            lines = read(folder / f"{name}_{number}.txt").decode("ascii").splitlines()
            lines = [line.split() for line in lines[1:] if line.strip()]
            # Of the seven lines of a sample the last five are the fingers. A taxel reads less the harder it is pressed.
            fingers_at = [lines[at + 2 : at + 7] for at in range(0, len(lines), 7)]
            readings = [[[-float(word) for word in finger] for finger in fingers] for fingers in fingers_at]
            rows = []
            for sample in readings:
                fingers = [[a - b for a, b in zip(*pair)] for pair in zip(sample, readings[0])]
                row = [number for finger in fingers for number in (sum(finger) / len(finger), max(finger))]
                rows.append([f"{max(0, *map(max, fingers)):.4g}", *(f"{number:.4g}" for number in row)])
            trials.append((name, rows))
    return [f"{finger}_{what}" for finger in FINGERS for what in ("mean", "max")], 0.1, trials


def numbers(content: bytes, kind: str) -> array.array:
    """The numbers of a NumPy file of version 1, in their order."""
    end = 10 + int.from_bytes(content[8:10], "little")
    header = ast.literal_eval(content[10:end].decode("latin-1"))
    if header["descr"] != {"f": "<f4", "q": "<i8"}[kind] or header["fortran_order"]:
        raise ValueError(f"not the expected kind of numbers: {header}")
    return array.array(kind, content[end:])


def slides(folder: Path, read: Reader):
    """A skin of 60 taxels slides over a material for 1.5 s. The files are declared as 6 x 10 x 75 numbers for each slide,
    but read like that a taxel jumps by 7 units from sample to sample. What stands there are six parts of ten blocks, and
    the parts of a block joined are 75 samples of 6 taxels. So read, a taxel changes by 0.2 units. `pressed` is the number
    of taxels above 5 units, a choice."""
    trials = []
    for part in ("val_0", "val_1", "val_2", "val_3", "test"):
        values = numbers(read(folder / f"icub_{part}.npy"), "f")
        labels = numbers(read(folder / f"labels_{part}.npy"), "q")
        for slide, label in enumerate(labels):
            own = values[4500 * slide : 4500 * (slide + 1)]
            at = [[75 * (10 * sixth + block) for sixth in range(6)] for block in range(10)]
            blocks = [[number for start in starts for number in own[start : start + 75]] for starts in at]
            rows = []
            for frame in range(0, 450, 6):
                taxels = [block[frame : frame + 6] for block in blocks]
                sums = [sum(map(sum, taxels)), *map(sum, taxels), *map(sum, zip(*taxels))]
                pressed = sum(number > 5 for row in taxels for number in row)
                rows.append([f"{number:.4g}" for number in (max(map(max, taxels)), pressed, *sums)])
            trials.append((f"mat{label + 1}", rows))
    channels = ["pressed", "sum", *(f"row_{row}" for row in range(10)), *(f"column_{column}" for column in range(6))]
    return channels, 0.02, trials


# Of each set: how it is read, where it is, its licence, whom to cite, and the SHA-256 of all that is read, joined.
SETS = {
    "failures": (
        failures,
        "Robot Execution Failures: https://archive.ics.uci.edu/dataset/138/robot+execution+failures (lp1.data to "
        "lp5.data)",
        "CC BY 4.0, https://creativecommons.org/licenses/by/4.0/",
        "L. Seabra Lopes, L. M. Camarinha-Matos: Robot Execution Failures, UCI Machine Learning Repository, 1999",
        {
            "57f68e2513daa1a65c7a316386dac2e4de56439da01ab844827ec1156aa0866f",  # lp4.data
            "3b76b63eb5368d53b1d977c89ab11a2cf0674731c3d717b225e5c239d344b4fb",  # lp5.data
        },
    ),
    "grasps": (
        grasps,
        "iCub Grasp Dataset: https://github.com/clear-nus/icub_grasp_dataset (folder iCubGraspDataset)",
        "Copyright 2012 Harold Soh. Free to use and distribute as long as the copyright information is kept",
        "H. Soh, Y. Su, Y. Demiris: Online Spatio-Temporal Gaussian Process Experts with Application to Tactile "
        "Classification, IROS 2012",
        {"124a77664a33a0f66cf7a262f4f9c1cc7826ec3edc9ec991d4b5fe78468cf2e7"},
    ),
    "slides": (
        slides,
        "iCub slides over 20 materials: https://github.com/dexrob/BioTac_slide_20_50 (folder compiled_data: "
        "icub_val_0.npy to icub_val_3.npy, icub_test.npy, and labels_ of the same names)",
        "None is stated, so no part of it is here",
        "R. Gao, T. Taunyazov, Z. Lin, Y. Wu: Supervised Autoencoder Joint Learning on Heterogeneous Tactile Sensory "
        "Data: Improving Material Classification Performance, IROS 2020",
        {"fa4fa48c1d03462cabb28a49456cd3e99bc5cc3c858a8793b1e3f0345b221851"},
    ),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("set", choices=SETS)
    parser.add_argument("data", type=Path, help="file or folder of the set")
    parser.add_argument("out", type=Path, help="table of trials to write (.csv)")
    parser.add_argument("--first", type=int, help="only so many trials of each category", metavar="N")
    options = parser.parse_args()
    reader, where, licence, citation, known = SETS[options.set]
    read = Reader()
    source = f"Get the data from\n  {where}\nLicence: {licence}\nCite: {citation}"
    try:
        channels, interval_s, trials = reader(options.data, read)
    except OSError as error:
        sys.exit(f"{error}\n{source}")
    except (IndexError, ValueError) as error:
        sys.exit(f"{options.data} is not of this set: {error}\n{source}")
    if not trials or not all(samples for _, samples in trials):
        sys.exit(f"{options.data} is not of this set: a trial has no samples\n{source}")
    if read.sha256.hexdigest() not in known:
        note = f"note: these are not the files that the guide's figures are from (SHA-256 {read.sha256.hexdigest()})"
        print(note, file=sys.stderr)
    written: dict[str, int] = {}
    with options.out.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["trial", "category", "time_s", "force_n", *channels])
        for trial, (category, rows) in enumerate(trials):
            if options.first is None or written.get(category, 0) < options.first:
                written[category] = written.get(category, 0) + 1
                table.writerows([trial, category, f"{index * interval_s:.3f}", *row] for index, row in enumerate(rows))
    print(f"{options.out}: {', '.join(f'{count} {category}' for category, count in written.items())}")
    print("--features force," + ",".join(f"column:{channel}" for channel in channels))


if __name__ == "__main__":
    main()
