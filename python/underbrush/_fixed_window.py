"""Makes scikit-learn's classifiers usable where underbrush expects its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.base import clone

from . import _core
from ._errors import whole


class FixedWindow:
    """Any scikit-learn classifier, for use where underbrush expects its own: in ``evaluate`` and in online streams.

    It sees the first ``samples`` samples of a trial as one row. Shorter trials, and contacts in progress, are padded
    with their last sample.

    Parameters
    ----------
    estimator : classifier
        A classifier with ``fit``, and with ``predict_proba`` or ``predict``.
    samples : int
        Length of the window.
    features : str or list of str
        Features of each sample.
    """

    def __init__(self, estimator: Any, samples: int = 20, features: str | Sequence[str] = "force") -> None:
        self.estimator = estimator
        self.samples = samples
        self.features = features
        self.categories: list[str] = []

    def _rows(self, trials: _core.Trials) -> NDArray[np.float64]:
        samples = whole("samples", self.samples, 1)
        rows = []
        for sequence in trials.sequences(self.features):
            window = sequence[:samples]
            missing = samples - len(window)
            rows.append(np.concatenate([window, np.repeat(window[-1:], missing, axis=0)]).ravel())
        return np.asarray(rows)

    def fit_trials(self, trials: _core.Trials) -> FixedWindow:
        """Return a copy that is fitted to trials with categories. Blocks and outliers are left out."""
        names = trials.categories
        kept = [place for place, name in enumerate(names) if name is not None and name not in ("block", "outlier")]
        chosen = trials[kept]
        fitted = FixedWindow(clone(self.estimator), self.samples, self.features)
        fitted.estimator.fit(fitted._rows(chosen), np.asarray(chosen.categories))
        fitted.categories = [str(name) for name in fitted.estimator.classes_]
        return fitted

    def scores(self, trials: _core.Trials) -> NDArray[np.float64]:
        """Logarithm of the probability of each category: (trials, categories)."""
        rows = self._rows(trials)
        if hasattr(self.estimator, "predict_proba"):
            chances = self.estimator.predict_proba(rows)
        else:
            found = self.estimator.predict(rows)
            chances = (found[:, np.newaxis] == np.asarray(self.categories)).astype(float)
        with np.errstate(divide="ignore"):
            return np.log(np.asarray(chances, np.float64))


FixedWindow.__module__ = "underbrush.sklearn"
