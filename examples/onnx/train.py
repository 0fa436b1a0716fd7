"""Train a network with scikit-learn on trials of underbrush and export it for underbrush as ONNX.

    underbrush generate scenes/leaf.toml scenes/trunk.toml --reaches 10 --out data
    underbrush trials data --out trials.csv
    python examples/onnx/train.py trials.csv network.onnx
    cargo run --release --features onnx -- evaluate other-trials.csv --model network.onnx

Needs numpy, scikit-learn, skl2onnx and onnx from PyPI.
"""

import csv
import sys

import numpy as np
import onnx
import onnx.utils
from skl2onnx import to_onnx
from sklearn.neural_network import MLPClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

# Names of features as in `underbrush train --features`, and their columns in the table of trials.
FEATURES = {"force": "force_n", "motion": "motion_m"}
WINDOW = 20
# The network learns to judge contacts of these lengths too; each is padded with its last sample.
LENGTHS = (1, 5, 10, WINDOW)

trials: dict[str, list[list[float]]] = {}
category: dict[str, str] = {}
with open(sys.argv[1], newline="") as file:
    for row in csv.DictReader(file):
        if row["category"] in ("leaf", "trunk"):
            trials.setdefault(row["trial"], []).append([float(row[column]) for column in FEATURES.values()])
            category[row["trial"]] = row["category"]


def window(samples: list[list[float]], length: int) -> np.ndarray:
    """The first samples of a trial, padded with the last one of them, as one row."""
    kept = samples[:length]
    return np.array(kept + [kept[-1]] * (WINDOW - len(kept))).ravel()


rows = np.array([window(samples, length) for samples in trials.values() for length in LENGTHS], dtype=np.float32)
labels = np.array([category[trial] for trial in trials for _ in LENGTHS])
model = make_pipeline(StandardScaler(), MLPClassifier((32,), alpha=1e-2, early_stopping=True, random_state=0))
model.fit(rows, labels)

# rten, which runs the model, knows the standard operators, but not the machine-learning ones, and no texts, such as labels.
exported = to_onnx(model, rows[:1], options={"zipmap": False}, black_op={"Scaler"})
exported = onnx.utils.Extractor(exported).extract_model([exported.graph.input[0].name], ["probabilities"])
metadata = {
    "underbrush.features": ",".join(FEATURES),
    "underbrush.window": str(WINDOW),
    "underbrush.categories": ",".join(model.classes_),
}
onnx.helper.set_model_props(exported, metadata)
onnx.save(exported, sys.argv[2])
print(f"{len(trials)} trials; accuracy on the rows that it was fitted to: {model.score(rows, labels):.3f}")
