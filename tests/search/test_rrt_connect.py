"""What is asked of OMPL: ways that hold, the same for the same seed, within a budget."""

import gc
import time
import weakref
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
import pytest

from humanoid_rail import Box, Robot
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.kinematics.path_metric import path_length
from humanoid_rail.search.rrt_connect import Sampler

WALL = Box(center=(0.9, 2.6, 3.2), size=(1.2, 0.1, 2.0))
"""Both arms have to go around it when the robot slides along the rail."""


@pytest.fixture
def checker(robot: Robot) -> EdgeChecker:
    return EdgeChecker(robot, (WALL,), 0.01)


@pytest.fixture
def ends(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    start, goal = robot.initial.copy(), robot.initial.copy()
    start[5:] = goal[5:] = [1.2, 0.0, 0.3, 0.0, -1.2, 0.0, 0.3][:7]
    start[1] = goal[1] = 0.0
    goal[0] += 5.0
    return start, goal


def sampler(robot: Robot, checker: EdgeChecker, deadline: float = np.inf) -> Sampler:
    return Sampler(robot, checker, robot.lower, robot.upper, deadline)


def find(robot: Robot, checker: EdgeChecker, ends: tuple[np.ndarray, np.ndarray], seed: int) -> np.ndarray:
    box = sampler(robot, checker)
    path = box.connect(ends[0], [ends[1]], seed, 0.7, 20_000)
    assert path is not None
    return box.shorten(path, seed)


def test_a_way_around_is_found_and_made_shorter(
    robot: Robot, checker: EdgeChecker, ends: tuple[np.ndarray, np.ndarray]
) -> None:
    start, goal = ends
    assert not checker.is_edge_valid(start, goal)
    box = sampler(robot, checker)
    path = box.connect(start, [robot.lower, goal], 1, 0.7, 20_000)
    assert path is not None
    shorter = box.shorten(path, 1)
    for way in (path, shorter):
        np.testing.assert_allclose(way[[0, -1]], [start, goal], atol=1e-12)
        assert all(checker.is_edge_valid(a, b) for a, b in pairwise(way))
    assert path_length(robot, shorter) < path_length(robot, path)
    assert box.checks > 0


def test_a_seed_gives_the_same_path_also_beside_other_threads(
    robot: Robot, checker: EdgeChecker, ends: tuple[np.ndarray, np.ndarray]
) -> None:
    alone = {seed: find(robot, checker, ends, seed) for seed in (1, 2)}
    assert alone[1].shape != alone[2].shape or not np.array_equal(alone[1], alone[2])
    seeds = [1, 2] * 4
    with ThreadPoolExecutor(4) as threads:
        checks = [EdgeChecker(robot, (WALL,), 0.01) for _ in seeds]
        together = list(threads.map(lambda job: find(robot, job[1], ends, job[0]), zip(seeds, checks, strict=True)))
    for seed, path in zip(seeds, together, strict=True):
        np.testing.assert_array_equal(path, alone[seed])


def test_a_search_draws_no_random_numbers_while_it_waits_for_another_one(
    robot: Robot, checker: EdgeChecker, ends: tuple[np.ndarray, np.ndarray]
) -> None:
    """As threads may follow each other: whenever one looks at a configuration, another one begins and gives up."""

    class Interrupted:
        interruptions = 0

        def is_valid(self, q: np.ndarray) -> bool:
            self.interruptions += 1
            other = sampler(robot, checker, time.perf_counter())
            assert other.connect(ends[0], [ends[1]], 2, 0.7, 20_000) is None
            other.shorten(np.array(ends), 2)
            return checker.is_valid(q)

        def is_edge_valid(self, a: np.ndarray, b: np.ndarray) -> bool:
            return checker.is_edge_valid(a, b)

    interrupted = Interrupted()
    path = sampler(robot, interrupted).connect(ends[0], [ends[1]], 1, 0.7, 20_000)
    # At the goal, and at the start before the trees grow.
    assert interrupted.interruptions >= 2
    np.testing.assert_array_equal(path, sampler(robot, checker).connect(ends[0], [ends[1]], 1, 0.7, 20_000))


def test_the_number_of_checks_is_kept(robot: Robot, checker: EdgeChecker, ends: tuple[np.ndarray, np.ndarray]) -> None:
    closed = EdgeChecker(robot, (Box(center=(0.0, 2.6, 3.0), size=(20.0, 0.1, 20.0)),), 0.01)
    box = sampler(robot, closed)
    assert box.connect(*([ends[0], [ends[1]]]), 1, 0.7, 100) is None
    assert 100 <= box.checks <= 110


def test_goals_that_are_none_are_left_out(
    robot: Robot, checker: EdgeChecker, ends: tuple[np.ndarray, np.ndarray]
) -> None:
    """OMPL would wait for others."""
    inside = ends[0] + 2.6 * np.eye(robot.n)[0]
    assert not checker.is_valid(inside)
    assert sampler(robot, checker).connect(ends[0], [inside], 1, 0.7, 100) is None
    assert sampler(robot, checker).connect(ends[0], [inside, ends[1]], 1, 0.7, 20_000) is not None


def test_the_deadline_is_kept(robot: Robot, ends: tuple[np.ndarray, np.ndarray]) -> None:
    closed = EdgeChecker(robot, (Box(center=(0.0, 2.6, 3.0), size=(20.0, 0.1, 20.0)),), 0.01)
    began = time.perf_counter()
    soon = sampler(robot, closed, began + 0.2)
    assert soon.connect(ends[0], [ends[1]], 1, 0.7, 10**9) is None
    assert soon.checks < 10**9
    over = sampler(robot, closed, began)
    assert over.connect(ends[0], [ends[1]], 1, 0.7, 10**9) is None
    assert over.checks == 0
    np.testing.assert_allclose(over.shorten(np.array(ends), 1), ends)


def test_nothing_is_left_behind(robot: Robot, ends: tuple[np.ndarray, np.ndarray]) -> None:
    """OMPL's pointers and Python's would keep each other alive."""

    class Open:
        def is_valid(self, q: np.ndarray) -> bool:
            return True

        def is_edge_valid(self, a: np.ndarray, b: np.ndarray) -> bool:
            return True

    def use() -> "weakref.ref[Open]":
        checker = Open()
        assert sampler(robot, checker).connect(ends[0], [ends[1]], 1, 0.7, 100) is not None
        return weakref.ref(checker)

    used = use()
    gc.collect()
    assert used() is None
