"""Method objects: their options, what is said of bad ones, and budgets that decide instead of time."""

from __future__ import annotations

import pickle
from dataclasses import FrozenInstanceError, fields, replace
from inspect import signature
from typing import Any

import numpy as np
import pytest
from conftest import ROOT

from humanoid_rail import (
    Auto,
    GradientProjection,
    InvalidInput,
    Robot,
    SafeVelocity,
    Scene,
    State,
    Status,
    load_scene,
    plan,
    plan_many,
)
from humanoid_rail.planning.methods import METHODS, as_method

COMMON = {
    "gain",
    "c_mu",
    "c_kappa",
    "epsilon",
    "objectives",
    "tolerance",
    "dt",
    "max_time",
    "max_deviation",
    "max_tilt",
    "far_clearances",
}
OWN = {
    Auto: {
        "safety_distance",
        "damper_gain",
        "max_edge_checks",
        "max_planning_time",
        "seed",
        "optimise",
        "max_optimisation_steps",
    },
    SafeVelocity: {"safety_distance", "damper_gain", "equalities"},
    GradientProjection: {"rtol", "atol", "engine"},
}
EVERY = sorted(COMMON | set.union(*OWN.values()) | {"speed", "method"})


def test_names() -> None:
    assert {"auto": Auto, "qp": SafeVelocity, "gradient-projection": GradientProjection}.items() <= METHODS.items()
    for name, method in METHODS.items():
        assert as_method(name) == method()
        assert method.name == name
    mine = Auto(seed=3)
    assert as_method(mine) is mine


@pytest.mark.parametrize("method", OWN, ids=lambda method: method.name)
def test_each_method_has_its_own_options_and_no_others(method: Any) -> None:
    assert {field.name for field in fields(method)} == COMMON | OWN[method]
    assert set(method().options()) == COMMON | OWN[method]
    for option in EVERY:
        if option not in COMMON | OWN[method]:
            with pytest.raises(InvalidInput, match=f"{option} is 1; valid: one of the options of {method.__name__}"):
                method(**{option: 1})
    with pytest.raises(TypeError, match="positional"):
        method(1.0)


def test_an_option_that_is_misspelt_is_answered_with_the_one_that_is_meant() -> None:
    for make, said in (
        (lambda: Auto(sed=3), "sed is 3; .*; did you mean seed?"),  # type: ignore[call-arg]
        (lambda: SafeVelocity(safety_distanc=0.1), "did you mean safety_distance?"),  # type: ignore[call-arg]
        (lambda: GradientProjection(epsilom=0.7), "did you mean epsilon?"),  # type: ignore[call-arg]
        (lambda: replace(Auto(), sed=3), "did you mean seed?"),  # type: ignore[call-arg]
    ):
        with pytest.raises(InvalidInput, match=said.replace("?", "[?]")):
            make()
    assert list(signature(Auto).parameters) == [field.name for field in fields(Auto)]


@pytest.mark.parametrize("method", OWN, ids=lambda method: method.name)
def test_methods_are_frozen_values(method: Any) -> None:
    one = method(gain=(1, 2, 3, 4, 5, 6), dt=0.02)
    assert one == method(gain=[1, 2, 3, 4, 5, 6], dt=0.02) != method()
    assert hash(one) == hash(method(gain=np.arange(1, 7), dt=0.02))
    assert pickle.loads(pickle.dumps(one)) == one
    assert one.options()["gain"] == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    with pytest.raises(FrozenInstanceError):
        one.dt = 1.0


@pytest.mark.parametrize("method", ["magic", "", "Auto", None, 3, Auto, ["auto"], {"name": "auto"}, object()])
def test_what_is_no_method_is_named(robot: Robot, free: Scene, method: Any) -> None:
    for use in (as_method, lambda m: plan(robot, free, m), lambda m: plan_many(robot, [free], m, n_jobs=1)):
        with pytest.raises(InvalidInput, match=f"{', '.join(METHODS)}, or an object such as Auto") as caught:
            use(method)
        assert caught.value.field == "method"


@pytest.mark.parametrize("method", [plan, plan_many], ids=lambda function: function.__name__)
def test_options_are_those_of_methods_alone(robot: Robot, free: Scene, method: Any) -> None:
    for option in COMMON | {"seed", "engine", "max_planning_time"}:
        with pytest.raises(TypeError, match=option):
            method(robot, free if method is plan else [free], **{option: 1})


