"""What is asked of sampling: paths that hold, the same for the same seed, within a budget."""

import gc
import time
import weakref
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
import pytest

from humanoid_rail import Box, InvalidInput, Robot
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.kinematics.path_metric import path_length
from humanoid_rail.search.sampler import Sampler

WALL = Box(center=(0.9, 2.6, 3.2), size=(1.2, 0.1, 2.0))
"""Both arms have to go around it when the robot slides along the rail."""
CLOSED = Box(center=(0.0, 2.6, 3.0), size=(20.0, 0.1, 20.0))
"""Nothing leads around it."""

Ends = tuple[np.ndarray, np.ndarray]


@pytest.fixture
def ends(robot: Robot) -> Ends:
    start, goal = robot.initial.copy(), robot.initial.copy()
    start[5:] = goal[5:] = [1.2, 0.0, 0.3, 0.0, -1.2, 0.0, 0.3][:7]
    start[1] = goal[1] = 0.0
    goal[0] += 5.0
    return start, goal


def connected(sampler: Sampler, robot: Robot, ends: Ends, seed: int = 1, checks: int = 20_000) -> np.ndarray | None:
    return sampler.connect(ends[0], [ends[1]], (robot.lower, robot.upper), seed, 0.7, checks)


def found(robot: Robot, ends: Ends, seed: int) -> np.ndarray:
    sampler = Sampler(robot, (WALL,), 0.01)
    path = connected(sampler, robot, ends, seed)
    assert path is not None
    shorter = sampler.shorten(path, seed, 20_000)
    assert shorter is not None
    return shorter


def test_a_way_around_is_found_made_shorter_and_proven(robot: Robot, ends: Ends) -> None:
    start, goal = ends
    checker, sampler = EdgeChecker(robot, (WALL,), 0.01), Sampler(robot, (WALL,), 0.01)
    assert not checker.is_edge_valid(start, goal)
    path = sampler.connect(start, [robot.lower, goal], (robot.lower, robot.upper), 1, 0.7, 20_000)
    assert path is not None
    shorter = sampler.shorten(path, 1, 20_000)
    assert shorter is not None
    for way in (path, shorter):
        np.testing.assert_array_equal(way[[0, -1]], [start, goal])
    assert all(checker.is_edge_valid(a, b) for a, b in pairwise(shorter))
    assert path_length(robot, shorter) < path_length(robot, path)
    assert (shorter >= robot.lower).all()
    assert (shorter <= robot.upper).all()
    assert sampler.checks > 0


def test_a_path_that_is_not_free_is_mended_or_refused(robot: Robot, ends: Ends) -> None:
    """The wall is in the middle of the straight edge: nothing leads around it nearby, or a proven path is returned."""
    through = np.array(ends)
    assert Sampler(robot, (CLOSED,), 0.01).shorten(through, 1, 1000) is None
    small = Box(center=(0.9, 2.6, 3.2), size=(0.05, 0.05, 0.05))
    checker = EdgeChecker(robot, (small,), 0.01)
    mended = [Sampler(robot, (small,), 0.01).shorten(through, seed, 1000) for seed in range(10)]
    held = [path for path in mended if path is not None]
    assert all(checker.is_edge_valid(a, b) for path in held for a, b in pairwise(path))


def test_a_seed_gives_the_same_path_also_beside_other_threads(robot: Robot, ends: Ends) -> None:
    alone = {seed: found(robot, ends, seed) for seed in (1, 2)}
    assert alone[1].shape != alone[2].shape or not np.array_equal(alone[1], alone[2])
    seeds = [1, 2] * 8
    with ThreadPoolExecutor(8) as threads:
        together = list(threads.map(lambda seed: found(robot, ends, seed), seeds))
    for seed, path in zip(seeds, together, strict=True):
        np.testing.assert_array_equal(path, alone[seed])


def test_the_number_of_checks_is_kept(robot: Robot, ends: Ends) -> None:
    sampler = Sampler(robot, (CLOSED,), 0.01)
    assert connected(sampler, robot, ends, checks=100) is None
    assert 100 <= sampler.checks <= 110
    assert sampler.explored is not None
    assert len(sampler.explored) > 1
    np.testing.assert_array_equal(sampler.explored[0], ends[0])


def test_goals_that_are_none_are_left_out(robot: Robot, ends: Ends) -> None:
    checker, sampler = EdgeChecker(robot, (WALL,), 0.01), Sampler(robot, (WALL,), 0.01)
    inside = ends[0] + 2.6 * np.eye(robot.n)[0]
    assert not checker.is_valid(inside)
    box = (robot.lower, robot.upper)
    assert sampler.connect(ends[0], [inside], box, 1, 0.7, 100) is None
    path = sampler.connect(ends[0], [inside, ends[1]], box, 1, 0.7, 20_000)
    assert path is not None
    np.testing.assert_array_equal(path[-1], ends[1])


def test_the_deadline_is_kept(robot: Robot, ends: Ends) -> None:
    began = time.perf_counter()
    sampler = Sampler(robot, (CLOSED,), 0.01, began + 0.2)
    assert connected(sampler, robot, ends, checks=10**9) is None
    assert sampler.checks < 10**7
    late = sampler.checks
    assert connected(sampler, robot, ends, checks=10**9) is None
    assert sampler.checks <= late + 64


def test_samplers_are_freed(robot: Robot, ends: Ends) -> None:
    sampler = Sampler(robot, (WALL,), 0.01)
    assert connected(sampler, robot, ends) is not None
    gone = weakref.ref(sampler)
    del sampler
    gc.collect()
    assert gone() is None


@pytest.mark.parametrize("wrong", [np.full(12, np.nan), np.zeros(3)])
def test_configurations_are_checked(robot: Robot, ends: Ends, wrong: np.ndarray) -> None:
    sampler = Sampler(robot, (WALL,), 0.01)
    with pytest.raises((ValueError, InvalidInput)):
        sampler.connect(wrong, [ends[1]], (robot.lower, robot.upper), 1, 0.7, 100)
