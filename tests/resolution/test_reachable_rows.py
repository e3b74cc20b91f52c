"""Rows and bounds of the velocities that can be had, against central differences of distances, in both engines."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from conftest import central_difference, points, random_q, some_obstacles
from hulls import hulled

from humanoid_rail import Gains, NativeKinematics, Robot, Safety, load_robot
from humanoid_rail.kinematics import kinematics
from humanoid_rail.kinematics.native_tasks import native_tasks
from humanoid_rail.resolution.native_options import native_gains, native_safety
from humanoid_rail.resolution.qp import SHARES, Reachable, constraints
from humanoid_rail.scene.obstacles import Obstacle

DT = 0.01
SAFETY = Safety(safety_distance=0.02, damper_gain=3.0)
OWN = 0.004
"""Every other pair of links keeps this distance of its own, m."""


class Rows(NamedTuple):
    """What q_dot has to satisfy, from distances alone."""

    lower: np.ndarray
    upper: np.ndarray
    distance: np.ndarray
    """Of each pair of links, then of each link and obstacle (m,), m."""
    drift: np.ndarray
    """d distance / dt while the robot stands still (m,), m/s."""
    rows: np.ndarray
    """(m, n)."""
    base: np.ndarray
    """What the fallback gives (m,), m/s."""
    sides: np.ndarray
    """(m,), m/s."""
    is_capped: np.ndarray
    """Whether a damper asks for more than half of what the bounds allow beyond the fallback (m,)."""
    can_bind: np.ndarray
    """Whether velocities within the bounds can break a row, by more than rounding (m,)."""
    is_smooth: np.ndarray
    """Whether a distance has a derivative there, so that it can be compared (m,)."""


def all_rows(at: NativeKinematics, q: np.ndarray, t: float, reachable: Reachable) -> Rows:
    """Return them by the formulas of `qp` written out, with nothing of the engines but distances."""
    robot, h = at.robot, 1e-6

    def distances(x: np.ndarray, t: float = t) -> np.ndarray:
        measured = at.measure(x, t=t)
        return np.concatenate([measured.self_clearance, measured.clearance.ravel()])

    distance, rows = distances(q), central_difference(distances, q, h)
    drift = (distances(q, t + h) - distances(q, t - h)) / (2.0 * h)
    target = np.full(distance.size, 1.1 * 0.02)
    target[: len(robot.self_collision_pairs) : 2] = 1.1 * OWN
    limit = robot.velocity_limit
    upper = np.maximum(np.minimum.reduce([limit, 10.0 * (robot.upper - q), reachable.upper]), reachable.fallback)
    lower = np.minimum(np.maximum.reduce([-limit, 10.0 * (robot.lower - q), reachable.lower]), reachable.fallback)
    ends = np.stack([rows * lower, rows * upper])
    slowest, fastest = ends.min(axis=0).sum(axis=1), ends.max(axis=0).sum(axis=1)
    base, wanted = rows @ reachable.fallback, -3.0 * (distance - target) - drift
    sides = np.minimum(wanted, 0.5 * (base + fastest))
    near = (distance < SAFETY.horizon - 1e-6) & (fastest - slowest > 1e-5)
    again = central_difference(distances, q, 10.0 * h)
    # Which way is the shortest out of what is deep inside is not asked.
    is_smooth = (abs(rows - again).max(axis=1) < 1e-6) & (distance > -0.2)
    can_bind = near & (slowest < sides - 1e-5)
    return Rows(lower, upper, distance, drift, rows, base, sides, wanted > sides + 1e-5, can_bind, is_smooth)


def some_reachable(robot: Robot, q: np.ndarray, rng: np.random.Generator) -> Reachable:
    """Return what accelerations allow around a velocity, and that of braking."""
    before = rng.uniform(-0.3, 0.3, robot.n) * np.minimum(robot.velocity_limit, 2.0 * (robot.upper - q))
    change = rng.choice([0.02, 0.3]) * rng.uniform(0.5, 1.0, robot.n) * robot.velocity_limit
    return Reachable(before - change, before + change, before - np.clip(before, -0.5 * change, 0.5 * change))


def native_answer(
    at: NativeKinematics, q: np.ndarray, t: float, reachable: Reachable, targets: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the velocity of the native engine, its rows and its sides."""
    stack = native_tasks(at.robot, points(targets), at.state_for_callback)
    gains = native_gains(at.robot, Gains(), stack.rows, at.state_for_callback)
    safety = native_safety(SAFETY, at.state_for_callback)
    velocity = at.native.reachable_velocity(q, t, stack, gains, safety, DT, *reachable)
    return velocity, *at.native.constraints()


