"""Verdicts frame by frame."""

import json
import pickle
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest
from sklearn.linear_model import LogisticRegression

import underbrush as ub
from underbrush.sklearn import FixedWindow


SUITES = Path(__file__).parents[2] / "suites"
POSTS = """summary = "Posts in the way of the arm"
[goals]
count = 1
retries = 0
x_m = { uniform = [0.60, 0.72] }
[[objects.trunk]]
count = 6
category = "post"
diameter_m = 0.06
place = { x_m = { uniform = [0.25, 0.50] }, y_m = { uniform = [-0.50, -0.15] } }
"""


def stream(online: ub.Online, reach: ub.Reach) -> list[list[dict]]:
    return [online.update(reach.frame(index)) for index in range(len(reach))]


def test_online_scores_are_those_of_trials(data: ub.Dataset) -> None:
    """Tests that after k samples of a contact, the scores equal those of the first k samples of its trial, bit for
    bit."""
    trials = data.trials()
    model = ub.fit(trials, states=4)
    reach = data[0]
    own = reach.trials()
    contacts = {trial.taxel: place for place, trial in enumerate(own)}
    checked = 0
    found = stream(model.online(data.skin, "forearm"), reach)
    for frame, time_s in zip(found, reach.time_s, strict=True):
        for taxel in frame:
            place = contacts[taxel["taxel"]]
            if own[place].time_s[0] <= time_s <= own[place].time_s[-1]:
                expected = model.scores_after(own, place, [taxel["samples"]])[0]
                assert [taxel["scores"][name] for name in model.categories] == list(expected)
                checked += 1
    assert checked > 50


def test_a_trial_beyond_the_list_is_refused(trials: ub.Trials) -> None:
    """Tests that no number of a trial beyond the list is taken for one that counts from the end."""
    model = ub.fit(trials, states=3)
    for number in (len(trials), 2**64 - 1):
        with pytest.raises((IndexError, OverflowError)):
            model.scores_after(trials, number, [1])


def test_frames_of_an_own_robot(data: ub.Dataset) -> None:
    """Tests that frames built from arrays, as for a real robot, and pickled give the verdicts of the recorded
    frames."""
    model = ub.fit(data.trials(), states=4, features="force,motion")
    reach = data[1]
    recorded, built = model.online(data.skin), model.online(data.skin)
    felt = 0
    for index in range(len(reach)):
        frame = reach.frame(index)
        own = ub.Frame(
            data.skin,
            frame.time_s,
            {name: frame.sensed_force_n(name) for name in data.skin.patches},
            {name: frame.patch_pose_world(name) for name in data.skin.patches},
        )
        verdicts = recorded.update(frame)
        assert built.update(pickle.loads(pickle.dumps(own))) == verdicts
        felt += len(verdicts)
    assert felt > 0


def test_given_quaternions_are_normalized(data: ub.Dataset) -> None:
    """Tests that a frame normalizes a quaternion with three digits, and keeps one of unit length bit for bit."""

    def kept(quaternion: list[float]) -> np.ndarray:
        return ub.Frame(data.skin, 0.0, {}, {"forearm": [0, 0, 0, *quaternion]}).patch_pose_world("forearm")[3:]

    assert abs(np.linalg.norm(kept([0.0, 0.0, 0.707, 0.707])) - 1.0) < 1e-15
    assert list(kept([0.0, 0.0, 0.6, 0.8])) == [0.0, 0.0, 0.6, 0.8]


def test_scikit_learn_classifies_online(data: ub.Dataset) -> None:
    """Tests that a scikit-learn classifier gives the same scores in a stream as when it is called with the samples so
    far."""
    trials = data.trials(min_samples=5)
    fitted = FixedWindow(LogisticRegression(max_iter=300), samples=10).fit_trials(trials)
    # The draws decide which reach touches the forearm most.
    reach = max(data, key=lambda one: sum(len(trial.time_s) for trial in one.trials()))
    online = ub.online(fitted, data.skin, "forearm")
    own = reach.trials()
    contacts = {trial.taxel: place for place, trial in enumerate(own)}
    checked = 0
    for frame, time_s in zip(stream(online, reach), reach.time_s, strict=True):
        for taxel in frame:
            trial = own[contacts[taxel["taxel"]]]
            if trial.time_s[0] <= time_s <= trial.time_s[-1]:
                so_far = ub.Trials.from_sequences([trial.force_n[: taxel["samples"]]])
                assert np.allclose([taxel["scores"][name] for name in fitted.categories], fitted.scores(so_far)[0])
                checked += 1
    assert checked > 50


