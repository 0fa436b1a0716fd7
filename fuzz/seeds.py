#!/usr/bin/env python3
"""Makes the seeds of the fuzz targets with the program itself: one small valid file of each kind, in corpus/ and set/.

    python3 fuzz/seeds.py [--underbrush target/release/underbrush]

Run it again when a format changes. It replaces what it wrote before and keeps the other files of the corpus, which fuzzing
has found.
"""

import argparse
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)

MAPPINGS = {
    "csv.toml": """[time]
from = "stamp"
unit = "ms"
[force]
from = "ft_{taxel}"
taxels = 2
unit = "mN"
[trial]
patch = "palm"
threshold_n = 0.1
category_from = "label"
reach_from = "run"
""",
}

PALM = """run, stamp, left, ft_0, ft_1, label
0, 1000, x, 0, 500, leaf
0, 1010, x, 250, 500, leaf
0, 1030, x, 0, 125, leaf

1, 1000, x, 40, 125, trunk
"""

SUITE = """summary = "One scene"
seed = 5

[[scenes]]
scene = "thicket.toml"
reaches = 2

[scenes.bounds]
audit = { at_most = 1, blessed = 0.8 }
goals_reached = { at_least = 0.5 }
peak_force_n.trunk = { at_least = 0.1, at_most = 0.8 }
"""

EXPERIMENT = """title = "One scene"
introduction = "Trunks."
states = [2]
recipes = ["modern"]
truncations = [10]

[[training]]
scene = "thicket.toml"
label = "trunk"
reaches = 2

[[training]]
scene = "grove.toml"
label = "leaf"
reaches = 2

[trials]
min_samples = 2

[[classifiers]]
name = "logistic regression"
method = "logistic"
features = ["force"]

[[settings]]
name = "half speed"
robot = { stiffness_scale = 1.0, hand_speed_scale = 0.5 }

[[setting_classifiers]]
name = "logistic regression"
method = "logistic"
features = ["force"]
"""

FRAME = {
    "time_s": 0.01,
    "taxels": [{"patch": "sleeve", "taxel": 0, "sensed_force_n": 0.25}, {"patch": 0, "taxel": 4, "sensed_force_n": 3}],
    "patch_pose_world": {"sleeve": {"position": [0.1, 0, 0], "orientation": [0, 0, 0, 1]}},
}


def trials():
    """A table of trials: force alone, two categories."""
    rows = ["trial,category,time_s,force_n"]
    for trial in range(8):
        category = ["leaf", "trunk"][trial % 2]
        for sample in range(12):
            force_n = (1 + 4 * (trial % 2)) * math.sin(0.2 * sample + 0.1) + 0.01 * trial
            rows.append(f"{trial},{category},{0.01 * sample:.2f},{force_n:.4f}")
    return "\n".join(rows) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--underbrush", default=os.path.join(ROOT, "target/release/underbrush"))
    underbrush = os.path.abspath(parser.parse_args().underbrush)

    def run(*arguments):
        subprocess.run([underbrush, *arguments], check=True, stdout=subprocess.DEVNULL)

    def seed(target, name, contents):
        """Writes a file of the corpus."""
        folder = os.path.join(HERE, "corpus", target)
        os.makedirs(folder, exist_ok=True)
        with open(os.path.join(folder, name), "wb") as file:
            file.write(contents.encode() if isinstance(contents, str) else contents)

    def read(path):
        with open(path, "rb") as file:
            return file.read()

    own = os.path.join(HERE, "seeds")
    thicket = os.path.join(own, "thicket.toml")
    for name in ["wedge.obj", "wedge.dae"]:
        seed("mesh", name, read(os.path.join(own, name)))
    for target, name in [("arm", "finger.toml"), ("urdf", "finger.urdf"), ("skin", "finger.skin.toml")]:
        seed(target, name, read(os.path.join(own, name)))
    seed("skin", "cody.skin.toml", read(os.path.join(ROOT, "sim/arms/cody/cody.skin.toml")))
    seed("scene", "thicket.toml", read(thicket))
    for scene in ["leaf", "bottle", "outlier"]:
        seed("scene", f"{scene}.toml", read(os.path.join(ROOT, f"scenes/{scene}.toml")))
    seed("suite", "one.toml", SUITE)
    seed("experiment", "one.toml", EXPERIMENT)
    seed("import_csv", "palm.csv", PALM)
    for name, text in MAPPINGS.items():
        seed("mapping", name, text)
    later = {**FRAME, "time_s": 0.02, "taxels": []}
    lines = [json.dumps(line) for line in [FRAME, later, {"reset": True}, FRAME]]
    seed("frame_lines", "four.jsonl", "\n".join(lines) + "\n")

    with tempfile.TemporaryDirectory() as folder:
        table = os.path.join(folder, "trials.csv")
        with open(table, "w", encoding="utf-8") as file:
            file.write(trials())
        seed("trials_csv", "force.csv", trials())
        for classifier in ["hmm", "naive-bayes", "logistic-taxel", "nearest-neighbours"]:
            model = os.path.join(folder, f"{classifier}.json")
            states = ["--states", "2"] if classifier == "hmm" else []
            run("train", table, "--classifier", classifier, "--features", "force", *states, "--out", model)
            seed("model", f"{classifier}.json", read(model))
        reach = os.path.join(folder, "reach.parquet")
        run("reach", thicket, "--seed", "5", "--out", reach)
        seed("recording", "reach.parquet", read(reach))
        for name in ["trials.parquet", "trials.csv"]:
            path = os.path.join(folder, f"of-reach-{name}")
            run("trials", reach, "--min-samples", "1", "--out", path)
            seed(name.replace(".", "_"), f"reach.{name.split('.')[1]}", read(path))
        whole = os.path.join(folder, "set")
        run("generate", thicket, "--reaches", "1", "--seed", "5", "--out", whole)
        files = [os.path.join(place, name) for place, _, names in os.walk(whole) for name in names]
        names = sorted(os.path.relpath(path, whole).replace(os.sep, "/") for path in files)
        names.remove("meta/checksums.json")
        shutil.rmtree(os.path.join(HERE, "set"), ignore_errors=True)
        for number, name in enumerate(names):
            target = os.path.join(HERE, "set", name)
            os.makedirs(os.path.dirname(target), exist_ok=True)
            contents = read(os.path.join(whole, name))
            with open(target, "wb") as file:
                file.write(contents)
            seed("data_set", name.replace("/", "-"), bytes([number]) + contents)
        print("\n".join(names))


if __name__ == "__main__":
    main()
