"""Classifiers of scikit-learn beside those of underbrush: in an evaluation with whole reaches held out, and online."""

# %%
import tempfile
from pathlib import Path

import numpy as np
from sklearn.ensemble import RandomForestClassifier
from sklearn.model_selection import GroupKFold, cross_val_score

import underbrush as ub
from underbrush.sklearn import FixedWindow, HiddenMarkovClassifier

data = ub.generate(["leaf", "trunk"], reaches=2, out=Path(tempfile.mkdtemp()) / "data", seed=1)
trials = data.trials(labels="environment", min_samples=20)

# %%
# A scikit-learn classifier, evaluated with the folds, baselines and intervals of underbrush.
forest = FixedWindow(RandomForestClassifier(100, random_state=0), samples=20)
compared: list[tuple[str, ub.Options | FixedWindow]] = [("hidden Markov models", ub.Options()), ("random forest", forest)]
for name, classifier in compared:
    found = ub.evaluate(trials, classifier, group="reach")
    print(f"{name}: accuracy {found['accuracy']:.3f}, balanced {found['balanced_accuracy']:.3f}")

# %%
# A classifier of underbrush as an estimator of scikit-learn.
rows, y, groups = trials.padded(samples=100), np.array(trials.categories), np.array(trials.reaches)
print(cross_val_score(HiddenMarkovClassifier(states=5), rows, y, groups=groups, cv=GroupKFold(2)))

# %%
# A verdict in every frame, from the forest.
online = ub.online(forest.fit_trials(trials), data.skin, "forearm")
reach = data[0]
verdicts = [own["verdict"] for index in range(len(reach)) for own in online.update(reach.frame(index))]
print({name: verdicts.count(name) for name in sorted(set(verdicts))})
assert verdicts
