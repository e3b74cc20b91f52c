"""Whether a straight way keeps a distance, against clearances measured along it."""

import numpy as np
import pytest
from conftest import random_q

from humanoid_rail import Box, HalfSpace, NativeKinematics, Robot, Sphere
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.scene.obstacles import Obstacle

DISTANCE = 0.02
RESOLUTION = 3e-3
"""A way may be turned down although it keeps the distance by this much, m."""


def cluttered(rng: np.random.Generator) -> tuple[Obstacle, ...]:
    boxes = [
        Box(center=tuple(rng.uniform((-2, -3, 1), (2, 5, 5))), size=tuple(rng.uniform(0.05, 1.0, 3)), rpy=(0.3, 0.2, 1))
        for _ in range(3)
    ]
    spheres = [Sphere(center=tuple(rng.uniform((-2, -3, 1), (2, 5, 5))), radius=0.3) for _ in range(3)]
    return (*boxes, *spheres, HalfSpace(normal=(0.0, 0.1, 1.0), offset=-0.2))


def least(kinematics: Kinematics, q: np.ndarray) -> float:
    measured = kinematics.measure(q)
    return min(measured.clearance.min(initial=np.inf), measured.self_clearance.min(initial=np.inf))


def test_a_way_holds_where_its_samples_do(robot: Robot, rng: np.random.Generator) -> None:
    held = failed = 0
    for _ in range(150):
        obstacles = cluttered(rng)
        kinematics = NativeKinematics(robot, obstacles)
        checker = EdgeChecker(robot, obstacles, DISTANCE)
        a = random_q(robot, rng)
        b = np.clip(a + rng.normal(scale=rng.choice([0.1, 0.4]), size=robot.n), robot.lower, robot.upper)
        clearance = min(least(kinematics, a + s * (b - a)) for s in np.linspace(0.0, 1.0, 201))
        if checker.is_edge_valid(a, b):
            held += 1
            assert clearance >= DISTANCE
        else:
            failed += 1
            assert clearance < DISTANCE + RESOLUTION
        assert checker.is_valid(a) == (least(kinematics, a) >= DISTANCE)
    assert min(held, failed) >= 20


def test_nothing_is_so_thin_that_a_way_leads_through_it(robot: Robot) -> None:
    """The robot slides along the rail through a sheet of a hundredth of a millimetre."""
    end = robot.initial + 8.0 * np.eye(robot.n)[0]
    sheet = Box(center=(0.0, 4.2, 3.0), size=(8.0, 1e-5, 8.0))
    assert EdgeChecker(robot, (), 0.0).is_edge_valid(robot.initial, end)
    checker = EdgeChecker(robot, (sheet,), 0.0)
    assert checker.is_valid(robot.initial)
    assert checker.is_valid(end)
    assert not checker.is_edge_valid(robot.initial, end)


def test_what_is_beyond_the_limits_does_not_hold(robot: Robot) -> None:
    checker = EdgeChecker(robot, (), 0.0)
    beyond = robot.initial.copy()
    beyond[2] = robot.upper[2] + 1e-6
    assert not checker.is_valid(beyond)
    assert not checker.is_edge_valid(robot.initial, beyond)
    assert not checker.is_edge_valid(beyond, robot.initial)


def test_links_in_each_other_do_not_hold(robot: Robot, folded_q: np.ndarray) -> None:
    checker = EdgeChecker(robot, (), 0.0)
    assert not checker.is_valid(folded_q)
    assert not checker.is_edge_valid(robot.initial, folded_q)


@pytest.mark.parametrize("values", [np.zeros(3), np.full(12, np.nan)])
def test_bad_configurations_are_refused_by_the_native_engine(robot: Robot, values: np.ndarray) -> None:
    checker = EdgeChecker(robot, (), 0.0)
    with pytest.raises(ValueError, match="q needs"):
        checker.is_valid(values)
    with pytest.raises(ValueError, match="needs"):
        checker.is_edge_valid(robot.initial, values)