def matches(found: tuple[np.ndarray, np.ndarray], expected: Rows) -> np.ndarray:
    """Return which of the rows found (k,) are which of those expected (m,), every column and the side, as (k, m)."""
    rows, sides = found
    apart = abs(rows[:, None] - expected.rows).max(axis=2, initial=0.0)
    return (apart < 1e-5) & (abs(sides[:, None] - expected.sides) < 1e-5) & expected.is_smooth


@pytest.mark.parametrize("hulls", [False, True])
def test_rows_are_those_of_central_differences(rng: np.random.Generator, hulls: bool) -> None:
    """With links and obstacles apart and inside each other, obstacles that move, and pairs with own distances.

    Of hulls the native engine has only rows that a velocity could break; the velocity keeps all of them.
    """
    seen, shares = Counter[str](), Counter[str]()
    for i in range(20):
        known = load_robot(link_radius=(0.05, 0.3)[i % 2])
        robot = replace(
            hulled(known) if hulls else known, pair_distances=dict.fromkeys(known.self_collision_pairs[::2], OWN)
        )
        obstacles: tuple[Obstacle, ...] = some_obstacles(rng, 6, speed=0.5)
        q, t = random_q(robot, rng), float(rng.uniform(0.0, 2.0))
        reachable, at = some_reachable(robot, q, rng), NativeKinematics(robot, obstacles)
        expected = all_rows(at, q, t, reachable)
        of_python = constraints(robot, kinematics.Kinematics(robot, obstacles).state(q, t), SAFETY, DT, reachable)
        np.testing.assert_allclose([of_python.lower, of_python.upper], [expected.lower, expected.upper], atol=1e-12)
        velocity, *of_engine = native_answer(at, q, t, reachable, rng.uniform(-2.0, 4.0, (2, 3)))
        to_be_found = expected.can_bind & expected.is_smooth
        odd = (~expected.is_smooth & (expected.distance <= SAFETY.horizon)).sum()
        for found, has_all in (((of_python.rows, of_python.sides), True), (of_engine, not hulls)):
            same = matches(found, expected)
            assert (~same.any(axis=1)).sum() <= odd
            if has_all:
                assert same.any(axis=0)[to_be_found].all()
        # The velocity keeps a share of what is asked for beyond the fallback, also in rows that were left out.
        assert (velocity >= expected.lower - 1e-9).all()
        assert (velocity <= expected.upper + 1e-9).all()
        beyond = np.array(SHARES)[:, None] * np.maximum(expected.sides - expected.base, 0.0)
        asked = np.minimum(expected.sides, expected.base + beyond)
        keeps = ((expected.rows @ velocity >= asked - 1e-5) | ~to_be_found).all(axis=1)
        assert keeps.any()
        shares["whole" if keeps[0] else "less"] += 1
        which = same.any(axis=0)
        pairs = len(robot.self_collision_pairs)
        for kind, of_kind in (("links", slice(0, pairs)), ("obstacles", slice(pairs, None))):
            seen[f"{kind} apart"] += (which & (expected.distance > 0.0))[of_kind].sum()
            seen[f"{kind} inside"] += (which & (expected.distance < 0.0))[of_kind].sum()
        seen["own"] += which[:pairs:2].sum()
        seen["damper"] += (which & ~expected.is_capped).sum()
        seen["capped"] += (which & expected.is_capped).sum()
        seen["moving"] += (which & (abs(expected.drift) > 0.05)).sum()
    assert min(seen.values()) > 3, seen
    assert len(seen) == 8
    assert min(shares["whole"], shares["less"]) > 1, shares
