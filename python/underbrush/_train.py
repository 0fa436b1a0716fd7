"""Fitting a classifier by its name."""

from __future__ import annotations

from collections.abc import Sequence

from . import _core
from ._errors import refused


def fit(
    trials: _core.Trials,
    classifier: str = "hmm",
    *,
    features: str | Sequence[str] | None = None,
    recipe: str | None = None,
    states: int | None = None,
    topology: str | None = None,
    initial: str | None = None,
    score: str | None = None,
    iterations: int | None = None,
    tolerance: float | None = None,
    variance_floor: float | None = None,
    max_samples: int | None = None,
    start: _core.Model | None = None,
    false_positive_rate: float | None = None,
    outlier_prior: float | None = None,
    jobs: int | None = None,
) -> _core.Model:
    """Fit a classifier to trials. The model equals that of ``underbrush train``, bit for bit.

    Parameters
    ----------
    trials : Trials
        Trials with categories. Blocks and outliers are never fitted.
    classifier : str
        One of :func:`classifiers`. The options from ``recipe`` to ``max_samples`` are for ``hmm`` only.
    features : str or list of str, optional
        Features of each sample, such as ``"force,motion"``.
    recipe : {"authors", "modern"}, optional
        Supplies the options that are not given.
    states, topology, initial, score, iterations, tolerance, variance_floor, max_samples : optional
        Options of hidden Markov models; see ``docs/classifiers.md``.
    start : Model, optional
        Hidden Markov models to train further.
    false_positive_rate : float, optional
        Choose thresholds by cross-validation and store them in the model.
    outlier_prior : float, optional
        With ``false_positive_rate``: the fraction of contacts expected to be outliers; 0.05 by default.
    jobs : int, optional
        Number of threads; all cores by default.

    Returns
    -------
    Model

    Raises
    ------
    InputError
        If an option does not apply or is out of range, if a trial lacks a feature, or if there are no trials of a
        category that is needed.
    RunError
        If the training of a hidden Markov model fails, for example because a state has settled on repeated samples.
    """
    options = _core.Options(
        classifier,
        features=features,
        recipe=recipe,
        states=states,
        topology=topology,
        initial=initial,
        score=score,
        iterations=iterations,
        tolerance=tolerance,
        variance_floor=variance_floor,
        max_samples=max_samples,
    )
    if start is not None:
        _refuse_with_start(
            "only the training options, because the start models keep the others",
            classifier=None if classifier == "hmm" else classifier,
            features=features,
            recipe=recipe,
            states=states,
            topology=topology,
            initial=initial,
            max_samples=max_samples,
        )
        allowed = "only without start, because thresholds are chosen on models that are fitted from scratch"
        _refuse_with_start(allowed, false_positive_rate=false_positive_rate)
    if outlier_prior is not None and false_positive_rate is None:
        allowed = "only with it, because it is for the thresholds"
        raise refused("outlier_prior", "given without false_positive_rate", allowed, "leave it out")
    return _core.fit(
        trials,
        options,
        start=start,
        false_positive_rate=false_positive_rate,
        outlier_prior=outlier_prior,
        jobs=jobs,
    )


def _refuse_with_start(allowed: str, **given: object) -> None:
    """Refuses the first option that is given although there are start models."""
    for option, value in given.items():
        if value is not None:
            raise refused(option, "given with start", allowed, "leave it out")