def test_a_classifier_that_raises_is_heard(data: ub.Dataset) -> None:
    """Tests that an exception of a Python classifier reaches the caller of `update`, and that later frames get their verdicts."""

    class Broken:
        categories = ["leaf", "trunk"]
        is_broken = False

        def scores(self, given: ub.Trials) -> np.ndarray:
            if self.is_broken:
                raise LookupError("no scores")
            return np.tile([0.0, -1.0], (len(given), 1))

    broken = Broken()
    expected, online = stream(ub.online(broken, data.skin), data[0]), ub.online(broken, data.skin)
    first = next(number for number, verdicts in enumerate(expected) if verdicts)
    for number, verdicts in enumerate(expected):
        broken.is_broken = number == first
        if broken.is_broken:
            with pytest.raises(LookupError, match="no scores"):
                online.update(data[0].frame(number))
        else:
            assert online.update(data[0].frame(number)) == verdicts


def test_touch_models_judge_frames(data: ub.Dataset, tmp_path, command) -> None:
    """Tests that a touch model fitted from Python equals the command line's file, that a pickled model gives the same
    verdicts, that its probabilities of the categories and of nothing add up to 1, and that it tells the stiffness of objects."""
    model = ub.TouchModel.fit(list(data))
    command("train", data.path, "--classifier", "touch", "--out", tmp_path / "touch.json")
    assert model.to_json() == (tmp_path / "touch.json").read_text()
    reach = data[0]
    first = stream(model.online(data.skin), reach)
    assert stream(pickle.loads(pickle.dumps(model)).online(data.skin), reach) == first
    taxels = [taxel for frame in first for taxel in frame]
    assert taxels
    assert {own["verdict"] for own in taxels} <= {"nothing", "leaf", "trunk", "uncertain", "unknown"}
    sums = [own["nothing"] + sum(own["probabilities"].values()) for own in taxels]
    assert np.allclose(sums, 1.0, rtol=0, atol=1e-12)
    felt = []
    for own in data:
        online = model.online(data.skin)
        stream(online, own)
        felt += online.objects()
    judged = [own["stiffness"] for own in felt if "stiffness" in own]
    assert judged and all(own["low_n_per_m"] < own["median_n_per_m"] < own["high_n_per_m"] for own in judged)
    assert {own["mobility"] for own in felt} <= {"holds", "gives-way", "comes-back", "stays"}
    with pytest.raises(ub.InputError, match="2 reaches"):
        ub.TouchModel.fit([reach])


def test_auxiliary_reaches_are_unknown_objects(data: ub.Dataset, tmp_path, command) -> None:
    """Tests that a model fitted with auxiliary reaches equals the command line's, but for the names of its sources, that
    they are among its sources, that too few known objects to call anything unknown are warned of, that reaches that are fitted to
    are refused as auxiliary ones, and that cross-validation with them gives the command line's figures."""
    scene = tmp_path / "posts.toml"
    scene.write_text(POSTS)
    posts = ub.generate([scene], 16, tmp_path / "posts", seed=2, progress=False)
    expected = "^the model calls nothing unknown, .* or give the commands classify and evaluate a larger --unknown-share$"
    with pytest.warns(UserWarning, match=expected):
        model = ub.TouchModel.fit(list(data), auxiliary=list(posts))
    file = tmp_path / "touch.json"
    command("train", data.path, "--classifier", "touch", "--auxiliary", posts.path, "--out", file)
    own, other = json.loads(model.to_json()), json.loads(file.read_text())
    assert own["unknown_objects"] == other["unknown_objects"] and own["unknown_objects"]["families"][0]["name"] == "post"
    assert "posts" in json.dumps(own["provenance"])
    with pytest.raises(ub.InputError, match="reaches: found the same data twice"):
        ub.TouchModel.fit(list(data), auxiliary=list(data))
    judged = ub.TouchModel.cross_validate(data, auxiliary=posts, folds=3)
    assert judged["reaches"] == len(data) + len(posts)
    assert judged == command("evaluate", data.path, "--classifier", "touch", "--folds", 3, "--auxiliary", posts.path)