@pytest.mark.parametrize(
    ("method", "options", "field"),
    [
        *[(method, {"far_clearances": "yes"}, "far_clearances") for method in OWN],
        *[(method, {"tolerance": 0.0}, "tolerance") for method in OWN],
        *[(method, {"epsilon": -1.0}, "epsilon") for method in OWN],
        *[(method, {"objectives": 3}, "objectives") for method in OWN],
        (Auto, {"safety_distance": -0.1}, "safety_distance"),
        (Auto, {"damper_gain": np.nan}, "damper_gain"),
        (Auto, {"max_planning_time": -1.0}, "max_planning_time"),
        (Auto, {"max_planning_time": np.nan}, "max_planning_time"),
        (Auto, {"max_planning_time": "1"}, "max_planning_time"),
        (Auto, {"max_edge_checks": 2**31}, "max_edge_checks"),
        (Auto, {"max_edge_checks": 100.0}, "max_edge_checks"),
        (Auto, {"seed": 2**31}, "seed"),
        (GradientProjection, {"engine": "c++"}, "engine"),
        (GradientProjection, {"rtol": np.inf}, "rtol"),
    ],
)
def test_bad_options_are_named(method: Any, options: dict[str, Any], field: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        method(**options)
    assert caught.value.field == field


def test_a_trajectory_has_the_method_that_made_it(robot: Robot, free: Scene) -> None:
    for method in (Auto(seed=3), SafeVelocity(dt=0.05), GradientProjection(dt=0.05, engine="python")):
        trajectory = plan(robot, free, method)
        assert trajectory.method is method
        assert trajectory.engine == method.engine
        assert trajectory.summary()["method"] == {"name": method.name, **method.options()}


def test_a_tiny_planning_time_cuts_off_and_says_so(robot: Robot) -> None:
    deep = load_scene(min((ROOT / "scenes" / "dev").glob("deep-*")))
    for seconds in (1e-9, 1e-6):
        trajectory = plan(robot, deep, Auto(max_planning_time=seconds))
        assert trajectory.status is Status.PLANNING_TIMEOUT
        assert "max_planning_time" in trajectory.reason
        assert trajectory.found_by == ""
        assert trajectory.certified
        assert trajectory.limits_ok


def test_a_planning_time_that_suffices_changes_nothing(robot: Robot) -> None:
    shelf = load_scene(min((ROOT / "scenes" / "dev").glob("shelf-*")))
    endless, enough = plan(robot, shelf, Auto(seed=5)), plan(robot, shelf, Auto(seed=5, max_planning_time=1e6))
    np.testing.assert_array_equal(endless.q, enough.q)
    assert endless.search == enough.search


@pytest.mark.parametrize("checks", [1, 100, 300])
def test_a_small_budget_ends_stuck_after_as_many_checks(robot: Robot, checks: int) -> None:
    """Of a scene that has a path: only the number decides, and each time it decides the same."""
    deep = load_scene(min((ROOT / "scenes" / "dev").glob("deep-*")))
    one, two = (plan(robot, deep, Auto(max_edge_checks=checks)) for _ in range(2))
    assert one.status is two.status is Status.STUCK
    assert one.search == two.search
    assert one.search is not None
    assert checks <= one.search.checks <= checks + 10
    assert f"max_edge_checks = {checks}" in one.reason
    np.testing.assert_array_equal(one.q, two.q)
    assert one.certified


class Odd(Exception):
    """An error of the user's own."""


@pytest.mark.parametrize(
    "method",
    [Auto, SafeVelocity, GradientProjection, lambda **more: GradientProjection(engine="python", **more)],
    ids=["auto", "qp", "gradient-projection", "in Python"],
)
def test_errors_of_an_objective_come_out_as_they_are(robot: Robot, free: Scene, method: Any) -> None:
    """Also those that are raised only after a while, and by the kind that the engine raises itself."""
    for error in (Odd("of the objective"), RuntimeError("of the objective"), KeyError("objective")):
        asked = []

        def broken(state: State, error: Exception = error, asked: list[float] = asked) -> np.ndarray:
            asked.append(state.t)
            if len(asked) > 5:
                raise error
            return np.zeros(state.q.size)

        with pytest.raises(type(error)) as caught:
            plan(robot, free, method(objectives=[broken]))
        assert caught.value is error
        assert len(asked) == 6
        error.__traceback__ = None  # it would keep what called back alive, and that keeps `broken`
