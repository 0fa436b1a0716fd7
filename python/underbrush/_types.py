"""Types of arguments."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import Arm, ControllerInput, Scene, Trials

SceneLike: TypeAlias = Scene | str | os.PathLike[str]
"""A scene, the name of one that ships, or the path of a scene file."""

Control: TypeAlias = Callable[[ControllerInput], ArrayLike | tuple[ArrayLike, str]]
"""A controller: a function of what it knows that returns equilibrium angles, rad, or these and what it is about to do."""

ControllerLike: TypeAlias = str | Control | Callable[[Arm], Control]
"""The name of a controller that ships, a function, or a class that is called with the arm at the start of every reach."""

Features: TypeAlias = str | Sequence[str] | None
"""Names of features, as a list or joined by commas."""

Decision: TypeAlias = str | float | tuple[float, float] | None
"""How scores become verdicts: "argmax", "paper", a margin in nats below which a verdict is uncertain, or a pair of them."""


class FittedClassifier(Protocol):
    """A fitted classifier written in Python."""

    @property
    def categories(self) -> list[str]:
        """Different names in alphabetical order, which is the order of the scores."""

    def scores(self, trials: Trials) -> NDArray[np.float64]:
        """Log-probabilities or log-likelihoods, nats: (trials, categories)."""


class TrialClassifier(Protocol):
    """A classifier written in Python that can be fitted to trials."""

    def fit_trials(self, trials: Trials) -> Any:
        """Returns a :class:`FittedClassifier`."""
