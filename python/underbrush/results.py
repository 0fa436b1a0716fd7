"""Types of the dictionaries that calls return, for editors and type checkers. Places are in m, world frame; times in s, forces in N."""

from typing import Any, Literal, NotRequired, TypeAlias, TypedDict


class Interval(TypedDict):
    """A 95 % interval, from 0 to 1."""

    low: float
    high: float


class StiffnessInterval(TypedDict):
    """What is known of a stiffness, N/m: median, and an interval that is meant to hold it in nine of ten cases."""

    low_n_per_m: float
    median_n_per_m: float
    high_n_per_m: float


class TaxelVerdict(TypedDict):
    """The verdict on a taxel in contact, of a model of trials or of a touch model."""

    taxel: int
    samples: int
    """How many frames of its contact were seen."""
    verdict: str
    """The name of a category, "uncertain", or of a touch model "unknown" or "nothing"."""
    scores: NotRequired[dict[str, float]]
    """Of a model of trials: a score for each category, nats."""
    patch: NotRequired[str]
    contact: NotRequired[int]
    """Of a touch model: the number of the contact that the taxel belongs to."""
    nothing: NotRequired[float]
    """Of a touch model: the probability that nothing touches."""
    probabilities: NotRequired[dict[str, float]]


Mobility: TypeAlias = Literal["holds", "gives-way", "comes-back", "stays"]
"""What an object has done under the push."""


class TouchedObject(TypedDict):
    """What a touch model knows of an object that touches the skin."""

    object: int
    samples: int
    verdict: str
    share_beyond: float
    """The share of known objects that are as unlike what is known."""
    stiffness: NotRequired[StiffnessInterval]
    """Missing until it is judged."""
    moved_m: float
    mobility: Mobility


class Goal(TypedDict):
    """A goal of a reach."""

    position_world: list[float]
    start_time_s: float
    end_time_s: float
    outcome: str
    safety_stop: Any
    given_up: NotRequired[str]
    """Why the controller gave it up."""


class SceneObject(TypedDict):
    """Ground truth: an object of the clutter."""

    kind: str
    category: str
    position_world: list[float]
    parameters: dict[str, float]


class Contact(TypedDict):
    """Ground truth: a contact of a link with an object, from its first frame to its last."""

    first_frame: int
    last_frame: int
    link: str
    patch: int | None
    object: int
    mean_force_n: float
    peak_force_n: float


class Audit(TypedDict):
    """Residuals of the physics of a reach."""

    controller_steps: int
    failed_controller_steps: int
    infeasible_controller_steps: int
    deepest_penetration_m: float
    energy_residual: float
    integrator_energy_share: float
    largest_contact_residual: float
    largest_force_residual: float
    largest_frame_force_jump_n: float
    largest_moment_residual_m: float
    largest_static_residual: float
    largest_step_force_jump_n: float
    overlap_without_patch_m: float
    rest_frames: int


class Episode(TypedDict):
    """A reach of a data set."""

    scene: str
    seed: int
    reach_index: int
    controller: str
    task: str
    frames: int
    outcome: str
    goal_outcomes: dict[str, int]
    safety_stop: Any
    contacts: int
    objects: int
    touched_frames: dict[str, int]
    audit: Audit
    chunk_index: int
    file_index: int
    first_index: int


class CategoryFigures(TypedDict):
    """How well the trials of one category are told."""

    category: str
    trials: int
    correct: int
    uncertain: int
    outlier: int
    recall: float
    recall_interval: Interval
    precision: float | None
    f1: float


class Prediction(TypedDict):
    """The verdict on a trial that its model was not fitted on."""

    trial: int
    reach: int | None
    fold: int
    category: str
    samples: int
    scores: list[float]
    verdict: Any
    touched: NotRequired[bool]


class Evaluation(TypedDict):
    """What a cross-validation found."""

    accuracy: float
    accuracy_interval_by_reach: Interval | None
    accuracy_interval_by_trial: Interval
    balanced_accuracy: float
    majority_baseline: float
    by_touch: NotRequired[dict[str, Any]]
    categories: list[CategoryFigures]
    confusion: dict[str, Any]
    by_samples: NotRequired[list[dict[str, Any]]]
    folds: NotRequired[dict[str, Any]]
    baseline: NotRequired[dict[str, Any]]
    predictions: list[Prediction]
    training: NotRequired[list[dict[str, Any]]]


class Likeliest(TypedDict):
    """The likeliest known category of an object at some moment, and its probability if the object is of a known category."""

    category: str
    probability: float


class JudgedObject(TypedDict):
    """An object that was touched: the verdicts that stood at some moments, beside the truth."""

    reach: int
    object: int
    truth: str
    true_object: int
    patch: str
    lasted_s: float
    peak_force_n: float
    after_100_ms: str
    truth_after_100_ms: str
    after_300_ms: str
    truth_after_300_ms: str
    patch_after_300_ms: str
    likeliest_after_300_ms: Likeliest
    at_peak: str
    truth_at_peak: str
    at_end: str
    likeliest_at_end: Likeliest
    flips: int
    mean_cost: float
    share_beyond: float
    stiffness: StiffnessInterval | None
    true_stiffness_n_per_m: float | None
    moved_m: float
    moved_true_m: float | None
    mobility: Mobility
    contacts: int
    contacts_called_unknown: int


class UnknownObjects(TypedDict):
    """How many unknown objects and contacts were found, and how many known ones were called unknown."""

    unknown_objects: int
    found_objects: int
    found_interval: Interval | None
    found_objects_at_peak: int
    found_at_peak_interval: Interval | None
    known_objects: int
    false_alarm_objects: int
    false_alarm_interval: Interval | None
    false_alarm_objects_at_peak: int
    false_alarm_at_peak_interval: Interval | None
    unknown_contacts: int
    found_contacts: int
    found_contacts_interval: Interval | None
    known_contacts: int
    false_alarm_contacts: int
    false_alarm_contacts_interval: Interval | None
    roc_area: float | None
    roc_area_interval: Interval | None


class TouchEvaluation(TypedDict):
    """How well a touch model judged some reaches."""

    categories: list[str]
    reaches: int
    folds: NotRequired[int]
    objects: list[JudgedObject]
    object_verdicts: list[dict[str, Any]]
    flips: dict[str, Any] | None
    grouping: dict[str, Any] | None
    unknown: UnknownObjects
    verdicts_by_cost: list[dict[str, Any]]
    stiffness: list[dict[str, Any]]
    truths: list[dict[str, Any]]
    patches: list[dict[str, Any]]
    contacts_at_end: dict[str, Any] | None
    contacts_at_end_interval: Interval | None
    by_reach: dict[str, Any]
    decisions: list[dict[str, Any]]
    brier_score: float | None
    calibration: list[dict[str, Any]]
    expected_calibration_error: float | None
    object_calibration_error: float | None
    right_after_samples: list[dict[str, Any]]
    spurious_called_nothing: float | None
    touches_lost: float | None
