"""What 20 % of each constant does to contacts and verdicts: which of them a lab should measure first.

    cargo build --release
    python3 benches/sensitivity.py --reaches 16 --seed 7100

Simulates the same reaches of `leaf` and `trunk`, object by object and goal by goal, with each constant 20 % larger and 20 %
smaller. Prints, as a table in Markdown, the change from the smaller to the larger value of: peak force of a trial (median of
leaf and of trunk), time from contact to 63 % of the peak (trials above 0.3 N), length and number of trials, and the balanced
accuracy of a model that was trained on other reaches with the constants as they ship. The last row is the standard error of a
change by chance: the reaches are divided into four groups, and the changes of the groups are compared.
"""

import argparse
import csv
import json
import re
import statistics
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target/release/underbrush"
SHARE = 0.2
GROUPS = 4

SENSOR = {"crosstalk_share": 0.03, "creep_share_per_decade": 0.05, "spurious_share": 2 / 384, "noise_n": 0.002}
LEAF = {
    "flexural_rigidity_n_m2": (0.005, 0.05),
    "mass_per_area_kg_per_m2": (0.5, 1.0),
    "loss_factor": (0.1, 0.2),
    "width_m": (0.02, 0.05),
    "root_depth_m": (0.03, 0.05),
}
ROBOT = ["stiffness_scale", "hand_speed_scale", "force_limit_scale"]
MATERIALS = ["skin_modulus_n_per_m3", "skin_thickness_m", "skin_loss_time_s", "arm_friction", "object_friction"]


def run(*arguments):
    """Runs the program and returns its JSON result."""
    done = subprocess.run([PROGRAM, *map(str, arguments), "--json"], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    return json.loads(done.stdout)


def material_values():
    """The values of sim/materials.toml."""
    text = (ROOT / "sim/materials.toml").read_text()
    return {name: float(value) for name, value in re.findall(r"\[(\w+)\]\nvalue = (\S+)", text)}


def changed(name, factor):
    """Lines to add to a scene, and to its group of leaves, so that a constant has this share of its value."""
    if name in MATERIALS:
        return f"[materials]\n{name} = {material_values()[name] * factor}\n", ""
    if name in SENSOR:
        return f"[sensor]\n{name} = {SENSOR[name] * factor}\n", ""
    if name in ROBOT:
        return f"[robot]\n{name} = {factor}\n", ""
    low, high = (bound * factor for bound in LEAF[name])
    return "", f"{name} = {{ uniform = [{low}, {high}] }}\n"


def simulate(folder, options, seed, name=None, factor=1.0):
    """The data set of both scenes with a constant at this share of its value."""
    section, leaf = changed(name, factor) if name else ("", "")
    scenes = []
    # The name of a scene file is part of its seed.
    for scene in ("leaf", "trunk"):
        text = (ROOT / f"scenes/{scene}.toml").read_text()
        path = folder / f"{scene}.toml"
        path.write_text(text.replace("[[objects.leaf]]\n", "[[objects.leaf]]\n" + leaf) + "\n" + section)
        scenes.append(path)
    out = folder / f"set-{seed}-{name}-{factor}"
    run("generate", *scenes, "--reaches", options.reaches, "--seed", seed, "--out", out)
    return out


def trials(data):
    """Reach, category, and rows of each trial that an object touched."""
    table = data.with_suffix(".csv")
    run("trials", data, "--out", table)
    found = {}
    with table.open() as rows:
        for row in csv.DictReader(rows):
            trial = found.setdefault(row["trial"], (int(row["reach"]), row["category"], []))
            trial[2].append((float(row["time_s"]), float(row["force_n"]), row["touched"] == "true"))
    return [trial for trial in found.values() if any(touched for _, _, touched in trial[2])]


def figures(found, predictions):
    """The figures of some trials, by name."""
    figures = {}
    for category in ("leaf", "trunk"):
        own = [rows for _, truth, rows in found if truth == category]
        peaks = [max(force for _, force, _ in rows) for rows in own]
        firm = [rows for rows, peak in zip(own, peaks) if peak > 0.3]
        rises = [next(at for at, force, _ in rows if force >= 0.63 * max(force for _, force, _ in rows)) for rows in firm]
        figures[f"peak {category}"] = statistics.median(peaks)
        figures[f"rise {category}"] = statistics.median(rise - rows[0][0] + 0.01 for rise, rows in zip(rises, firm))
        figures[f"length {category}"] = statistics.median(rows[-1][0] - rows[0][0] + 0.01 for rows in own)
        figures[f"trials {category}"] = len(own)
    recalls = [
        statistics.mean(verdict == category for _, truth, verdict in predictions if truth == category)
        for category in ("leaf", "trunk")
    ]
    figures["balanced"] = 100 * statistics.mean(recalls)
    return figures


def judged(model, data):
    """Reach, truth and verdict of each touched trial."""
    predictions = run("evaluate", data, "--model", model)["predictions"]
    return [(own["reach"], own["category"], own["verdict"].get("category")) for own in predictions if own["touched"]]


def change(name, small, large):
    """From the smaller to the larger value: points of accuracy, else percent of the mean."""
    if name == "balanced":
        return large - small
    return 100 * (large - small) / (0.5 * (large + small))


def main():
    """Simulates and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--reaches", type=int, default=16, help="reaches per scene (default 16)")
    parser.add_argument("--seed", type=int, default=7100, help="seed of the reaches; the model's is one more")
    constants = [*MATERIALS, *ROBOT, *LEAF, *SENSOR]
    parser.add_argument("--only", nargs="+", choices=constants, default=constants, help="these constants alone")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        model = folder / "model.json"
        run("train", simulate(folder, options, options.seed + 1), "--classifier", "logistic", "--out", model)
        names, by_chance = None, []
        for constant in options.only:
            sides = []
            for factor in (1 - SHARE, 1 + SHARE):
                data = simulate(folder, options, options.seed, constant, factor)
                sides.append((trials(data), judged(model, data)))
            if names is None:
                names = list(figures(*sides[0]))
                print("| constant | " + " | ".join(names) + " |")
                print("|---" * (len(names) + 1) + "|")
            small, large = (figures(*side) for side in sides)
            cells = [change(name, small[name], large[name]) for name in names]
            print(f"| {constant} | " + " | ".join(f"{cell:+.0f}" for cell in cells) + " |", flush=True)
            groups = []
            for group in range(GROUPS):
                try:
                    mine = [figures(*[[row for row in rows if row[0] % GROUPS == group] for rows in side]) for side in sides]
                except statistics.StatisticsError:
                    continue  # A category without trials in this group.
                groups.append([change(name, mine[0][name], mine[1][name]) for name in names])
            if len(groups) > 1:
                by_chance.append([statistics.variance(column) / len(groups) for column in zip(*groups)])
        errors = [statistics.mean(column) ** 0.5 for column in zip(*by_chance)]
        print("| standard error | " + " | ".join(f"{error:.0f}" for error in errors) + " |")


if __name__ == "__main__":
    main()
