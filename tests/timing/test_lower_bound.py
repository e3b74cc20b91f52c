"""The least durations: closed forms, an integrated profile, and motions that were planned."""

from __future__ import annotations

import numpy as np
import pytest

from humanoid_rail import Robot, Scene, plan, retime
from humanoid_rail.planning.methods import Auto
from humanoid_rail.timing.lower_bound import least_duration, least_duration_along, least_times


@pytest.mark.parametrize(
    ("way", "velocity", "acceleration", "expected"),
    [
        (1.0, 1.0, 2.0, 1.5),  # half a second up, half a second at full speed, half a second down
        (-1.0, 1.0, 2.0, 1.5),
        (0.5, 1.0, 2.0, 1.0),  # the limit of velocity is just reached
        (0.02, 1.0, 2.0, 0.2),
        (3.0, np.inf, 3.0, 2.0),
        (3.0, 1.5, np.inf, 2.0),
        (3.0, np.inf, np.inf, 0.0),
        (0.0, 0.0, 0.0, 0.0),
        (0.0, np.inf, np.inf, 0.0),
    ],
)
def test_closed_forms(way: float, velocity: float, acceleration: float, expected: float) -> None:
    found = least_times(np.array([way]), np.array([velocity]), np.array([acceleration]))
    assert found == pytest.approx(expected)


def test_the_fastest_profile_gets_there_just_in_time(rng: np.random.Generator) -> None:
    """Going as fast as both ends and the limit of velocity let it, a joint covers its way, and no more."""
    for way, velocity, acceleration in np.exp(rng.uniform(-2.0, 2.0, (20, 3))):
        (duration,) = least_times(np.array([way]), np.array([velocity]), np.array([acceleration]))
        t = np.linspace(0.0, duration, 20_001)
        speed = np.minimum(velocity, acceleration * np.minimum(t, duration - t))
        assert np.trapezoid(speed, t) == pytest.approx(way, rel=1e-6)


def test_the_slowest_joint_counts_and_rests_add_up() -> None:
    stops = np.array([[0.0, 0.0], [1.0, 0.5], [1.0, 0.0]])
    assert least_duration(stops, np.ones(2), np.full(2, 2.0)) == pytest.approx(1.5 + 1.0)
    assert least_duration(stops[:1], np.ones(2), np.full(2, 2.0)) == 0.0


def test_a_joint_that_turns_back_rests_there() -> None:
    path = np.array([[0.0], [0.4], [1.0], [1.0], [0.6], [0.0]])
    bound = least_duration_along(path, np.array([1.0]), np.array([2.0]), np.array([0.0]))
    assert bound == pytest.approx(3.0)
    near = least_duration_along(path, np.array([1.0]), np.array([2.0]), np.array([0.1]))
    assert near == pytest.approx(2 * 1.3)


def test_no_retimed_motion_is_shorter(robot: Robot, scene: Scene) -> None:
    planned = plan(robot, scene, Auto(optimise=False))
    stray = 0.015 * robot.speed_units
    bound = least_duration_along(planned.q, robot.velocity_limit, robot.acceleration_limit, stray)
    motion = retime(planned)
    assert 0.5 * motion.duration < bound < motion.duration
    assert motion.least_duration is not None
    assert 0.5 * motion.duration < motion.least_duration < motion.duration
