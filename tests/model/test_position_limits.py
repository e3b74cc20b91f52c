"""Starts at, and just beyond, a position limit."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from conftest import AHEAD

from humanoid_rail import InvalidInput, PointTask, Problem, Robot, Scene, load_robot, plan
from humanoid_rail.errors import checked_number, told_apart
from humanoid_rail.model.position_limits import SLIGHTLY, within_position_limits

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
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_what_is_slightly_beyond_a_limit_is_put_onto_it(robot: Robot, use: Callable[..., np.ndarray]) -> None:
    for excess in (1e-15, 1e-12, 1e-6, 0.99 * SLIGHTLY):
        q = use(robot, start_beyond(robot, excess))
        assert q[JOINT] == robot.lower[JOINT]
        np.testing.assert_array_equal(np.delete(q, JOINT), np.delete(robot.initial, JOINT))


@pytest.mark.parametrize("excess", [1e-12, 1e-5, 9e-4])
def test_what_is_put_onto_a_limit_is_said(robot: Robot, excess: float) -> None:
    with pytest.warns(
        UserWarning, match=rf"initial\[{JOINT}\] \(left_elbow_pitch\) is (\S+) rad beyond the lower limit"
    ) as said:
        planned(robot, start_beyond(robot, excess))
    number = re.search(r" is (\S+) rad beyond", str(said[0].message))
    assert float(number[1]) == pytest.approx(excess, rel=0.06)


def test_a_start_at_a_limit_is_no_matter(robot: Robot, recwarn: pytest.WarningsRecorder) -> None:
    planned(robot, start_beyond(robot, 0.0))
    assert not recwarn.list


def test_no_more_than_a_share_of_a_small_range_is_taken_to_the_limit(robot: Robot) -> None:
    lower, upper = np.array(robot.lower), np.array(robot.upper)
    lower[JOINT], upper[JOINT] = -0.005, 0.005
    narrow = replace(robot, lower=lower, upper=upper)
    with pytest.raises(InvalidInput, match=r"and up to 0\.0001 rad is taken to the limit"):
        within_position_limits(narrow, start_beyond(narrow, 2e-4), "start")


@pytest.mark.parametrize("excess", [1.01 * SLIGHTLY, 0.3])
@pytest.mark.parametrize("use", [planned, posed])
def test_what_is_farther_beyond_is_refused_with_digits_that_tell(
    robot: Robot, use: Callable[..., np.ndarray], excess: float
) -> None:
    with pytest.raises(InvalidInput) as caught:
        use(robot, start_beyond(robot, excess))
    said = re.search(
        r"is (\S+); valid: a position within (\S+) to (\S+) rad; it is (\S+) rad beyond", str(caught.value)
    )
    value, low, high, beyond = map(float, said.groups())
    assert value < low < high
    assert beyond == pytest.approx(excess, rel=0.01)


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
