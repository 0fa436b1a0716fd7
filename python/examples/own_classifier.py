"""Classifiers of scikit-learn beside those of underbrush: in an evaluation with whole reaches held out, and online."""

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from sklearn.ensemble import RandomForestClassifier
from sklearn.model_selection import GroupKFold, cross_val_score

import underbrush as ub
from underbrush.sklearn import FixedWindow, HiddenMarkovClassifier

data = ub.generate(["leaf", "trunk"], reaches=6, out=Path(tempfile.mkdtemp()) / "data", seed=1)
trials = data.trials(labels="environment", min_samples=20)

# %%
# A scikit-learn classifier, evaluated with the folds, baselines and intervals of underbrush.
def forest(samples: int) -> FixedWindow:
    """A random forest on the first samples of each trial, 100 a second. Both categories weigh the same, because most trials are of leaf."""
    return FixedWindow(RandomForestClassifier(100, random_state=0, class_weight="balanced", min_samples_leaf=5), samples)


compared: list[tuple[str, ub.Options | FixedWindow]] = [("hidden Markov models", ub.Options()), ("random forest", forest(20))]
for name, classifier in compared:
    found = ub.evaluate(trials, classifier, group="reach")
    print(f"{name}: accuracy {found['accuracy']:.3f}, balanced {found['balanced_accuracy']:.3f}")

# %%
# How long the forest must feel a contact.
lengths = [1, 2, 5, 10, 20, 50]
balanced = [ub.evaluate(trials, forest(samples), group="reach")["balanced_accuracy"] for samples in lengths]
whole = ub.evaluate(trials, ub.Options(), group="reach")["balanced_accuracy"]
figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
axes.plot([10 * samples for samples in lengths], balanced, "o-", label="random forest")
axes.axhline(whole, color="tab:orange", linestyle="--", label="hidden Markov models, whole contact")
axes.axhline(0.5, color="tab:gray", linestyle=":", label="guessing")
axes.set(xlabel="time since the contact began / ms", ylabel="balanced accuracy", ylim=(0.4, 0.8))
axes.legend()
plt.show()

# %%
# A classifier of underbrush as an estimator of scikit-learn.
rows, y, groups = trials.padded(samples=100), np.array(trials.categories), np.array(trials.reaches)
print(cross_val_score(HiddenMarkovClassifier(states=5), rows, y, groups=groups, cv=GroupKFold(2)))

# %%
# A verdict in every frame, from the forest.
online = ub.online(forest(20).fit_trials(trials), data.skin, "forearm")
reach = data[0]
verdicts = [own["verdict"] for index in range(len(reach)) for own in online.update(reach.frame(index))]
print({name: verdicts.count(name) for name in sorted(set(verdicts))})
assert verdicts
