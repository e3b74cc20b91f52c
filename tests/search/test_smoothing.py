"""Lengths, corners and timing of paths."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from humanoid_rail import Robot, load_robot
from humanoid_rail.kinematics.joint_limits import limit_violations, sampled
from humanoid_rail.kinematics.path_metric import path_length, path_quality, speed_units, turns
from humanoid_rail.search.smoothing import LONGEST_CUT, MAX_TURN, PIECE_TURN, round_corners, time_path

ROBOT = load_robot()
DT = 0.01


def always(_a: np.ndarray, _b: np.ndarray) -> bool:
    return True


def bent(robot: Robot, turn: float, length: float = 1.0) -> np.ndarray:
    """Return a path of two straight pieces, both of one length, with a turn in between."""
    a, b = np.eye(robot.n)[[3, 7]] * speed_units(robot) * length
    return np.array([robot.initial, robot.initial + a, robot.initial + a + np.cos(turn) * a + np.sin(turn) * b])


def test_length_and_turn_are_in_units_of_the_speed_limits(robot: Robot) -> None:
    path = bent(robot, 1.0, length=0.25)
    assert path_length(robot, path) == pytest.approx(0.5)
    np.testing.assert_allclose(turns(robot, path), [1.0])
    assert path_quality(robot, path).sharpest_turn == pytest.approx(1.0)
    assert path_quality(robot, path[:1]) == path_quality(robot, path[[0, 0]])
    assert path_quality(robot, path[:1]).length == 0.0


@pytest.mark.parametrize("turn", [0.2, 1.0, np.pi / 2, 2.5, 3.1])
def test_a_corner_becomes_a_curve(robot: Robot, turn: float) -> None:
    path = bent(robot, turn)
    rounded = round_corners(robot, path, always)
    np.testing.assert_array_equal(rounded[[0, -1]], path[[0, -1]])
    assert turns(robot, rounded).max() <= 1.25 * PIECE_TURN
    assert turns(robot, rounded).sum() == pytest.approx(turn)
    assert path_length(robot, rounded) < path_length(robot, path)
    from_corner = np.linalg.norm((rounded[1:-1] - path[1]) / speed_units(robot), axis=1)
    assert from_corner.max() <= LONGEST_CUT + 1e-9


def test_a_corner_is_cut_off_only_as_far_as_that_holds(robot: Robot) -> None:
    path = bent(robot, 1.5)
    units = speed_units(robot)

    def near(a: np.ndarray, b: np.ndarray) -> bool:
        """Only what stays on the two straight pieces, or within a millisecond of the corner."""
        on_path = [np.linalg.norm((q - path[1]) / units) < 1e-3 or abs(q - path[0])[7] < 1e-12 for q in (a, b)]
        return all(on_path) or min(abs(a[7] - path[0][7]), abs(b[7] - path[0][7])) > 1e-4

    rounded = round_corners(robot, path, near)
    curve = rounded[1:-1]
    assert len(curve) > 3
    assert np.linalg.norm((curve - path[1]) / units, axis=1).max() < LONGEST_CUT
    np.testing.assert_array_equal(round_corners(robot, path, lambda _a, _b: False), path)


def test_a_straight_way_takes_as_long_as_its_slowest_joint(robot: Robot) -> None:
    path = np.array([robot.initial, robot.initial + 0.3 * np.arange(robot.n) / robot.n])
    t, q = time_path(robot, path, DT)
    slowest = (abs(path[1] - path[0]) / robot.velocity_limit).max()
    assert t[-1] == pytest.approx(slowest)
    np.testing.assert_allclose(np.diff(t)[:-1], DT)
    np.testing.assert_allclose(q[[0, -1]], path)
    assert not limit_violations(robot, sampled(t, q))


def test_nothing_to_follow(robot: Robot) -> None:
    for path in (robot.initial[None], robot.initial[None].repeat(3, axis=0)):
        t, q = time_path(robot, path, DT)
        assert t.tolist() == [0.0]
        np.testing.assert_array_equal(q, robot.initial[None])


@given(st.integers(0, 2**32 - 1), st.integers(3, 7), st.sampled_from([0.02, 0.3, 1.0]))
def test_a_rounded_path_is_followed_within_limits_and_without_sharp_turns(seed: int, points: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    steps = rng.normal(scale=size, size=(points, ROBOT.n))
    path = np.clip(ROBOT.initial + np.cumsum(steps, axis=0), ROBOT.lower, ROBOT.upper)
    rounded = round_corners(ROBOT, path, always)
    t, q = time_path(ROBOT, rounded, DT)
    np.testing.assert_allclose(q[[0, -1]], path[[0, -1]])
    assert (np.diff(t) > 0).all()
    assert not limit_violations(ROBOT, sampled(t, q))
    assert turns(ROBOT, q).max(initial=0.0) <= MAX_TURN
