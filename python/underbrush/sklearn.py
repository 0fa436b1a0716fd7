"""The classifiers as scikit-learn estimators.

``fit(X, y)`` takes rows of equal width: a trial is a row of forces, N, at 100 Hz, and NaN is a missing sample, such as the
padding of a shorter trial (:meth:`Trials.padded` makes such rows). Missing samples are left out, and later ones move up.
``fit_sequences`` takes arrays of unequal length with one or more features, and ``fit_trials`` takes trials. Scores are those
of the command line, bit for bit.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from . import _core
from ._fixed_window import FixedWindow
from ._train import fit as _fit

__all__ = [
    "EchoStateClassifier",
    "FixedWindow",
    "HiddenMarkovClassifier",
    "LogisticClassifier",
    "LogisticTaxelClassifier",
    "MiniRocketClassifier",
    "NaiveBayesClassifier",
    "PeakForceClassifier",
    "NearestNeighboursClassifier",
    "TreesClassifier",
]

# Blocks and outliers are never fitted, and "uncertain" is a verdict, so labels with these names get another name internally.
_MARK = "label "


def _inside(label: Any) -> str:
    name = str(label)
    return _MARK + name if name in ("block", "outlier", "uncertain") or name.startswith(_MARK) or not name else name


def _sequences(trials: Iterable[ArrayLike]) -> list[NDArray[np.float64]]:
    """The trials without their missing samples: in a sample of several features NaN is one of them."""
    found = []
    for number, trial in enumerate(trials):
        samples = np.asarray(trial, np.float64)
        kept = ~np.isnan(samples).any(axis=tuple(range(1, samples.ndim)))
        if not kept.any():
            raise ValueError(f"row {number} of X has no samples, or NaN only; a trial has at least one sample")
        found.append(samples[kept] if samples.ndim > 0 else samples)
    return found


def _are_sequences(X: Any) -> bool:
    """Whether these are trials of lengths of their own: arrays, or lists that are no rows of one matrix."""
    if not isinstance(X, (list, tuple)) and not (isinstance(X, np.ndarray) and X.dtype == object and X.ndim == 1):
        return False
    if len(X) == 0 or np.ndim(X[0]) == 0:
        return False
    return hasattr(X[0], "__array__") or np.ndim(X[0]) == 2 or len({np.shape(own) for own in X}) > 1


class _TrialClassifier(ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """What all estimators have in common."""

    _classifier: ClassVar[str]

    features: str | Sequence[str] | None

    def _options(self) -> dict[str, Any]:
        """The options of the classifier, from its parameters. `score_kind` is the option `score`, which is a method
        here."""
        options = dict(self.get_params(deep=False))
        if "score_kind" in options:
            options["score"] = options.pop("score_kind")
        return options

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        # Missing samples.
        tags.input_tags.allow_nan = True
        # scikit-learn's checks use clouds of points. Their two columns are not a force over time.
        tags.classifier_tags.poor_score = True
        return tags

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Fit to trials of one feature.

        Parameters
        ----------
        X : array (trials, samples)
            One trial per row; NaN is a missing sample. The feature is force, N, unless ``features`` names another.
        y : array (trials,)
            The categories of the trials.
        """
        rows, labels = validate_data(
            self, X, y, ensure_all_finite="allow-nan", dtype=np.float64, estimator=self
        )
        return self._fitted(_sequences(rows), labels, None)

    def fit_sequences(
        self, sequences: Sequence[ArrayLike], y: ArrayLike, groups: ArrayLike | None = None
    ) -> Self:
        """Fit to trials of unequal length.

        Parameters
        ----------
        sequences : list of arrays (samples,) or (samples, features)
            One for each trial. A sample with NaN is missing.
        y : array (trials,)
            The categories of the trials.
        groups : array (trials,), optional
            The reach of each trial. Fitting does not use it.
        """
        self._forget_columns()
        return self._fitted(_sequences(sequences), np.asarray(y), groups)

    def fit_trials(self, trials: _core.Trials) -> Self:
        """Fit to trials with categories. Blocks, outliers and trials without a category are left out."""
        self._forget_columns()
        self.model_ = _fit(trials, self._classifier, **self._options())
        self.classes_ = np.asarray(self.model_.categories)
        self._columns = list(range(len(self.classes_)))
        return self

    def _forget_columns(self) -> None:
        """Forgets the columns of rows that were fitted before."""
        for name in ("n_features_in_", "feature_names_in_"):
            self.__dict__.pop(name, None)

    def _fitted(self, sequences: list[Any], labels: NDArray[Any], groups: ArrayLike | None) -> Self:
        try:
            check_classification_targets(labels)
            classes = np.unique(labels)
        except TypeError:
            kinds = ", ".join(sorted({type(label).__name__ for label in labels.tolist()}))
            raise ValueError(f"y has labels of types that cannot be sorted: {kinds}; leave out trials whose label is missing") from None
        names = [_inside(label) for label in classes.tolist()]
        inside = dict(zip(classes.tolist(), names, strict=True))
        trials = _core.Trials.from_sequences(
            sequences,
            [inside[label] for label in labels.tolist()],
            features=self.features,
            groups=None if groups is None else np.asarray(groups).tolist(),
        )
        self.model_ = _fit(trials, self._classifier, **self._options())
        order = self.model_.categories
        # Only now, so that a fit that fails leaves no classes of another model.
        self.classes_, self._columns = classes, [order.index(name) for name in names]
        return self

    def __sklearn_is_fitted__(self) -> bool:
        return hasattr(self, "model_")

    def _scored(self, X: Any) -> NDArray[np.float64]:
        check_is_fitted(self)
        if isinstance(X, _core.Trials):
            trials = X
        elif _are_sequences(X):
            trials = _core.Trials.from_sequences(_sequences(X), features=self.features)
        else:
            rows = validate_data(self, X, reset=False, ensure_all_finite="allow-nan", dtype=np.float64, estimator=self)
            trials = _core.Trials.from_sequences(_sequences(rows), features=self.features)
        return self.model_.scores(trials)[:, self._columns]

    def score_samples(self, X: Any) -> NDArray[np.float64]:
        """Log-likelihood, or log-posterior under equal priors, of each trial for each class, nats: (trials, classes).

        ``X`` is an array as for ``fit``, a list of sequences, or trials.
        """
        return self._scored(X)

    def predict_log_proba(self, X: Any) -> NDArray[np.float64]:
        """Logarithm of :meth:`predict_proba`."""
        scores = self._scored(X)
        best = scores.max(axis=1, keepdims=True)
        # A trial that is impossible in every class is equally likely for all.
        scores = np.where(np.isfinite(best), scores - np.where(np.isfinite(best), best, 0.0), 0.0)
        return np.asarray(scores - np.log(np.exp(scores).sum(axis=1, keepdims=True)))

    def predict_proba(self, X: Any) -> NDArray[np.float64]:
        """Probability of each class under equal priors: (trials, classes)."""
        return np.exp(self.predict_log_proba(X))

    def predict(self, X: Any) -> NDArray[Any]:
        """The likeliest class of each trial."""
        best = self._scored(X).argmax(axis=1)
        return np.asarray(self.classes_[best])

    @property
    def categories(self) -> list[str]:
        """The categories of the model, for :func:`underbrush.evaluate`."""
        check_is_fitted(self)
        return list(self.model_.categories)

    def scores(self, trials: _core.Trials) -> NDArray[np.float64]:
        """The scores of trials in the order of ``categories``."""
        check_is_fitted(self)
        return self.model_.scores(trials)

    def online(self, skin: _core.Skin, patch: str | None = None, **options: Any) -> _core.Online:
        """Classify frame by frame; see :meth:`Model.online`."""
        check_is_fitted(self)
        return self.model_.online(skin, patch, **options)