def test_model_files_of_the_other_kind_are_named(data: ub.Dataset, tmp_path) -> None:
    """Tests that reading a touch model as a classifier of trials, or the other way round, is refused with what the file
    is and which call reads it."""
    touch, own = ub.TouchModel.fit(list(data)), ub.fit(data.trials(), states=2)
    kinds = (
        (touch, ub.Model, "underbrush-touch/1, a touch model", "underbrush-model/1", "TouchModel.load"),
        (own, ub.TouchModel, "underbrush-model/1, a classifier of trials", "underbrush-touch/1", "Model.load"),
    )
    for model, other, found, allowed, call in kinds:
        file = tmp_path / "model.json"
        model.save(file, force=True)
        for place, read in ((str(file), lambda: other.load(file)), ("the model", lambda: other.from_json(model.to_json()))):
            with pytest.raises(ub.InputError) as refused:
                read()
            error = refused.value
            assert (error.file, error.field, error.found, error.allowed) == (place, "format", found, allowed)
            assert f" {call} " in str(error.remedy)


def test_models_are_sealed_and_say_where_they_come_from(data: ub.Dataset, tmp_path) -> None:
    """Tests that models of both kinds name the data set that they were fitted to, that a changed file is refused, and
    that one without a seal gives a Python warning."""
    for model, kind in ((ub.TouchModel.fit(list(data)), ub.TouchModel), (ub.fit(data.trials(), states=2), ub.Model)):
        source = model.provenance["data"][0]
        assert (source["kind"], source["name"]) == ("data-set", data.path.name)
        assert sum(source["reaches"].values()) == len(data)
        file = json.loads(model.to_json())
        file["categories" if kind is ub.TouchModel else "comment"] = ["leaf", "trunl"]
        with pytest.raises(ub.InputError, match="blake3"):
            kind.from_json(json.dumps(file))
        del file["blake3"]
        with pytest.warns(UserWarning, match="no seal"):
            kind.from_json(json.dumps(file))


def test_limits_of_risk_choose_the_decision(data: ub.Dataset, tmp_path, command) -> None:
    """Tests that a model fitted within limits of risk equals the command line's, and that too few reaches for a limit, and limits that
    are not possible, are refused before any reach is read."""
    model = ub.TouchModel.fit(list(data), limit_wrong=0.4)
    command("train", data.path, "--classifier", "touch", "--limit-wrong", "0.4", "--out", tmp_path / "touch.json")
    assert model.to_json() == (tmp_path / "touch.json").read_text()
    assert model.decision != ub.TouchModel.fit(list(data)).decision
    damaged = tmp_path / "damaged.parquet"
    damaged.write_text("no recording")
    for call in (ub.TouchModel.fit, ub.TouchModel.cross_validate):
        with pytest.raises(ub.InputError, match="reaches or more"):
            call([*data, damaged], limit_wrong=0.01)
        with pytest.raises(ub.InputError, match="limit_wrong: found 1.5; allowed: a share above 0 and below 1"):
            call([*data, damaged], limit_wrong=1.5)


