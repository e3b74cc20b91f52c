"""The sampled filter of edges, against clearances measured by coal and Pinocchio in Python, and against the proof."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import random_scene

from humanoid_rail import (
    Box,
    Capsule,
    Cylinder,
    HalfSpace,
    HumanoidRailError,
    Mesh,
    PointCloud,
    Robot,
    Sphere,
    load_robot,
)
from humanoid_rail._native import engine
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.model.pair_distances import own_distances
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.scene.obstacles import Obstacle

DISTANCE = 0.01
ROUNDING = 3e-5
"""Single precision, and what is taken off for it, m."""
LANES = 8


def some_robot(name: str) -> Robot:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of limits and links without bodies
        try:
            return load_robot() if name == "paper" else load_robot(name)
        except HumanoidRailError as error:
            pytest.skip(str(error))


def edge_filter(robot: Robot, obstacles: tuple[Obstacle, ...], portable: bool = False, share: float = 1.0) -> object:
    return engine().EdgeFilter(native_robot(robot), native_obstacles(obstacles), DISTANCE, share, portable)


def spare(robot: Robot, kinematics: Kinematics, q: np.ndarray) -> float:
    """Return by how much the pair that is worst off keeps what it has to keep, m."""
    found = kinematics.measure(q)
    kept = np.minimum(own_distances(robot), DISTANCE)
    return float(
        min((found.clearance - DISTANCE).min(initial=np.inf), (found.self_clearance - kept).min(initial=np.inf))
    )


def within(robot: Robot, rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(np.maximum(robot.lower, -3.0), np.minimum(robot.upper, 4.0))


def around(middle: np.ndarray, size: float, rng: np.random.Generator) -> tuple[Obstacle, ...]:
    def place() -> tuple[float, ...]:
        return tuple(middle + size * rng.uniform(-1, 1, 3))

    def turn() -> tuple[float, ...]:
        return tuple(rng.uniform(-2, 2, 3))

    return (
        Sphere(center=place(), radius=size * rng.uniform(0.02, 0.2)),
        Box(center=place(), size=tuple(size * rng.uniform(0.02, 0.4, 3)), rpy=turn()),
        Capsule(center=place(), radius=0.05 * size, length=0.3 * size, rpy=turn()),
        HalfSpace(normal=(0.1, 0.0, 1.0), offset=middle[2] - size * rng.uniform(1.2, 2.5)),
    )


@pytest.mark.parametrize(
    ("name", "middle", "size"),
    [("paper", (0, 2, 3), 2.5), ("human-sized", (0, 1, 1), 1.0), ("panda", (0, 0, 0.5), 0.8), ("ur5", (0, 0, 1), 0.8)],
)
def test_its_samples_are_measured_right(name: str, middle: tuple, size: float, rng: np.random.Generator) -> None:
    """An edge of a micrometre is one configuration."""
    robot = some_robot(name)
    free = blocked = 0
    for _ in range(20):
        obstacles = around(np.array(middle, float), size, rng)
        filters = [edge_filter(robot, obstacles, portable) for portable in (False, True)]
        kinematics = Kinematics(robot, obstacles)
        for q in (within(robot, rng) for _ in range(10)):
            left = spare(robot, kinematics, q)
            found = {each.is_edge_free(q, q + 1e-7) for each in filters}
            assert len(found) == 1
            if abs(left) > ROUNDING:
                assert found == {left > 0}
            free, blocked = free + (left > 0), blocked + (left < 0)
    assert min(free, blocked) >= 10


def test_meshes_are_no_boxes(robot: Robot, rng: np.random.Generator, tmp_path_factory: pytest.TempPathFactory) -> None:
    trimesh = pytest.importorskip("trimesh")
    file = tmp_path_factory.mktemp("meshes") / "ball.stl"
    trimesh.creation.icosphere(subdivisions=2, radius=0.5).export(file)
    between = 0
    for _ in range(30):
        ball = Mesh(file=str(file), center=tuple(np.array([0.0, 2.0, 2.8]) + rng.uniform(-2, 2, 3)))
        fast, kinematics = edge_filter(robot, (ball,)), Kinematics(robot, (ball,))
        for q in (within(robot, rng) for _ in range(10)):
            left = spare(robot, kinematics, q)
            if abs(left) > ROUNDING:
                assert fast.is_edge_free(q, q + 1e-7) == (left > 0)
            between += 0 < left < 0.1
    assert between >= 5


def test_of_cylinders_and_clouds_it_is_never_wrong(robot: Robot, rng: np.random.Generator, tmp_path: Path) -> None:
    """Cylinders have no closed form in it, and a cloud is many spheres."""
    np.savez(tmp_path / "cloud.npz", points=rng.uniform(-0.5, 0.5, (60, 3)))
    free = blocked = 0
    for _ in range(20):
        middle = np.array([0.0, 2.0, 2.8])
        turns = rng.uniform(-2, 2, (2, 3))
        places = middle + rng.uniform(-2, 2, (2, 3))
        obstacles = (
            Cylinder(center=tuple(places[0]), radius=0.3, length=0.8, rpy=tuple(turns[0])),
            PointCloud(file=str(tmp_path / "cloud.npz"), radius=0.05, center=tuple(places[1]), rpy=tuple(turns[1])),
        )
        fast, kinematics = edge_filter(robot, obstacles), Kinematics(robot, obstacles)
        for q in (within(robot, rng) for _ in range(10)):
            left = spare(robot, kinematics, q)
            if abs(left) > ROUNDING:
                assert fast.is_edge_free(q, q + 1e-7) == (left > 0)
            free, blocked = free + (left > 0), blocked + (left < 0)
    assert min(free, blocked) >= 10


def test_an_edge_is_sampled_all_along(robot: Robot, rng: np.random.Generator) -> None:
    """Where it is said to be free its samples are; where not, one of many is not."""
    seen = {True: 0, False: 0}
    for _ in range(100):
        obstacles = random_scene(rng).obstacles
        fast, kinematics = edge_filter(robot, obstacles), Kinematics(robot, obstacles)
        a = within(robot, rng)
        if spare(robot, kinematics, a) < ROUNDING:
            continue
        b = a + 0.3 * (within(robot, rng) - a)
        free = fast.is_edge_free(a, b)
        left = [spare(robot, kinematics, a + k / LANES * (b - a)) for k in range(1, LANES + 1)]
        if free:
            assert min(left) > -ROUNDING
        else:
            more = (spare(robot, kinematics, a + share * (b - a)) for share in np.linspace(0, 1, 400))
            assert min([*left, *more]) < 2e-3
        seen[free] += 1
    assert min(seen.values()) >= 5


def test_nothing_thicker_than_a_link_is_jumped_over(robot: Robot) -> None:
    """The robot slides far along the rail through a board as thick as an arm."""
    end = robot.initial + 8.0 * np.eye(robot.n)[0]
    for y in np.linspace(3.0, 7.0, 41):
        board = Box(center=(0.0, y, 3.0), size=(8.0, 0.1, 8.0))
        assert not edge_filter(robot, (board,)).is_edge_free(robot.initial, end)


def test_pairs_with_a_distance_of_their_own_keep_a_share_of_it(robot: Robot, folded_q: np.ndarray) -> None:
    assert not edge_filter(robot, ()).is_edge_free(folded_q, folded_q + 1e-7)
    assert edge_filter(robot, ()).is_edge_free(robot.initial, robot.initial + 1e-7)


@pytest.mark.parametrize("wrong", [np.zeros(3), np.full(12, np.nan)])
def test_bad_configurations_are_refused(robot: Robot, wrong: np.ndarray) -> None:
    with pytest.raises(ValueError, match="b needs"):
        edge_filter(robot, ()).is_edge_free(robot.initial, wrong)