class HiddenMarkovClassifier(_TrialClassifier):
    """One hidden Markov model per category, as in the paper.

    Parameters
    ----------
    states : int
        Hidden states of each model.
    features : str or list of str
        Features of each sample: ``"force"``, ``"force,motion"``.
    recipe : {"authors", "modern"}
        Supplies the options that are ``None``.
    topology : {"left-right", "ergodic"}, optional
    initial : {"uniform", "first-state"}, optional
    score_kind : {"viterbi", "forward"}, optional
    iterations : int, optional
    tolerance, variance_floor : float, optional
    max_samples : int, optional

    Attributes
    ----------
    classes_ : array (classes,)
    model_ : Model
    """

    _classifier = "hmm"

    def __init__(
        self,
        states: int = 10,
        features: str | Sequence[str] | None = "force",
        recipe: str = "authors",
        topology: str | None = None,
        initial: str | None = None,
        score_kind: str | None = None,
        iterations: int | None = None,
        tolerance: float | None = None,
        variance_floor: float | None = None,
        max_samples: int | None = None,
    ) -> None:
        self.states = states
        self.features = features
        self.recipe = recipe
        self.topology = topology
        self.initial = initial
        self.score_kind = score_kind
        self.iterations = iterations
        self.tolerance = tolerance
        self.variance_floor = variance_floor
        self.max_samples = max_samples


class _Baseline(_TrialClassifier):
    """A classifier whose only parameter is its features. ``None`` chooses the classifier's default features."""

    def __init__(self, features: str | Sequence[str] | None = "force") -> None:
        self.features = features


class NearestNeighboursClassifier(_Baseline):
    """Nearest neighbours over a fixed window at the start of a contact."""

    _classifier = "nearest-neighbours"


class NaiveBayesClassifier(_Baseline):
    """Naive Bayes over statistics of the contact so far. ``features=None`` adds the motion of the contact."""

    _classifier = "naive-bayes"


class PeakForceClassifier(_Baseline):
    """Two Gaussians on ln(1 + F / 0.1 N) of the largest force F since contact: a baseline."""

    _classifier = "peak-force"


class EchoStateClassifier(_Baseline):
    """A linear readout of a recurrent network with fixed random weights."""

    _classifier = "echo-state-network"


class LogisticClassifier(_Baseline):
    """Logistic regression over statistics of the contact so far.

    ``features=None`` adds the contact region, which only trials have.
    """

    _classifier = "logistic"


class LogisticTaxelClassifier(_Baseline):
    """Logistic regression over statistics of the taxel so far. ``features=None`` adds the motion of the contact."""

    _classifier = "logistic-taxel"


class MiniRocketClassifier(_Baseline):
    """MiniRocket: how often the outputs of fixed convolutions are high, and ridge regression on that.

    ``features=None`` adds the contact region, which only trials have.
    """

    _classifier = "mini-rocket"


class TreesClassifier(_Baseline):
    """Gradient-boosted trees over statistics of the contact so far.

    ``features=None`` adds the contact region, which only trials have.
    """

    _classifier = "trees"
