"""Configurations at the targets, checked by the DH table and by measured clearances."""

import numpy as np
import pytest
from conftest import assert_gradient, points, random_q

from humanoid_rail import NativeKinematics, Robot, Sphere
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.paper import dh_table as dh

ARRIVED = 1e-7
"""What hands are brought to their targets to, m."""
OBSTACLES = tuple(Sphere(center=(x, y, 3.0), radius=0.3) for x in (-0.8, 0.8) for y in (-1.0, 1.5, 4.0))


def dh_hands(q: np.ndarray) -> np.ndarray:
    return np.asarray(dh.hands(q)).ravel()


def test_what_reaches_is_at_the_targets_and_clear(robot: Robot, rng: np.random.Generator) -> None:
    solver = InverseKinematics(robot, OBSTACLES)
    kinematics = NativeKinematics(robot, OBSTACLES)
    reached = 0
    tries = 60
    for _ in range(tries):
        targets = dh_hands(random_q(robot, rng))
        posture = solver.solve(random_q(robot, rng), points(targets), 0.05)
        assert (posture.q >= robot.lower).all()
        assert (posture.q <= robot.upper).all()
        assert posture.error == pytest.approx(np.linalg.norm(dh_hands(posture.q) - targets), abs=1e-9)
        measured = kinematics.measure(posture.q)
        clearance = min(measured.clearance.min(), measured.self_clearance.min())
        assert min(posture.clearance, 0.05) == pytest.approx(min(clearance, 0.05), abs=1e-6)
        if posture.reached:
            reached += 1
            assert np.linalg.norm(dh_hands(posture.q) - targets) <= ARRIVED + 1e-12
            assert clearance >= 0.05 - 1e-6
    assert reached >= tries / 3


def test_it_begins_near_where_it_ends(robot: Robot) -> None:
    """A small error takes a small change."""
    solver = InverseKinematics(robot, ())
    targets = dh_hands(robot.initial) + 0.01
    posture = solver.solve(robot.initial, points(targets), -np.inf)
    assert posture.reached
    assert np.linalg.norm(posture.q - robot.initial) < 0.05


def test_a_hand_without_a_task_is_free(robot: Robot) -> None:
    """The left target is out of reach for both: only the right hand is asked to arrive."""
    solver = InverseKinematics(robot, ())
    targets = dh_hands(robot.initial) + np.array([0.0, 0.0, 50.0, 0.1, 0.0, 0.1])
    assert not solver.solve(robot.initial, points(targets), -np.inf).reached
    posture = solver.solve(robot.initial, points(targets)[1:], -np.inf)
    assert posture.reached
    np.testing.assert_allclose(dh_hands(posture.q)[3:], targets[3:], atol=2 * ARRIVED)


def test_joints_stop_at_their_limits_and_others_make_up(robot: Robot) -> None:
    """Beyond the end of the rail the torso leans after the targets."""
    solver = InverseKinematics(robot, ())
    start = robot.initial.copy()
    start[0] = robot.upper[0] - 0.05
    targets = dh_hands(start) + np.array([0.0, 0.6, 0.0, 0.0, 0.6, 0.0])
    posture = solver.solve(start, points(targets), -np.inf)
    assert posture.reached
    assert posture.q[0] == pytest.approx(robot.upper[0], abs=1e-9)


def test_bad_arguments_are_refused(robot: Robot) -> None:
    solver = InverseKinematics(robot, ())
    for start in (np.zeros(3), np.full(12, np.nan)):
        with pytest.raises(ValueError, match="needs"):
            solver.solve(start, points(np.zeros(6)), 0.0)


def test_errors_of_tasks_come_with_their_jacobian(robot: Robot, rng: np.random.Generator) -> None:
    solver = InverseKinematics(robot, OBSTACLES)
    tasks = points(dh_hands(random_q(robot, rng)))
    for _ in range(5):
        q = random_q(robot, rng)
        error, jacobian = solver.evaluate(q, tasks)
        np.testing.assert_allclose(error, dh_hands(q) - np.ravel([task.target for task in tasks]), atol=1e-9)
        assert_gradient(lambda x: solver.evaluate(x, tasks)[0], jacobian, q)
