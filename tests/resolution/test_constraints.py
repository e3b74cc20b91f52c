"""The constraints of the safe velocity: their rows are derivatives of clearances, in both engines."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import central_difference, in_order, points, random_q, some_obstacles

from humanoid_rail import Gains, NativeKinematics, Robot, Safety, load_robot
from humanoid_rail.kinematics import kinematics
from humanoid_rail.resolution.native_velocity import constrained_velocity
from humanoid_rail.resolution.qp import constraints

TARGETS = np.array([[-1.6, 0.6, 3.4], [-1.6, 2.2, 3.4]])
DT = 0.01


@pytest.mark.parametrize("spread", [1.0, 0.05])
def test_distances_of_links_have_the_right_gradient(
    robot: Robot, Kinematics: type, rng: np.random.Generator, spread: float
) -> None:
    """On both sides of contact: thick links touch where thin ones do not."""
    seen = {"contact": 0, "apart": 0}
    for radius in (0.05, 0.35):
        thick = load_robot(link_radius=radius)
        fast = Kinematics(thick)
        for _ in range(12):
            q = random_q(thick, rng)
            links = fast.state(q).links
            pairs = len(thick.self_collision_pairs)
            assert pairs >= 27
            assert links.distance.shape == (pairs,)
            assert links.gradient.shape == (pairs, 12)
            numeric = central_difference(lambda x, fast=fast: fast.measure(x).self_clearance, q)
            for i in range(pairs):
                # Where axes cross or are parallel the distance has a kink, at which no gradient can be compared.
                h = 1e-5 * spread
                again = central_difference(lambda x, fast=fast: fast.measure(x).self_clearance, q, h)[i]
                if not np.allclose(numeric[i], again, atol=1e-5) or links.distance[i] < -1.9 * radius:
                    continue
                np.testing.assert_allclose(links.gradient[i], numeric[i], atol=2e-6)
                seen["contact" if links.distance[i] < 0 else "apart"] += 1
    assert seen["contact"] > 20
    assert seen["apart"] > 200


def test_rows_are_the_derivatives_of_the_clearances(robot: Robot, rng: np.random.Generator) -> None:
    """Every row against central differences, in time too, with obstacles that are near, touching and inside."""
    seen = {"contact": 0, "apart": 0, "moving": 0}
    safety = Safety(safety_distance=0.02, damper_gain=7.0)
    assert safety.horizon == 0.52
    for _ in range(60):
        obstacles = some_obstacles(rng, 9, speed=0.5)
        reference = kinematics.Kinematics(robot, obstacles)
        q, t = random_q(robot, rng), float(rng.uniform(0, 2))
        state = reference.state(q, t)
        for (link, k), distance in np.ndenumerate(state.pieces.distance):
            if not -0.1 < distance < safety.horizon:
                continue

            def psi(x: np.ndarray, t: float = t, link: int = link, k: int = k, at: Any = reference) -> np.ndarray:
                return at.measure(x, t=t).clearance[link, k]

            if not np.allclose(central_difference(psi, q), central_difference(psi, q, 1e-5), atol=1e-5):
                continue  # a kink, where the nearest point jumps
            np.testing.assert_allclose(state.pieces.gradient[link, k], central_difference(psi, q), atol=1e-5)
            h = 1e-6
            rate = (psi(q, t=t + h) - psi(q, t=t - h)) / (2 * h)
            assert state.pieces.rate[link, k] == pytest.approx(rate, abs=1e-5)
            seen["contact" if distance < 0 else "apart"] += 1
            seen["moving"] += abs(rate) > 0.05
        # What is left out cannot bind, and the sides are those of the damper.
        limits = constraints(robot, state, safety, DT)
        near = state.pieces.distance <= safety.horizon
        rows = np.vstack([state.pieces.gradient[near], state.links.gradient[state.links.distance <= safety.horizon]])
        distances = np.concatenate([state.pieces.distance[near], state.links.distance[state.links.distance <= 0.52]])
        rates = np.concatenate([state.pieces.rate[near], np.zeros(len(distances) - near.sum())])
        for _ in range(20 * (distances.min() > safety.target)):
            velocity = rng.uniform(limits.lower, limits.upper)
            kept = rows @ velocity + rates >= -7.0 * (distances - 0.022)
            assert kept.all() == (limits.rows @ velocity >= limits.sides).all()
    assert min(seen["contact"], seen["moving"]) >= 10
    assert seen["apart"] > 100


def test_both_engines_have_the_same_rows(robot: Robot, rng: np.random.Generator) -> None:
    """Those of the Python engine are held against central differences above."""
    safety, compared, moving = Safety(safety_distance=0.02, damper_gain=3.0), 0, 0
    for _ in range(40):
        obstacles, q, t = some_obstacles(rng, 9, speed=0.5), random_q(robot, rng), float(rng.uniform(0, 2))
        expected = constraints(robot, kinematics.Kinematics(robot, obstacles).state(q, t), safety, DT)
        fast = NativeKinematics(robot, obstacles)
        constrained_velocity(fast, points(TARGETS), Gains(), safety, DT)(q, t)
        rows, sides = fast.native.constraints()
        found = in_order(sides, rows)
        np.testing.assert_allclose(found, in_order(expected.sides, expected.rows), atol=1e-6)
        compared += len(found)
        moving += len(found) > 0
    assert compared > 200
    assert moving > 20
