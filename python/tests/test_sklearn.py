"""The estimators for scikit-learn, and scikit-learn's classifiers where underbrush expects its own."""

import warnings

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import GridSearchCV, GroupKFold, cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import FunctionTransformer
from sklearn.svm import LinearSVC
from sklearn.utils.estimator_checks import check_estimator

import underbrush as ub
from underbrush import sklearn as ours

ESTIMATORS = [
    ours.HiddenMarkovClassifier(states=3),
    ours.NearestNeighboursClassifier(),
    ours.NaiveBayesClassifier(),
    ours.PeakForceClassifier(),
    ours.EchoStateClassifier(),
    ours.LogisticClassifier(),
    ours.LogisticTaxelClassifier(),
    ours.MiniRocketClassifier(),
    ours.TreesClassifier(),
]


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=lambda own: type(own).__name__)
def test_check_estimator(estimator: object) -> None:
    """Tests that an estimator passes scikit-learn's own checks."""
    results = check_estimator(estimator, on_fail=None)
    failed = [(found["check_name"], str(found["exception"])) for found in results if found["status"] == "failed"]
    assert failed == []
    assert sum(found["status"] == "passed" for found in results) > 40


@pytest.mark.parametrize("name", [name for name, _ in ub.classifiers()])
def test_scores_are_those_of_the_model(name: str, trials: ub.Trials) -> None:
    """Tests that an estimator fitted to trials, to sequences and to padded rows gives the scores of the model, bit for
    bit. The times of sequences begin at 0, which changes statistics over time in their last bits."""
    estimator = next(type(own) for own in ESTIMATORS if own._classifier == name)(features="force")
    y = np.array(trials.categories)
    assert np.array_equal(
        estimator.fit_trials(trials).score_samples(trials), ub.fit(trials, name, features="force").scores(trials)
    )
    sequences = trials.sequences()
    from_start = ub.Trials.from_sequences(sequences, trials.categories)
    expected = ub.fit(from_start, name, features="force").scores(from_start)
    assert np.array_equal(estimator.fit_sequences(sequences, y).score_samples(sequences), expected)
    rows = trials.padded()
    found = estimator.fit(rows, y)
    assert np.array_equal(found.score_samples(rows), expected)
    assert np.allclose(found.predict_proba(rows).sum(axis=1), 1.0)
    assert list(found.predict(rows)) == [found.classes_[row.argmax()] for row in expected]


def test_model_selection_works(trials: ub.Trials) -> None:
    """Tests that estimators work in cross_val_score with grouped folds, GridSearchCV and Pipeline."""
    rows, y, groups = trials.padded(samples=60), np.array(trials.categories), np.array(trials.reaches)
    own = ours.HiddenMarkovClassifier(states=3, iterations=10)
    scores = cross_val_score(own, rows, y, groups=groups, cv=GroupKFold(2))
    folds = GroupKFold(2).split(rows, y, groups)
    by_hand = [clone(own).fit(rows[fit], y[fit]).score(rows[test], y[test]) for fit, test in folds]
    assert len(by_hand) == 2 and np.array_equal(scores, by_hand)
    search = GridSearchCV(own, {"states": [2, 4]}, cv=2, scoring="balanced_accuracy").fit(rows, y)
    assert search.best_params_["states"] in (2, 4)
    pipeline = make_pipeline(FunctionTransformer(lambda forces: forces * 2.0), own).fit(rows, y)
    assert pipeline.predict(rows).shape == y.shape


def test_labels_may_be_anything() -> None:
    """Tests that predictions have the original labels, even if these are numbers or names of categories that are never
    fitted."""
    rng = np.random.default_rng(1)
    rows = np.concatenate([rng.normal(1.0, 0.1, (20, 8)), rng.normal(5.0, 0.1, (20, 8))])
    for labels in ([3, 1], ["outlier", "block"], [True, False], ["z", "a"]):
        y = np.repeat(labels, 20)
        found = ours.HiddenMarkovClassifier(states=2).fit(rows, y).predict(rows)
        assert found.dtype == y.dtype and (found == y).all()


def test_missing_samples_are_left_out() -> None:
    """Tests that NaN is a missing sample at any place, and that infinity and trials of only NaN are refused."""
    rng = np.random.default_rng(2)
    rows = rng.normal(1.0, 0.3, (20, 6)) + np.repeat([0.0, 2.0], 10)[:, np.newaxis]
    y = np.repeat(["a", "b"], 10)
    spread = np.full((20, 9), np.nan)
    spread[:, [0, 1, 3, 4, 5, 7]] = rows
    own = ours.HiddenMarkovClassifier(states=2)
    assert np.array_equal(own.fit(spread, y).predict_proba(spread), own.fit(rows, y).predict_proba(rows))
    rows[2] = np.nan
    with pytest.raises(ValueError, match="row 2"):
        own.fit(rows, y)
    rows[2] = np.inf
    with pytest.raises(ValueError, match="infinity"):
        own.fit(rows, y)


