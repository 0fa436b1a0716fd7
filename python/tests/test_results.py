"""The dictionaries that calls return have the keys and values of their types."""

from __future__ import annotations

import types
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints, is_typeddict

import pytest

import underbrush as ub
from underbrush import results


def _check(value: Any, hint: Any, place: str) -> None:
    """Demands that a value has a type, down to the keys of dictionaries."""
    origin, arguments = get_origin(hint), get_args(hint)
    if hint is Any:
        return
    if is_typeddict(hint):
        hints = get_type_hints(hint)
        assert set(value) <= set(hints), f"{place} has further keys: {set(value) - set(hints)}"
        assert set(value) >= hint.__required_keys__, f"{place} lacks keys: {hint.__required_keys__ - set(value)}"
        for key, own in value.items():
            _check(own, hints[key], f"{place}.{key}")
    elif origin in (Union, types.UnionType):
        optional = [argument for argument in arguments if argument is not type(None)]
        assert len(optional) == 1, f"the check knows optional values only, not {hint}"
        if value is not None:
            _check(value, optional[0], place)
    elif origin is Literal:
        assert value in arguments, place
    elif origin is list:
        assert isinstance(value, list), place
        for index, own in enumerate(value):
            _check(own, arguments[0], f"{place}[{index}]")
    elif origin is dict:
        assert isinstance(value, dict), place
        for key, own in value.items():
            _check(own, arguments[1], f"{place}[{key!r}]")
    else:
        # A whole number is a number.
        assert isinstance(value, (int, float) if hint is float else hint), f"{place} is {value!r}"


@pytest.mark.parametrize(
    ("value", "hint"),
    [
        ({"low": 0.1}, results.Interval),
        ({"low": 0.1, "high": 1, "middle": 0.5}, results.Interval),
        ({"low": 0.1, "high": "1"}, results.Interval),
        ([{"low": None, "high": 1.0}], list[results.Interval]),
        ("moves", results.Mobility),
    ],
)
def test_the_check_finds_faults(value: Any, hint: Any) -> None:
    """Tests that a missing key, a further key and values of other types are found."""
    with pytest.raises(AssertionError):
        _check(value, hint, "value")


def test_reaches_and_data_sets_have_their_types(data: ub.Dataset) -> None:
    """Tests goals, objects, contacts and audit of a reach, and the list of reaches of a data set."""
    reach = data[0]
    assert reach.goals and reach.objects and reach.contacts and data.episodes
    _check(reach.goals, list[results.Goal], "goals")
    _check(reach.objects, list[results.SceneObject], "objects")
    _check(reach.contacts, list[results.Contact], "contacts")
    _check(reach.audit, results.Audit, "audit")
    _check(data.episodes, list[results.Episode], "episodes")


def test_verdicts_and_evaluations_have_their_types(data: ub.Dataset) -> None:
    """Tests the verdicts of a model of trials and of a touch model, and what evaluations of both return, also of trials without
    reaches and ground truth."""
    reaches = [data[index] for index in range(len(data))]
    trials = data.trials(labels="environment", min_samples=5)
    plain = ub.Trials.from_sequences(trials.sequences(), trials.categories)
    for own in (trials, plain):
        _check(ub.evaluate(own, ub.Options(states=2)), results.Evaluation, "evaluation")
    touch = ub.TouchModel.load(Path(__file__).parents[2] / "suites" / "touch.json")
    _check(touch.evaluate(reaches), results.TouchEvaluation, "touch evaluation")
    for online, has_objects in ((ub.fit(trials, states=2).online(data.skin, "forearm"), False), (touch.online(data.skin), True)):
        verdicts, objects = 0, 0
        for index in range(len(reaches[0])):
            found, touched = online.update(reaches[0].frame(index)), online.objects()
            _check(found, list[results.TaxelVerdict], "verdicts")
            _check(touched, list[results.TouchedObject], "objects")
            verdicts, objects = verdicts + len(found), objects + len(touched)
        assert verdicts > 0 and (objects > 0) == has_objects
