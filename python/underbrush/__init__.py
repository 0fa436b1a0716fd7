"""A physics testbed that makes synthetic incidental-contact data and classifies it taxel by taxel.

A compliant arm wearing tactile skin reaches through simulated foliage. What its skin feels is recorded with ground truth,
and classifiers learn to tell what each taxel touches. Quantities are in SI units, which their names end with; vectors are
in the frame that their name ends with. ``docs/python.md`` is the guide.
"""

from __future__ import annotations

import importlib.util

from ._core import (
    Arm,
    Camera,
    ControllerInput,
    Dataset,
    Frame,
    Model,
    Online,
    Options,
    Reach,
    Scene,
    ShippedController,
    Simulation,
    Skin,
    Table,
    TouchModel,
    Trials,
    __version__,
    checks,
    classifiers,
    evaluate,
    inspect,
    merge,
    online,
    reach,
    step_many,
    validate,
)
from ._benchmark import benchmark
from ._data import FrameDataset, TrialDataset
from ._errors import InputError, RunError, StorageError
from ._generate import generate, generate_again, generate_shared
from ._picture import Picture
from ._replay import Page, replay
from ._study import check, reproduce
from ._train import fit
from ._trial import Trial

__all__ = [
    "Arm",
    "Camera",
    "ControllerInput",
    "Dataset",
    "Frame",
    "FrameDataset",
    "InputError",
    "Model",
    "Online",
    "Options",
    "Page",
    "Picture",
    "Reach",
    "RunError",
    "Scene",
    "ShippedController",
    "Simulation",
    "Skin",
    "StorageError",
    "Table",
    "TouchModel",
    "Trial",
    "TrialDataset",
    "Trials",
    "__version__",
    "benchmark",
    "check",
    "checks",
    "classifiers",
    "evaluate",
    "fit",
    "generate",
    "generate_again",
    "generate_shared",
    "inspect",
    "merge",
    "online",
    "reach",
    "replay",
    "reproduce",
    "step_many",
    "validate",
]

if importlib.util.find_spec("gymnasium") is not None:
    from ._register import register

    register()
