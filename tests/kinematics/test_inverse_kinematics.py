"""Configurations at the targets, checked by the DH table and by measured clearances."""

import numpy as np
import pytest
from conftest import random_q
from humanoid_rail.planning.engines import get_engine

from humanoid_rail import Robot, Sphere
from humanoid_rail.kinematics.inverse_kinematics import ARRIVED
from humanoid_rail.paper import dh_table as dh

OBSTACLES = tuple(Sphere(center=(x, y, 3.0), radius=0.3) for x in (-0.8, 0.8) for y in (-1.0, 1.5, 4.0))


def dh_hands(q: np.ndarray) -> np.ndarray:
    return np.asarray(dh.hands(q)).ravel()


def test_what_reaches_is_at_the_targets_and_clear(robot: Robot, engine: str, rng: np.random.Generator) -> None:
    solver = get_engine(engine).inverse_kinematics(robot, OBSTACLES)
    kinematics = get_engine("native").kinematics(robot, OBSTACLES)
    reached = 0
    tries = 60 if engine == "native" else 8
    for _ in range(tries):
        targets = dh_hands(random_q(robot, rng))
        posture = solver.solve(random_q(robot, rng), targets, np.ones(6), 0.05)
        assert (posture.q >= robot.lower).all()
        assert (posture.q <= robot.upper).all()
        assert posture.error == pytest.approx(np.linalg.norm(dh_hands(posture.q) - targets), abs=1e-9)
        measured = kinematics.measure(posture.q)
        clearance = min(measured.clearance.min(), measured.self_clearance.min())
        assert min(posture.clearance, 0.05) == pytest.approx(min(clearance, 0.05), abs=1e-6)
        if posture.reaches(0.05):
            reached += 1
            assert np.linalg.norm(dh_hands(posture.q) - targets) <= ARRIVED + 1e-12
            assert clearance >= 0.05 - 1e-6
    assert reached >= tries / 3


def test_it_begins_near_where_it_ends(robot: Robot, engine: str) -> None:
    """A small error takes a small change."""
    solver = get_engine(engine).inverse_kinematics(robot, ())
    targets = dh_hands(robot.initial) + 0.01
    posture = solver.solve(robot.initial, targets, np.ones(6), -np.inf)
    assert posture.reaches(-np.inf)
    assert np.linalg.norm(posture.q - robot.initial) < 0.05


def test_a_hand_of_weight_0_is_free(robot: Robot, engine: str) -> None:
    """The left target is out of reach for both: only the right hand is asked to arrive."""
    solver = get_engine(engine).inverse_kinematics(robot, ())
    targets = dh_hands(robot.initial) + np.array([0.0, 0.0, 50.0, 0.1, 0.0, 0.1])
    weights = np.repeat([0.0, 1.0], 3)
    assert not solver.solve(robot.initial, targets, np.ones(6), -np.inf).reaches(-np.inf)
    posture = solver.solve(robot.initial, targets, weights, -np.inf)
    assert posture.reaches(-np.inf)
    np.testing.assert_allclose(dh_hands(posture.q)[3:], targets[3:], atol=2 * ARRIVED)


def test_joints_stop_at_their_limits_and_others_make_up(robot: Robot, engine: str) -> None:
    """Beyond the end of the rail the torso leans after the targets."""
    solver = get_engine(engine).inverse_kinematics(robot, ())
    start = robot.initial.copy()
    start[0] = robot.upper[0] - 0.05
    targets = dh_hands(start) + np.array([0.0, 0.6, 0.0, 0.0, 0.6, 0.0])
    posture = solver.solve(start, targets, np.ones(6), -np.inf)
    assert posture.reaches(-np.inf)
    assert posture.q[0] == pytest.approx(robot.upper[0], abs=1e-9)


def test_both_engines_find_the_same(robot: Robot, rng: np.random.Generator) -> None:
    solvers = [get_engine(name).inverse_kinematics(robot, OBSTACLES) for name in ("native", "python")]
    same = 0
    for _ in range(8):
        targets, start = dh_hands(random_q(robot, rng)), random_q(robot, rng)
        one, two = (solver.solve(start, targets, np.ones(6), 0.01) for solver in solvers)
        same += bool(np.allclose(one.q, two.q, atol=1e-6))
    # Where a joint is held or let go by a hair the two may part.
    assert same >= 6


def test_bad_arguments_are_refused_by_the_native_engine(robot: Robot) -> None:
    solver = get_engine("native").inverse_kinematics(robot, ())
    for start, targets, weights in (
        (np.zeros(3), np.zeros(6), np.ones(6)),
        (robot.initial, np.zeros(3), np.ones(6)),
        (robot.initial, np.zeros(6), np.ones(2)),
    ):
        with pytest.raises(ValueError, match="needs"):
            solver.solve(start, targets, weights, 0.0)
