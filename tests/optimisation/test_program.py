"""The quadratic program: its rows and its objective against what they stand for, by central differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import central_difference

from humanoid_rail.optimisation.program import (
    CALM,
    LARGEST_CHANGE,
    PENALTY,
    STEADY,
    Program,
    _bounds,
    _equalities,
    _inequalities,
    _objective,
    program,
)
from humanoid_rail.optimisation.rows import Clearances, Goal, Pass
from humanoid_rail.optimisation.spline import shortest_interval, weights

JOINTS, INTERVALS, TRUST = 3, 7, 0.2


def form_of(degree: int, is_goal_free: bool = True) -> Program:
    limits = (np.array([1.0, 1.0, np.inf]), np.array([2.0, 3.0, 4.0]), np.array([30.0, np.inf, 20.0]))[:degree]
    box = np.array([-2.0, -2.0, -0.5]), np.array([2.0, 0.4, 2.0])
    return program(degree, INTERVALS, limits, box, is_goal_free)


def control_of(form: Program, rng: np.random.Generator) -> tuple[np.ndarray, float]:
    control = rng.normal(size=(INTERVALS + form.degree, JOINTS))
    control[: form.degree], control[-form.degree :] = control[0], control[-1]
    return control, shortest_interval(control, form.limits)


def rows_of(form: Program, rng: np.random.Generator, count: int = 5) -> Clearances:
    first = rng.integers(0, form.free.shape[1] - form.degree, count)
    return Clearances(
        first, rng.uniform(size=(count, form.degree + 1)), rng.normal(size=count), rng.normal(size=(count, JOINTS))
    )


def excess(form: Program, control: np.ndarray, interval: float, rows: Clearances, x: np.ndarray) -> np.ndarray:
    """Return what has to be at most 0 after a change: the limits, without linearising, and the clearances."""
    change = x[:-2].reshape(-1, JOINTS)
    moved, later = control + form.free @ change, interval * (1.0 + x[-2])
    found = []
    for order, limit in enumerate(form.limits, start=1):
        share = (np.diff(moved, order, axis=0) / (limit * interval**order)).ravel()
        grown = (later / interval) ** order
        found += [share - grown, -share - grown]
    spares = [
        spare + gradient @ (weights @ change[first : first + len(weights)]) + x[-1]
        for first, weights, spare, gradient in zip(*rows, strict=True)
    ]
    return np.concatenate([*found, -np.array(spares)])


@pytest.mark.parametrize("degree", [2, 3])
@pytest.mark.parametrize("is_goal_free", [True, False])
def test_rows_are_tangents(degree: int, is_goal_free: bool, rng: np.random.Generator) -> None:
    form = form_of(degree, is_goal_free)
    control, interval = control_of(form, rng)
    rows = rows_of(form, rng)
    # So far away that no row can be left out, but those of joints without a limit.
    matrix, upper = _inequalities(form, control, interval, rows, 1e3)
    zero = np.zeros(form.changes + 2)
    values = excess(form, control, interval, rows, zero)
    slopes = central_difference(lambda x: excess(form, control, interval, rows, x), zero)
    limited = np.concatenate(
        [np.tile(np.isfinite(limit), 2 * (len(control) - k)) for k, limit in enumerate(form.limits, start=1)]
    )
    kept = np.append(limited, np.ones(len(rows.spare), bool))
    np.testing.assert_allclose(-upper, values[kept], atol=1e-12)
    np.testing.assert_allclose(matrix.toarray(), slopes[kept], atol=1e-8)


@pytest.mark.parametrize("degree", [2, 3])
def test_rows_that_are_left_out_hold_anyway(degree: int, rng: np.random.Generator) -> None:
    form = form_of(degree)
    control, interval = control_of(form, rng)
    nothing, trust = rows_of(form, rng, 0), 0.05
    matrix, upper = _inequalities(form, control, interval, nothing, trust)
    every, every_upper = _inequalities(form, control, interval, nothing, 1e3)
    assert 0 < matrix.shape[0] < every.shape[0]
    tried = 0
    for _ in range(200):
        x = np.zeros(form.changes + 2)
        x[:-2] = rng.choice([-trust, trust], form.changes) * rng.uniform()
        # The shortest interval that the rows allow.
        slack, rates = upper - matrix @ x, -matrix.toarray()[:, -2]
        x[-2] = max(-LARGEST_CHANGE, float((-slack / rates).max()))
        if x[-2] <= LARGEST_CHANGE:
            tried += 1
            assert (every @ x <= every_upper + 1e-9).all()
    assert tried > 50


def test_the_right_sides_never_exceed_the_limits(rng: np.random.Generator) -> None:
    """What keeps the rows keeps the limits: the tangent of a convex function is below it."""
    form = form_of(3)
    control, interval = control_of(form, rng)
    nothing = rows_of(form, rng, 0)
    matrix, upper = _inequalities(form, control, interval, nothing, 1e3)
    for _ in range(50):
        x = np.append(0.02 * rng.normal(size=form.changes), [0.0, 0.0])
        slack, rates = upper - matrix @ x, -matrix.toarray()[:, -2]
        x[-2] = float((-slack / rates).max())
        moved = control + form.free @ x[:-2].reshape(-1, JOINTS)
        assert shortest_interval(moved, form.limits) <= interval * (1.0 + x[-2]) * (1.0 + 1e-12)


@pytest.mark.parametrize("degree", [2, 3])
def test_the_objective(degree: int, rng: np.random.Generator) -> None:
    form = form_of(degree)
    control, interval = control_of(form, rng)
    matrix, linear = _objective(form, control, interval, TRUST)

    def objective(x: np.ndarray) -> np.ndarray:
        change = x[:-2].reshape(-1, JOINTS)
        shares = np.diff(control + form.free @ change, 2, axis=0) / (form.limits[1] * interval**2)
        calm = CALM * (shares**2).mean()
        steady = STEADY * ((change / TRUST) ** 2).mean() + STEADY * (x[-2] ** 2 + x[-1] ** 2)
        return np.array([0.5 * calm + 0.5 * steady + x[-2] + PENALTY * x[-1]])

    for x in (np.zeros(form.changes + 2), 0.1 * rng.normal(size=form.changes + 2)):
        slope = central_difference(objective, x, 1e-5)[0]
        np.testing.assert_allclose(matrix @ x + linear, slope, atol=1e-8)
    assert np.linalg.eigvalsh(matrix.toarray()).min() > 0.0


def test_bounds_and_the_tasks_at_the_goal(rng: np.random.Generator) -> None:
    form = form_of(2)
    control, _ = control_of(form, rng)
    lower, upper = _bounds(form, control, TRUST)
    moved = control[form.free.argmax(axis=0)].ravel()
    assert (lower >= -LARGEST_CHANGE).all()
    assert (upper[:-2] <= TRUST).all()
    beyond = np.tile(form.box[1], len(moved) // JOINTS)
    assert (moved + upper[:-2] <= np.maximum(beyond, moved) + 1e-12).all()
    goal = Goal(rng.normal(size=2), rng.normal(size=(2, JOINTS)))
    matrix, wanted = _equalities(form, goal, [])
    x = rng.normal(size=form.changes + 2)
    at_goal = (form.free @ x[:-2].reshape(-1, JOINTS))[-1]
    np.testing.assert_allclose(matrix @ x - wanted, goal.error + goal.jacobian @ at_goal)


@pytest.mark.parametrize("degree", [2, 3])
@pytest.mark.parametrize("is_goal_free", [True, False])
def test_rows_at_waypoints_are_tangents(degree: int, is_goal_free: bool, rng: np.random.Generator) -> None:
    """The errors after a change of control points, interval, slack and moments, without linearising."""
    form = replace(form_of(degree, is_goal_free), passed=2)
    control, _ = control_of(form, rng)
    moments, bends = np.array([2.6, 4.3]), rng.normal(size=(2, 2, JOINTS))

    def error(number: int, q: np.ndarray) -> np.ndarray:
        return np.sin(bends[number] @ q)

    def errors(x: np.ndarray) -> np.ndarray:
        moved = control + form.free @ x[: form.changes].reshape(-1, JOINTS)
        there = weights(degree, INTERVALS, moments + x[form.changes + 2 :]) @ moved
        return np.concatenate([error(number, q) for number, q in enumerate(there)])

    here, rates = weights(degree, INTERVALS, moments), np.diff(control, axis=0)
    at, speeds = here @ control, weights(degree - 1, INTERVALS, moments) @ rates
    passes = []
    for number in range(2):
        jacobian = np.cos(bends[number] @ at[number])[:, None] * bends[number]
        row = here[number] @ form.free
        passes.append(Pass(row, error(number, at[number]), jacobian, jacobian @ speeds[number], -0.1, 0.2))
    goal = Goal(rng.normal(size=1), rng.normal(size=(1, JOINTS))) if is_goal_free else None
    matrix, wanted = _equalities(form, goal, passes)
    assert matrix.shape == (4 + is_goal_free, form.unknowns)
    slopes = central_difference(errors, np.zeros(form.unknowns))
    np.testing.assert_allclose(matrix.toarray()[:4], slopes, atol=1e-8)
    np.testing.assert_allclose(-wanted[:4], errors(np.zeros(form.unknowns)))
    assert (abs(slopes[:, form.changes + 2 :]).max(axis=0) > 0.1).all()
    lower, upper = _bounds(form, control, TRUST, passes)
    np.testing.assert_array_equal(lower[-2:], [-0.1, -0.1])
    np.testing.assert_array_equal(upper[-2:], [0.2, 0.2])


@pytest.mark.parametrize("degree", [2, 3])
def test_a_step_keeps_all_of_it(degree: int, rng: np.random.Generator) -> None:
    form = form_of(degree)
    control = np.linspace(0.0, 1.0, INTERVALS + degree)[:, None] * np.array([0.3, 0.1, -0.2])
    control[:degree], control[-degree:] = control[0], control[-1]
    interval = shortest_interval(control, form.limits)
    rows = rows_of(form, rng)._replace(spare=np.full(5, 0.05))
    goal = Goal(np.array([0.01]), np.array([[1.0, 0.5, 0.0]]))
    step = form.step(control, interval, rows, goal, TRUST)
    assert step is not None
    moved = control + step.change
    assert abs(step.change).max() <= TRUST + 1e-4
    assert step.merit < 0.98
    assert shortest_interval(moved, form.limits) <= interval * (step.merit + 1e-3)
    np.testing.assert_allclose(goal.error + goal.jacobian @ step.change[-1], 0.0, atol=1e-4)
    assert (step.change[:degree] == 0.0).all()
    assert (step.change[-degree:] == step.change[-1]).all()
    assert form.step(control, interval, rows, goal, TRUST).change.tobytes() == step.change.tobytes()
