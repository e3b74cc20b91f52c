"""Starts at, and just beyond, a position limit."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest
from conftest import AHEAD

from humanoid_rail import InvalidInput, PointTask, Problem, Robot, Scene, load_robot, plan
from humanoid_rail.errors import checked_number, told_apart
from humanoid_rail.model.position_limits import ROUNDING

JOINT = 7


def start_beyond(robot: Robot, excess: float) -> np.ndarray:
    q = robot.initial.copy()
    q[JOINT] = robot.lower[JOINT] - excess
    return q


def planned(robot: Robot, q: np.ndarray) -> np.ndarray:
    return plan(robot, Scene(name="s", targets=AHEAD, initial=tuple(q))).q[0]


def posed(robot: Robot, q: np.ndarray) -> np.ndarray:
    return Problem(robot, Scene(name="s", targets=AHEAD), (PointTask("left", AHEAD["left"]),), q).q


@pytest.mark.parametrize("use", [planned, posed])
def test_rounding_beyond_a_limit_is_put_onto_it(robot: Robot, use: Callable[..., np.ndarray]) -> None:
    span = robot.upper[JOINT] - robot.lower[JOINT]
    for excess in (1e-15, 1e-12, 0.9 * ROUNDING * span):
        q = use(robot, start_beyond(robot, excess))
        assert q[JOINT] == robot.lower[JOINT]
        np.testing.assert_array_equal(np.delete(q, JOINT), np.delete(robot.initial, JOINT))


@pytest.mark.parametrize("excess", [1e-8, 1e-5, 0.3])
@pytest.mark.parametrize("use", [planned, posed])
def test_what_is_farther_beyond_is_refused_with_digits_that_tell(
    robot: Robot, use: Callable[..., np.ndarray], excess: float
) -> None:
    with pytest.raises(InvalidInput) as caught:
        use(robot, start_beyond(robot, excess))
    said = re.search(r"is (\S+); valid: a position within (\S+) to (\S+)", str(caught.value))
    value, low, high = map(float, said.groups())
    assert value < low < high


def test_the_robots_own_start_is_held_to_the_limits() -> None:
    robot = load_robot(waist_pitch_lower=1.2, waist_pitch_upper=1.5)
    with pytest.raises(InvalidInput, match=r"initial\[2\] \(waist_pitch\)"):
        plan(robot, Scene(name="s", targets=AHEAD))


@pytest.mark.parametrize(
    ("bound", "value"), [(-1.3089969389957472, -1.3089969389967473), (60.0, 60.0000001), (2**31 - 1, 2**31), (1.0, 2.0)]
)
def test_a_bound_is_told_from_a_value(bound: float, value: float) -> None:
    text = told_apart(bound, value)
    assert (float(text) < value) == (bound < value)
    assert float(text) != value
    with pytest.raises(InvalidInput) as caught:
        checked_number("x", max(bound, value), most=min(bound, value))
    assert float(str(caught.value).rsplit(" ", 1)[1]) < max(bound, value)
