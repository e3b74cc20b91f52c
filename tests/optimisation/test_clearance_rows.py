"""Rows of clearances, by the engine: which pairs there are, how much they have to spare, and how that changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import assert_gradient, random_q, some_obstacles

from humanoid_rail import Box, HalfSpace, NativeKinematics, Robot
from humanoid_rail._native import engine
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.scene.native_obstacles import native_obstacles

DISTANCE = 0.02


def distances(kinematics: NativeKinematics, q: np.ndarray) -> np.ndarray:
    """Return the distances of all pairs at a configuration, those of pieces of obstacles first."""
    there = kinematics.state(q)
    return np.concatenate([there.pieces.distance.ravel(), there.links.distance])


def kept(robot: Robot, pieces: int) -> np.ndarray:
    own = [robot.pair_distances.get(pair, np.inf) for pair in robot.self_collision_pairs]
    return np.concatenate([np.full(pieces, DISTANCE), np.minimum(own, DISTANCE)])


def test_rows_are_what_central_differences_say(robot: Robot, rng: np.random.Generator, folded_q: np.ndarray) -> None:
    """On both sides of contact: the random obstacles, and the folded links, are partly inside one another."""
    obstacles = (
        *some_obstacles(rng),
        HalfSpace(normal=(0.1, 0.0, 1.0), offset=0.5),
        Box(center=(0, 2, 3), size=(1, 1, 1)),
    )
    kinematics = NativeKinematics(robot, obstacles)
    clearance = engine().MotionClearance(native_robot(robot), native_obstacles(obstacles))
    samples = np.array([folded_q, *(random_q(robot, rng) for _ in range(7))])
    rows = clearance.rows(samples, DISTANCE, np.inf, np.full(robot.n, np.inf))
    pieces = kinematics.state(folded_q).pieces.distance.size
    inside = outside = 0
    for i, q in enumerate(samples):
        spare = distances(kinematics, q) - kept(robot, pieces)
        here = np.flatnonzero(rows.sample == i)
        np.testing.assert_allclose(np.sort(rows.spare[here]), np.sort(spare[np.isfinite(spare)]), atol=1e-9)
        assert rows.least[i] == rows.spare[here].min()
        for row in here:
            pair = int(np.argmin(abs(spare - rows.spare[row])))
            if not 1e-3 < abs(spare[pair]) < 0.5 or np.linalg.norm(rows.gradient[row]) < 1e-3:
                continue
            inside, outside = inside + (spare[pair] < 0), outside + (spare[pair] > 0)
            assert_gradient(lambda q, k=pair: distances(kinematics, q)[k], rows.gradient[row], q, 2e-4)
    assert inside > 5
    assert outside > 20


def test_rows_that_do_not_matter_are_left_out(robot: Robot, rng: np.random.Generator) -> None:
    obstacles = some_obstacles(rng)
    clearance = engine().MotionClearance(native_robot(robot), native_obstacles(obstacles))
    samples = np.array([random_q(robot, rng) for _ in range(4)])
    every = clearance.rows(samples, DISTANCE, np.inf, np.full(robot.n, np.inf))
    near = clearance.rows(samples, DISTANCE, 0.4, np.full(robot.n, np.inf))
    assert 0 < len(near.spare) < len(every.spare)
    assert near.spare.max() <= 0.4 - DISTANCE + 1e-9
    np.testing.assert_array_equal(np.sort(near.spare), np.sort(every.spare[every.spare <= 0.4 - DISTANCE]))
    reach = rng.uniform(0.0, 0.2, robot.n)
    within = clearance.rows(samples, DISTANCE, np.inf, reach)
    expected = every.spare <= abs(every.gradient) @ reach
    assert 0 < expected.sum() < len(every.spare)
    np.testing.assert_array_equal(np.sort(within.spare), np.sort(every.spare[expected]))
    np.testing.assert_array_equal(within.least, every.least)


def test_pairs_with_a_distance_of_their_own_keep_that(robot: Robot) -> None:
    pair = robot.self_collision_pairs[0]
    close = replace(robot, pair_distances={pair: 0.003})
    samples = robot.initial[None]
    spares = [
        engine()
        .MotionClearance(native_robot(one), native_obstacles(()))
        .rows(samples, DISTANCE, np.inf, np.full(robot.n, np.inf))
        .spare
        for one in (robot, close)
    ]
    assert spares[1][0] - spares[0][0] == pytest.approx(DISTANCE - 0.003)
    np.testing.assert_array_equal(spares[0][1:], spares[1][1:])


def test_bad_input_is_refused(robot: Robot) -> None:
    clearance = engine().MotionClearance(native_robot(robot), native_obstacles(()))
    with pytest.raises(ValueError, match="sample"):
        clearance.rows(np.zeros((2, robot.n + 1)), 0.01, 0.1, np.ones(robot.n))
    with pytest.raises(ValueError, match="finite"):
        clearance.rows(np.full((2, robot.n), np.nan), 0.01, 0.1, np.ones(robot.n))
    with pytest.raises(ValueError, match="reach"):
        clearance.rows(np.zeros((2, robot.n)), 0.01, 0.1, np.ones(3))
