"""Trials, and models fitted to them."""

import json
import pickle
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest

import underbrush as ub


def test_trials_equal_those_of_the_command_line(data: ub.Dataset, trials: ub.Trials, tmp_path: Path, command) -> None:
    """Tests that trials from Python equal those that the command line writes, and that both write the same table."""
    options = ["--labels", "environment", "--min-samples", 20]
    command("trials", data.path, *options, "--out", tmp_path / "cli.csv")
    trials.save(tmp_path / "python.csv")
    assert (tmp_path / "cli.csv").read_bytes() == (tmp_path / "python.csv").read_bytes()
    assert ub.Trials.load(tmp_path / "cli.csv") == trials
    component = data.trials(by="component")
    command("trials", data.path, "--by", "component", "--out", tmp_path / "component.csv")
    assert ub.Trials.load(tmp_path / "component.csv") == component


def test_trials_are_a_sequence(trials: ub.Trials) -> None:
    """Tests the length of trials, indexing by numbers, slices, lists and truth values, and that padded rows hold the
    sequences."""
    assert len(trials) == len(trials.categories) == len(trials.reaches) == len(trials.lengths)
    long = trials[trials.lengths > 50]
    assert 0 < len(long) < len(trials) and all(len(trial) > 50 for trial in long)
    assert trials[[2, 0]][0].number == trials[2].number
    assert len(trials[[]]) == len(trials[np.array([], dtype=int)]) == 0
    assert len(trials[1:4]) == 3 and trials[-1].number == trials[len(trials) - 1].number
    assert pickle.loads(pickle.dumps(trials)) == trials
    options = pickle.loads(pickle.dumps(ub.Options(states=2, features="force,motion")))
    assert ub.evaluate(trials, options) == ub.evaluate(trials, ub.Options(states=2, features="force,motion"))
    padded = trials.padded(samples=40)
    assert padded.shape == (len(trials), 40)
    for row, sequence, length in zip(padded, trials.sequences(), trials.lengths, strict=True):
        assert np.array_equal(row[~np.isnan(row)], sequence[:40, 0]) and len(sequence) == length
    both = trials.sequences("force,motion")[0]
    assert np.array_equal(both, np.stack([trials[0].force_n, trials[0].motion_m], axis=1))
    for index in (len(trials), -len(trials) - 1, 2**70, "leaf", [0.5]):
        with pytest.raises(IndexError):
            trials[index]
    with pytest.raises(ub.InputError, match="one for each trial"):
        trials[[True]]
    with pytest.raises(ub.InputError, match="samples: found 2305843009213693952"):
        trials.padded(samples=2**61)


def test_arrays_have_types_where_they_are_taken() -> None:
    """Tests that the types of the package allow NumPy's arrays and integers where the calls take them."""
    mypy = pytest.importorskip("mypy.api")
    code = """import numpy as np, underbrush as ub
data, y = ub.Dataset("data"), np.array(["leaf", "trunk"])
trials = ub.Trials.from_sequences(np.zeros((2, 5)), y, groups=np.arange(2)).with_categories(y)
one: ub.Trial = trials[np.int64(0)]
some: ub.Trials = trials[np.array([True, False])]
data[np.int64(0)].render(np.arange(2))
data.table("data", np.int64(0))"""
    found, _, status = mypy.run(["--strict", "-c", code])
    assert status == 0, found