def test_arrays_in_a_list_are_trials() -> None:
    """Tests that arrays in a list, a tuple or an array are trials, also if they are equally long or there is one, and that NaN is
    left out."""
    rng = np.random.default_rng(3)
    rows = rng.normal(1.0, 0.3, (20, 6)) + np.repeat([0.0, 2.0], 10)[:, np.newaxis]
    own = ours.LogisticClassifier().fit(rows, np.repeat(["a", "b"], 10))
    first, second = rows[0, :4], rows[1, :5]
    expected = own.predict_proba([first, second])[0]
    array = np.empty(2, object)
    array[:] = [first, second]
    gap = np.insert(first, 2, np.nan)
    for given in ([first], [first, second[:4]], (first, second), array, [gap, second], [gap, second[:4]]):
        assert np.array_equal(own.predict_proba(given)[0], expected)
    y = ["a", "b"]
    with_gap, without = (ours.LogisticClassifier().fit_sequences([own, second], y) for own in (gap, first))
    assert np.array_equal(with_gap.predict_proba([first]), without.predict_proba([first]))


def test_another_fit_forgets_the_names_of_columns(trials: ub.Trials) -> None:
    """Tests that a fit to trials or sequences forgets the columns of a data frame, so that arrays are judged without a warning."""
    pandas = pytest.importorskip("pandas")
    rows, y = trials.padded(samples=60), np.array(trials.categories)
    frame = pandas.DataFrame(rows, columns=[f"force {sample}" for sample in range(60)])
    of_trials, of_sequences = (ours.LogisticClassifier().fit(frame, y) for _ in range(2))
    of_trials.fit_trials(trials)
    of_sequences.fit_sequences(trials.sequences(), y)
    for own in (of_trials, of_sequences):
        assert not hasattr(own, "feature_names_in_")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            own.predict(rows)


def test_a_fit_that_fails_leaves_the_classes() -> None:
    """Tests that after a fit that fails an estimator has the classes of its model, or is not fitted."""
    rows, y = np.repeat([[1.0], [5.0]], 10, axis=0) * np.linspace(0.9, 1.1, 8), np.repeat(["a", "b"], 10)
    own, fresh = ours.LogisticClassifier().fit(rows, y), ours.LogisticClassifier()
    for estimator in (own, fresh):
        with pytest.raises(ub.InputError, match="control characters"):
            estimator.fit(rows, np.repeat(["c\n", "d"], 10))
    assert own.classes_.tolist() == ["a", "b"]
    with pytest.raises(NotFittedError):
        fresh.predict(rows)
    with pytest.raises(NotFittedError):
        fresh.scores(ub.Trials.from_sequences(list(rows)))


def test_numbers_are_no_classes_of_sequences() -> None:
    """Tests that `fit_sequences` refuses labels that are measured numbers, as `fit` does, and says that labels are missing."""
    with pytest.raises(ValueError, match="continuous"):
        ours.LogisticClassifier().fit_sequences([[1.0, 2.0], [3.0]], [0.5, 0.7])
    with pytest.raises(ValueError, match="cannot be sorted: NoneType, str; leave out"):
        ours.LogisticClassifier().fit_sequences([[1.0, 2.0], [3.0]], ["leaf", None])


def test_scikit_learn_takes_part_in_evaluate(trials: ub.Trials) -> None:
    """Tests that a scikit-learn classifier in `evaluate` gives the verdicts that it gives by itself on the same
    folds, and that an empty window is refused."""
    window = ours.FixedWindow(LogisticRegression(max_iter=500), samples=20)
    found = ub.evaluate(trials, window, folds=2, group="position")
    names, fold = np.array(trials.categories), np.array([own["fold"] for own in found["predictions"]])
    rows = window._rows(trials)
    for part in (0, 1):
        fitted = LogisticRegression(max_iter=500).fit(rows[fold != part], names[fold != part])
        expected = fitted.predict(rows[fold == part])
        own = [p["verdict"] for p, inside in zip(found["predictions"], fold == part, strict=True) if inside]
        assert [verdict["category"] for verdict in own] == list(expected)
    assert 0 < found["accuracy"] <= 1 and found["majority_baseline"] > 0
    with pytest.raises(ub.InputError, match="samples: found 0; allowed: a whole number, 1 or more"):
        ours.FixedWindow(LinearSVC(), samples=0).fit_trials(trials)
    fitted = window.fit_trials(trials)
    assert ub.evaluate(trials, fitted)["accuracy"] >= found["accuracy"] - 0.2
    assert ub.evaluate(trials[::2], ours.FixedWindow(LinearSVC()), train=trials[1::2])["accuracy"] > 0.5