def test_touch_models_are_evaluated_as_by_the_command_line(data: ub.Dataset, tmp_path, command) -> None:
    """Tests that judging a touch model, and cross-validating touch models with one thread and with two, give the
    command line's figures, and that numbers of folds that are not possible are refused."""
    reaches = list(data)
    model = ub.TouchModel.fit(reaches)
    model.save(tmp_path / "touch.json")
    assert model.evaluate(reaches) == command("evaluate", data.path, "--model", tmp_path / "touch.json")
    judged = ub.TouchModel.cross_validate(reaches, folds=3, jobs=1)
    assert judged["folds"] == 3
    assert judged == ub.TouchModel.cross_validate(reaches, folds=3, jobs=2)
    assert judged == command("evaluate", data.path, "--classifier", "touch", "--folds", 3)
    # Neither one nor nine folds are possible. With leaves in one reach alone, one of five folds leaves none to fit to.
    leaves, trunks = ([one for one in reaches if one.scene == f"{name}-quick"] for name in ("leaf", "trunk"))
    most = max(leaves, key=lambda one: sum(len(trial.time_s) for trial in one.trials()))
    for given, folds, reason in (
        (reaches, 1, "at least 2"),
        (reaches, 9, "fewer than the 9 folds"),
        ([most, *trunks], 5, "only trunk"),
    ):
        with pytest.raises(ub.InputError, match=reason):
            ub.TouchModel.cross_validate(given, folds=folds)


