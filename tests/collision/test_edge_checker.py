"""Whether a straight way keeps a distance, against clearances measured along it."""

import numpy as np
import pytest
from conftest import random_q
from humanoid_rail.planning.engines import get_engine

from humanoid_rail import Box, HalfSpace, Robot, Sphere
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


def test_a_way_holds_where_its_samples_do(robot: Robot, engine: str, rng: np.random.Generator) -> None:
    held = failed = 0
    for _ in range(150 if engine == "native" else 12):
        obstacles = cluttered(rng)
        kinematics = get_engine("native").kinematics(robot, obstacles)
        validity = get_engine(engine).validity(robot, obstacles, DISTANCE)
        a = random_q(robot, rng)
        b = np.clip(a + rng.normal(scale=rng.choice([0.1, 0.4]), size=robot.n), robot.lower, robot.upper)
        clearance = min(least(kinematics, a + s * (b - a)) for s in np.linspace(0.0, 1.0, 201))
        if validity.holds_between(a, b):
            held += 1
            assert clearance >= DISTANCE
        else:
            failed += 1
            assert clearance < DISTANCE + RESOLUTION
        assert validity.holds_at(a) == (least(kinematics, a) >= DISTANCE)
    assert min(held, failed) >= (20 if engine == "native" else 2)


def test_nothing_is_so_thin_that_a_way_leads_through_it(robot: Robot, engine: str) -> None:
    """The robot slides along the rail through a sheet of a hundredth of a millimetre."""
    end = robot.initial + 8.0 * np.eye(robot.n)[0]
    sheet = Box(center=(0.0, 4.2, 3.0), size=(8.0, 1e-5, 8.0))
    assert get_engine(engine).validity(robot, (), 0.0).holds_between(robot.initial, end)
    validity = get_engine(engine).validity(robot, (sheet,), 0.0)
    assert validity.holds_at(robot.initial)
    assert validity.holds_at(end)
    assert not validity.holds_between(robot.initial, end)


def test_what_is_beyond_the_limits_does_not_hold(robot: Robot, engine: str) -> None:
    validity = get_engine(engine).validity(robot, (), 0.0)
    beyond = robot.initial.copy()
    beyond[2] = robot.upper[2] + 1e-6
    assert not validity.holds_at(beyond)
    assert not validity.holds_between(robot.initial, beyond)
    assert not validity.holds_between(beyond, robot.initial)


def test_links_in_each_other_do_not_hold(robot: Robot, engine: str, folded_q: np.ndarray) -> None:
    validity = get_engine(engine).validity(robot, (), 0.0)
    assert not validity.holds_at(folded_q)
    assert not validity.holds_between(robot.initial, folded_q)


def test_both_engines_say_the_same(robot: Robot, rng: np.random.Generator) -> None:
    said = []
    for _ in range(25):
        obstacles, a = cluttered(rng), random_q(robot, rng)
        b = np.clip(a + rng.normal(scale=0.2, size=robot.n), robot.lower, robot.upper)
        answers = {get_engine(e).validity(robot, obstacles, 0.0).holds_between(a, b) for e in ("native", "python")}
        assert len(answers) == 1
        said += answers
    assert {True, False} == set(said)


@pytest.mark.parametrize("values", [np.zeros(3), np.full(12, np.nan)])
def test_bad_configurations_are_refused_by_the_native_engine(robot: Robot, values: np.ndarray) -> None:
    validity = get_engine("native").validity(robot, (), 0.0)
    with pytest.raises(ValueError, match="q needs"):
        validity.holds_at(values)
    with pytest.raises(ValueError, match="needs"):
        validity.holds_between(robot.initial, values)