def test_folds_do_not_share_a_classifier(trials: ub.Trials) -> None:
    """Tests that an estimator, which returns itself when it is fitted, has the figures of its options in every run, and stays as
    it was."""
    own = ours.LogisticClassifier()
    expected = ub.evaluate(trials, ub.Options("logistic", features="force"), decision="argmax")["accuracy"]
    assert {ub.evaluate(trials, own, decision="argmax")["accuracy"] for _ in range(8)} == {expected}
    assert not hasattr(own, "model_")


def test_features_that_a_classifier_chooses(data: ub.Dataset, trials: ub.Trials) -> None:
    """Tests that an estimator with the classifier's own features has the figures of that classifier, and its scores in a stream."""
    own = ours.LogisticClassifier(features=None)
    expected = ub.evaluate(trials, ub.Options("logistic"), decision="argmax")["accuracy"]
    assert ub.evaluate(trials, own, decision="argmax")["accuracy"] == expected
    fitted = own.fit_trials(trials)
    streams = ub.online(fitted, data.skin), fitted.online(data.skin)
    felt = 0
    for index in range(len(data[0])):
        found, wanted = ([list(taxel["scores"].values()) for taxel in own.update(data[0].frame(index))] for own in streams)
        assert np.allclose(found, wanted)
        felt += len(found)
    assert felt > 0


def test_categories_out_of_order_are_named(trials: ub.Trials) -> None:
    """Tests that the error about categories in the wrong order shows them."""

    class Unsorted:
        categories = ["trunk", "leaf"]

        def scores(self, given: ub.Trials) -> np.ndarray:
            return np.zeros((len(given), 2))

    with pytest.raises(ub.InputError, match=r'found \["trunk", "leaf"\]'):
        ub.evaluate(trials, Unsorted())


def test_a_python_classifier_that_raises_is_heard(trials: ub.Trials) -> None:
    """Tests that an exception of a Python classifier reaches the caller, whether it is raised in fitting or in scoring,
    and that bad scores are refused."""

    class Broken:
        categories = ["leaf", "trunk"]

        def __init__(self, where: str) -> None:
            self.where = where

        def fit_trials(self, _: ub.Trials) -> "Broken":
            if self.where == "fit":
                raise LookupError("in fitting")
            return self

        def scores(self, given: ub.Trials) -> np.ndarray:
            if self.where in ("nan", "inf"):
                return np.full((len(given), 2), float(self.where))
            if self.where == "shape":
                return np.zeros((len(given), 3))
            raise LookupError("in scoring")

    for where, kind, text in (
        ("fit", LookupError, "in fitting"),
        ("score", LookupError, "in scoring"),
        ("nan", ub.InputError, "NaN"),
        ("inf", ub.InputError, "found inf"),
        ("shape", ub.InputError, "shape"),
    ):
        with pytest.raises(kind, match=text):
            ub.evaluate(trials, Broken(where))


def test_a_classifier_that_raises_for_the_first_samples_is_heard(trials: ub.Trials) -> None:
    """Tests that an exception of a Python classifier that only short trials raise ends an evaluation by numbers of
    samples."""

    class Impatient:
        categories = ["leaf", "trunk"]

        def fit_trials(self, _: ub.Trials) -> "Impatient":
            return self

        def scores(self, given: ub.Trials) -> np.ndarray:
            if min(given.lengths) < 20:
                raise LookupError("too short")
            return np.tile([0.0, -1.0], (len(given), 1))

    leaf, trunk = ([place for place, own in enumerate(trials.categories) if own == name] for name in Impatient.categories)
    some = trials[[*leaf[:2], *trunk[:2], *leaf[2:4], *trunk[2:4]]]
    assert ub.evaluate(some, Impatient(), group="position")["accuracy"] == 0.5
    with pytest.raises(LookupError, match="too short"):
        ub.evaluate(some, Impatient(), group="position", by_samples=True)


def test_hmmlearn_agrees(trials: ub.Trials) -> None:
    """Tests that forward and Viterbi scores agree with hmmlearn's for the same models, to 1e-9 of their size."""
    from hmmlearn.hmm import GaussianHMM

    import json

    model = ub.fit(trials, states=6, features="force,motion")
    file = json.loads(model.to_json())
    sequences = trials.sequences("force,motion")
    for column, name in enumerate(model.categories):
        own = file["models"][name]
        peer = GaussianHMM(n_components=6, covariance_type="full")
        peer.startprob_, peer.transmat_ = np.array(own["initial"]), np.array(own["transition"])
        peer.means_, peer.covars_ = np.array(own["mean"]), np.array(own["covariance"])
        for kind, score in (("forward", peer.score), ("viterbi", lambda rows: peer.decode(rows)[0])):
            expected = np.array([score(rows) for rows in sequences])
            found = model.with_score(kind).scores(trials)[:, column]
            assert np.allclose(found, expected, rtol=1e-9, atol=1e-9), (name, kind, np.abs(found - expected).max())