def test_no_reach_counts_twice(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that a reach that is given twice, also as a copy of its data set or its file, loaded or pickled, is refused: it would be in
    training and test at once."""
    copied = shutil.copytree(data.path, tmp_path / "copied")
    for name in ("once", "again"):
        data[0].save(tmp_path / f"{name}.parquet")
    files = [tmp_path / "once.parquet", tmp_path / "again.parquet"]
    loaded = [ub.Reach.load(file) for file in files]
    model = ub.TouchModel.load(SUITES / "touch.json")
    pickled = pickle.loads(pickle.dumps(loaded[0]))
    both = [files[0], loaded[1]], [loaded[0], pickled], [files[1], pickled]
    for again in ([*data, data[0]], [data.path, copied], [*data, ub.Dataset(copied)[3]], files, loaded, *both):
        for call in (ub.TouchModel.fit, ub.TouchModel.cross_validate, model.evaluate):
            with pytest.raises(ub.InputError, match="reaches: found the same data twice"):
                call(again)


def test_a_touch_model_of_the_same_reaches_is_warned_of(data: ub.Dataset) -> None:
    """Tests that a touch model that judges reaches that it was fitted to, or a part of them, is warned of, but not one that judges other
    reaches of the same data set."""
    model = ub.TouchModel.fit(data)
    for given in (data, data[:1]):
        with pytest.warns(UserWarning, match="^reaches: the model was fitted to these data"):
            model.evaluate(given)
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("always")
        ub.TouchModel.fit(data[1:]).evaluate(data[:1])
    assert not any("these data" in str(own.message) for own in shown)


def test_a_folder_of_recordings_stands_for_them(data: ub.Dataset, tmp_path: Path, command) -> None:
    """Tests that touch models and the replay page take a folder of recordings and paths as the command line does, and that
    other objects, and a patch without a model, are refused."""
    folder, touch, page = tmp_path / "felt", tmp_path / "touch.json", tmp_path / "page.html"
    folder.mkdir()
    for index, reach in enumerate(data):
        reach.save(folder / f"reach-{index}.parquet")
    model = ub.TouchModel.fit(folder)
    command("train", folder, "--classifier", "touch", "--out", touch)
    assert model.to_json() == ub.TouchModel.fit(sorted(folder.iterdir())).to_json() == touch.read_text()
    loaded = [ub.Reach.load(file) for file in sorted(folder.iterdir())]
    assert model.to_json() == ub.TouchModel.fit(loaded).to_json()
    assert ub.TouchModel.fit(str(data.path)).to_json() == ub.TouchModel.fit(data).to_json()
    assert model.evaluate(folder) == command("evaluate", folder, "--model", touch)
    judged = ub.TouchModel.cross_validate(folder, folds=3)
    assert judged == command("evaluate", folder, "--classifier", "touch", "--folds", 3)
    command("replay", folder, "--out", page)
    assert ub.replay(folder).html == page.read_text()
    with pytest.raises(ub.InputError, match="patch: found given without model"):
        ub.replay(folder, patch="forearm")
    for wrong in (3, [3], [data]):
        with pytest.raises(ub.InputError, match="argument: reaches: found an object of type .*; allowed: a Dataset"):
            ub.TouchModel.fit(wrong)  # type: ignore[arg-type]


def test_fitting_keeps_no_reaches_in_memory(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that reaches of a data set that a touch model was fitted to are read again when they are needed."""
    copied = shutil.copytree(data.path, tmp_path / "copied")
    reaches = list(ub.Dataset(copied))
    ub.TouchModel.fit(reaches)
    shutil.rmtree(copied / "data")
    with pytest.raises((ub.InputError, ub.RunError)):
        reaches[0].frame(0)


def test_bad_frames_are_refused(data: ub.Dataset) -> None:
    """Tests that a frame of another skin, of a wrong shape, with NaN, or without a pose that is needed is refused."""
    model = ub.fit(data.trials(), states=2)
    assert model.online(data.skin).update(ub.Frame(data.skin, 0.0, {})) == []
    moving = ub.fit(data.trials(), states=2, features="force,motion")
    for classifier in (moving, ub.TouchModel.fit(list(data))):
        with pytest.raises(ub.InputError, match="no pose of the patch forearm"):
            classifier.online(data.skin).update(ub.Frame(data.skin, 0.0, {}))
    own = FixedWindow(LogisticRegression(max_iter=300), features="force,motion").fit_trials(data.trials())
    with pytest.raises(ub.InputError, match="no pose of the patch forearm"):
        ub.online(own, data.skin).update(ub.Frame(data.skin, 0.0, {}))
    with pytest.raises(ub.InputError, match="quaternion of length 2"):
        ub.Frame(data.skin, 0.0, {}, {"forearm": [0, 0, 0, 0, 0, 0, 2]})
    other = ub.Skin._from_json('{"patches": []}')
    with pytest.raises(ub.InputError, match="another skin"):
        model.online(data.skin).update(ub.Frame(other, 0.0, {}))
    with pytest.raises(ub.InputError, match=r"shape \(3\)"):
        ub.Frame(data.skin, 0.0, {"forearm": np.zeros(3)})
    with pytest.raises(ub.InputError, match="NaN"):
        ub.Frame(data.skin, 0.0, {"forearm": np.full(384, np.nan)})
    with pytest.raises(ub.InputError, match="masked"):
        ub.Frame(data.skin, 0.0, {"forearm": np.ma.masked_greater(np.full(384, 1e5), 1e4)})
    with pytest.raises(ub.InputError, match="hand"):
        model.online(data.skin, "hand")
    for time_s in (float("nan"), 1e11):
        with pytest.raises(ub.InputError, match="allowed: -1e10 to 1e10 s"):
            ub.Frame(data.skin, time_s, {})
    with pytest.raises(ub.InputError, match="coordinate 1e300 of the patch forearm; allowed: -1e8 to 1e8 m"):
        ub.Frame(data.skin, 0.0, {}, {"forearm": [1e300, 0, 0, 0, 0, 0, 1]})
    for force_n in (-0.01, 1.1e4):
        forces = np.zeros(384)
        forces[7] = force_n
        with pytest.raises(ub.InputError, match=f"{force_n:.10g} N on taxel 7 of the patch forearm; allowed: 0 to 10000 N"):
            ub.Frame(data.skin, 0.0, {"forearm": forces})


def test_frames_must_follow_each_other(data: ub.Dataset) -> None:
    """Tests that a frame that is given twice, or after a later one, is refused, counts nothing and leaves the next
    good one its verdicts."""
    forces = np.zeros(384)
    forces[3] = 2.0
    pose = {name: [0, 0, 0, 0, 0, 0, 1] for name in data.skin.patches}

    def frame(time_s: float) -> ub.Frame:
        return ub.Frame(data.skin, time_s, {"forearm": forces}, pose)

    for online in (ub.fit(data.trials(), states=2).online(data.skin), ub.TouchModel.fit(list(data)).online(data.skin)):
        online.update(frame(1.0))
        for time_s in (1.0, 0.5):
            with pytest.raises(ub.InputError, match=f"the time {time_s:g} s; allowed: a later time than 1 s"):
                online.update(frame(time_s))
        assert [own["samples"] for own in online.update(frame(1.01)) if own["taxel"] == 3] == [2]