def test_joined_trials_keep_their_reaches_apart(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that joined trials of the reaches of a set have the numbers of the set, that those of other data get numbers of their
    own, also after pickling and other categories, and that numbers that occur twice are refused when trials are saved."""
    whole = data.trials()
    joined = sum(reach.trials() for reach in data)
    assert joined.reaches == whole.reaches and joined.categories == whole.categories
    one, other = sorted(set(whole.reaches))[:2]
    data[one].save(tmp_path / "reach.parquet")
    loaded = ub.Reach.load(tmp_path / "reach.parquet").trials()
    copied = pickle.loads(pickle.dumps(loaded)).with_categories(loaded.categories)
    for more, count in ((loaded, 1), (copied, 1), (data[other].trials(), 2), (data[one].trials(), 2)):
        assert len(set((loaded + more).reaches)) == count
    parts = whole[:1] + loaded + whole[1:]
    assert [parts.reaches[0], *parts.reaches[1 + len(loaded) :]] == whole.reaches
    with pytest.raises(ub.InputError, match="join the trials of each data set first"):
        loaded + (whole + loaded)
    with pytest.raises(ub.InputError, match="number of an earlier trial"):
        whole[[0, 0]].save(tmp_path / "twice.csv")


def _fitted(text: str) -> dict[str, Any]:
    """A model file without its seal and what it says of its data and of how trials were cut: here they come from a set,
    there from a table."""
    model = json.loads(text)
    assert model.pop("blake3") and model["provenance"].pop("data")
    model["provenance"].get("options", {}).pop("trials", None)
    model["provenance"] = {key: value for key, value in model["provenance"].items() if value}
    return model


def test_trials_come_from_data_frames(trials: ub.Trials) -> None:
    """Tests that trials survive the way through pandas and Polars, that short ones can be left out, and that other objects,
    missing columns and bad numbers are refused."""
    assert ub.Trials.from_dataframe(trials.to_pandas()) == trials
    assert ub.Trials.from_dataframe(trials.to_polars()) == trials
    assert len(ub.Trials.from_dataframe(trials.to_pandas(), 20)) == sum(trials.lengths >= 20)
    with pytest.raises(ub.InputError, match="data frame of pandas or Polars"):
        ub.Trials.from_dataframe([[1.0]])
    with pytest.raises(ub.InputError, match="force_n"):
        ub.Trials.from_dataframe(trials.to_pandas().drop(columns="force_n"))
    frame = trials.to_pandas()
    frame.loc[3, "force_n"] = -5.0
    with pytest.raises(ub.InputError, match="^the data frame: row 3, .*force_n"):
        ub.Trials.from_dataframe(frame)


def test_missing_categories_are_refused(trials: ub.Trials) -> None:
    """Tests that a missing value of a pandas column is refused as a category, with its row and a remedy that works."""
    column = pandas.Series(trials.categories)
    column[3] = float("nan")
    with pytest.raises(ub.InputError, match="categories: found nan in row 3; allowed: a name, or None .* column.astype"):
        trials.with_categories(column)
    with pytest.raises(ub.InputError, match="categories: found <NA> in row 1"):
        ub.Trials.from_sequences([[1.0], [2.0]], ["leaf", pandas.NA])
    renamed = trials.with_categories(column.astype(object).where(column.notna(), None))
    assert renamed.categories == [*trials.categories[:3], None, *trials.categories[4:]]
    with pytest.raises(ub.InputError, match="categories: found an object of type .*str.*; allowed: a list of names"):
        trials.with_categories("leaf")


def test_any_column_is_a_feature(trials: ub.Trials, tmp_path: Path) -> None:
    """Tests that a further column of a data frame is a channel: it comes back as sequences, padded and in files, and a
    classifier uses it."""
    frame = trials.to_pandas()
    frame["shear"] = frame.force_n * np.where(frame.category == "leaf", -1.0, 1.0)
    with_shear = ub.Trials.from_dataframe(frame)
    both = with_shear.sequences(["force", "column:shear"])
    assert all(np.array_equal(abs(own[:, 0]), abs(own[:, 1])) for own in both)
    with_shear.save(tmp_path / "shear.parquet")
    again = ub.Trials.load(tmp_path / "shear.parquet")
    assert np.array_equal(again.padded("column:shear"), with_shear.padded("column:shear"), equal_nan=True)
    model = ub.fit(with_shear, "trees", features=["column:shear"])
    scores = model.scores(with_shear)
    found = np.array(model.categories)[scores.argmax(axis=1)]
    assert (found == np.array(with_shear.categories)).mean() > 0.95
    sequences = ub.Trials.from_sequences([own[:, 1] for own in both], features=["column:shear"])
    assert np.array_equal(model.scores(sequences), scores)



@pytest.mark.parametrize("name", [name for name, _ in ub.classifiers()])
def test_models_equal_those_of_the_command_line(name: str, trials: ub.Trials, tmp_path: Path, command) -> None:
    """Tests for every classifier that the model file, the scores and the evaluation from Python equal those of the
    command line, number for number, and that a saved and a pickled model give the same scores."""
    table, file = tmp_path / "trials.parquet", tmp_path / "model.json"
    trials.save(table)
    command("train", table, "--classifier", name, "--out", file)
    model = ub.fit(trials, name)
    assert _fitted(model.to_json()) == _fitted(file.read_text())
    scores = model.scores(trials)
    rows = command("score", file, table)["scores"]
    expected = [-np.inf if row["log_likelihood"] is None else row["log_likelihood"] for row in rows]
    assert np.array_equal(scores.T.ravel(), expected)
    model.save(tmp_path / "python.json")
    for other in (ub.Model.load(tmp_path / "python.json"), pickle.loads(pickle.dumps(model))):
        assert np.array_equal(other.scores(trials), scores)
    assert ub.evaluate(trials, ub.Options(name)) == command("evaluate", table, "--classifier", name)


def test_options_are_those_of_the_command_line(trials: ub.Trials, tmp_path: Path, command) -> None:
    """Tests that options of hidden Markov models and thresholds give the command line's model file."""
    table, file = tmp_path / "trials.parquet", tmp_path / "model.json"
    trials.save(table)
    options = ["--states", 5, "--recipe", "modern", "--features", "force,motion", "--max-samples", 60]
    command("train", table, *options, "--iterations", 20, "--false-positive-rate", 0.2, "--out", file)
    model = ub.fit(
        trials, states=5, recipe="modern", features="force,motion", max_samples=60, iterations=20, false_positive_rate=0.2
    )
    assert _fitted(model.to_json()) == _fitted(file.read_text())
    verdicts = model.classify(trials)
    assert set(verdicts) <= {"leaf", "trunk", "uncertain", "outlier"}
    assert model.classify(trials, decision="argmax") != verdicts or "uncertain" not in verdicts
    further = ub.fit(trials, start=model, iterations=3)
    assert not np.array_equal(further.scores(trials), model.scores(trials))


def test_tests_on_training_data_are_noticed(trials: ub.Trials) -> None:
    """Tests that a classifier is not fitted to trials that it is tested on, not even to some of them, and that a model of these trials
    is warned of, but not one of other trials of the same data."""
    for part in (trials, trials[:10]):
        with pytest.raises(ub.InputError, match="train: found the same data to fit on and to test on; .* than the argument trials"):
            ub.evaluate(part, ub.Options("naive-bayes"), train=trials)
    model = ub.fit(trials[::2], "naive-bayes")
    with pytest.warns(UserWarning, match="^trials: the model was fitted to these data"):
        ub.evaluate(trials[::2], model)
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("always")
        ub.evaluate(trials[1::2], model)
        ub.evaluate(trials[1::2], ub.Options("naive-bayes"), train=trials[::2])
    assert not any("data" in str(own.message) for own in shown)


def test_warnings_are_at_the_line_of_the_caller(trials: ub.Trials) -> None:
    """Tests that a warning names the file that called the package, also if a module of the package called the libraries."""
    with pytest.warns(UserWarning, match="all trials or contacts that were fitted") as found:
        ub.fit(trials[np.array(trials.categories) == "leaf"], "logistic")
    assert found[0].filename == __file__


def test_trials_of_another_unit_are_noticed(data: ub.Dataset, trials: ub.Trials, tmp_path: Path, command) -> None:
    """Tests that trials by taxel are warned of if the model was fitted to trials by component."""
    file = tmp_path / "model.json"
    command("train", data.path, "--by", "component", "--classifier", "naive-bayes", "--out", file)
    with pytest.warns(UserWarning, match="^trials: trials by taxel, but the model was fitted to trials by component"):
        ub.Model.load(file).classify(trials)


def test_bad_options_are_refused(data: ub.Dataset, trials: ub.Trials) -> None:
    """Tests that options that do not exist, do not apply, are out of range or no numbers are refused by name."""
    for call, text in (
        (lambda: ub.fit(trials, "svm"), "nearest-neighbours"),
        (lambda: ub.fit(trials, "naive-bayes", states=3), "only for the classifier hmm"),
        (lambda: ub.fit(trials, states=0), "states"),
        (lambda: ub.fit(trials, recipe="best"), "authors"),
        (lambda: ub.fit(trials, features="colour"), "colour"),
        (lambda: ub.fit(trials, features=3), "features"),
        (lambda: ub.fit(trials.with_categories([None] * len(trials))), "none of"),
        (lambda: ub.evaluate(trials, ub.Options(), folds=1), "fold"),
        (lambda: ub.evaluate(trials, ub.Options(), group="colour"), "position, reach"),
        (lambda: ub.evaluate(trials, 3), "fit_trials"),  # type: ignore[arg-type]
        (lambda: ub.evaluate(trials, ub.fit(trials, states=2), folds=2), "folds: found given with a fitted model"),
        (lambda: ub.evaluate(trials, ub.fit(trials, states=2), train=trials), "train: found given with a fitted model"),
        (lambda: ub.evaluate(trials, ub.Options(), train=trials, by_samples=True), "by_samples: found given with train"),
        (lambda: ub.fit(trials, "logistic", start=ub.fit(trials, states=2)), "classifier: found given with start"),
        (lambda: ub.fit(trials, states=3, start=ub.fit(trials, states=2)), "states: found given with start"),
        (lambda: ub.fit(trials, outlier_prior=0.1), "outlier_prior: found given without false_positive_rate"),
        (lambda: ub.fit(trials).classify(trials, decision="best"), "argmax"),
        (lambda: ub.fit(trials).classify(trials, decision=(5.0, 1.0)), "thresholds"),
        (lambda: ub.fit(trials, "naive-bayes").with_score("forward"), "hidden Markov"),
        (lambda: data_with("labels")(trials), "labels"),
        (lambda: data.trials(wrap=False), 'wrap: found given with by="taxel"'),
        (lambda: ub.Trials.from_sequences([[1.0, np.nan]]), "sequence 0"),
        (lambda: ub.Trials.from_sequences([[1.0], []]), "sequence 1"),
        (lambda: ub.Trials.from_sequences([[1.0]], ["uncertain"]), "a name other than"),
        (lambda: ub.Trials.from_sequences([np.zeros((3, 2))]), "shape"),
        (lambda: ub.Trials.from_sequences([[1.0]], ["leaf", "trunk"]), "categories"),
        (lambda: ub.Trials.from_sequences([[3], [2, 1.5]], features="area"), "sequence 1: found 1.5 for area in sample 1"),
        (lambda: ub.Trials.from_sequences([[0]], features="area"), "whole numbers, 1 to 65536 taxels"),
        (lambda: ub.Trials.from_sequences([[1.0]], groups=[-1]), "groups: found -1; allowed: a whole number from 0"),
        (lambda: trials.padded(samples=2.5), "samples: found 2.5; allowed: a whole number from 0"),
        (lambda: ub.fit(trials, states=2**70), "states: found 1180591620717411303424; allowed: a whole number of at most 64"),
        (lambda: ub.fit(trials, states=True), "states: found boolean `true`; allowed: a whole number from 0"),
        (lambda: ub.fit(trials, tolerance="low"), 'tolerance: found string "low"; allowed: a number'),
        (lambda: ub.fit(trials, false_positive_rate=True), "false_positive_rate: found True; allowed: a number"),
        (lambda: ub.fit(trials, false_positive_rate=1.5), "false_positive_rate: found 1.5; allowed: above 0 and below 1"),
        (lambda: ub.fit(trials, false_positive_rate=0.1, outlier_prior=0.5), "outlier_prior: found 0.5; allowed: at least 0"),
        (lambda: ub.fit(trials).classify(trials, decision=True), 'decision: found True; allowed: "argmax"'),
        (lambda: ub.fit(trials).classify(trials, decision=(True, 80.0)), 'decision: found .True, 80.0.; allowed: "argmax"'),
        (lambda: data.trials(by=True), "by: found True; allowed: taxel, component"),
        (lambda: data.trials(threshold_n=np.True_), "threshold_n: found boolean `true`; allowed: a number"),
        (lambda: ub.evaluate(trials, ub.Options(), jobs=2**70), "jobs: found 1180591620717411303424; allowed: a whole"),
        (lambda: ub.reach("leaf", seed=-1), "seed: found -1; allowed: a whole number from 0 to 18446744073709551615"),
    ):
        with pytest.raises(ub.InputError, match=text):
            call()


def data_with(option: str):
    def call(_: ub.Trials) -> None:
        ub.reach(ub.Scene("leaf").changed({"goals": {"count": 1}}), seed=1).trials(**{option: "no-such"})

    return call


def test_results_do_not_depend_on_threads(trials: ub.Trials) -> None:
    """Tests that fitting and evaluating give the same bits with one thread and with two."""
    one, two = (ub.fit(trials, states=4, jobs=jobs).to_json() for jobs in (1, 2))
    assert one == two
    assert ub.evaluate(trials, ub.Options(states=4), jobs=1) == ub.evaluate(trials, ub.Options(states=4), jobs=2)


def test_the_papers_thresholds_are_for_their_scores(trials: ub.Trials, tmp_path: Path, command) -> None:
    """Tests that decision="paper" gives the command line's verdicts on Viterbi scores of unscaled force, and is
    refused, with the reason, on all other scores, where its thresholds mean nothing."""
    table = tmp_path / "trials.parquet"
    trials.save(table)
    found = ub.evaluate(trials, ub.Options(states=5), decision="paper")
    assert found == command("evaluate", table, "--states", 5, "--decision", "paper")
    model = ub.fit(trials, states=5)
    assert set(model.classify(trials, decision="paper")) <= {"leaf", "trunk", "uncertain", "outlier"}
    for options, reason in (
        (ub.Options("logistic-taxel"), "not a hidden Markov model"),
        (ub.Options(states=5, score="forward"), "forward scores"),
        (ub.Options(recipe="modern", states=5, score="viterbi"), "scaled"),
    ):
        with pytest.raises(ub.InputError, match=reason):
            ub.evaluate(trials, options, decision="paper")
    with pytest.raises(ub.InputError, match="forward scores"):
        model.with_score("forward").classify(trials, decision="paper")
    # A model's own thresholds apply only to its own kind of score.
    chosen = ub.fit(trials, states=5, false_positive_rate=0.1)
    with pytest.raises(ub.InputError, match="other kind of score"):
        chosen.with_score("forward").classify(trials)
