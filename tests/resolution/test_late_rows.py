"""Rows of pairs that take long to measure: those that are left out change nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import central_difference, plan, points, random_q, some_obstacles
from hulls import hulled

from humanoid_rail import Gains, NativeKinematics, Robot, Safety, Scene, load_robot
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.kinematics import kinematics
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.resolution.native_velocity import constrained_velocity
from humanoid_rail.resolution.qp import constraints, safe_velocity

DT = 0.01


@pytest.fixture(scope="module")
def of_hulls(robot: Robot) -> Robot:
    return hulled(robot)


def clear_q(robot: Robot, rng: np.random.Generator, least: float) -> np.ndarray:
    reference = NativeKinematics(robot)
    while True:
        q = random_q(robot, rng)
        if reference.measure(q).self_clearance.min() > least:
            return q


@pytest.mark.parametrize("radius", [0.05, 0.35])
def test_gradients_of_hulls_are_central_differences(Kinematics: type, rng: np.random.Generator, radius: float) -> None:
    """Every column of links and of obstacles, on both sides of contact: thick links touch where thin ones do not."""
    thick = hulled(load_robot(link_radius=radius))
    obstacles = some_obstacles(rng, 6)
    at = Kinematics(thick, obstacles)

    def distances(x: np.ndarray) -> np.ndarray:
        measured = at.measure(x)
        return np.concatenate([measured.self_clearance, measured.clearance.ravel()])

    pairs, seen = len(thick.self_collision_pairs), {"links": [0, 0], "obstacles": [0, 0]}
    for _ in range(10):
        q = random_q(thick, rng)
        state = at.state(q)
        gradient = np.vstack([state.links.gradient, state.pieces.gradient.reshape(-1, thick.n)])
        distance = np.concatenate([state.links.distance, state.pieces.distance.ravel()])
        numeric, again = central_difference(distances, q), central_difference(distances, q, 1e-5)
        for i, apart in enumerate(distance):
            # Where the nearest feature changes, or which way is the shortest out, no gradient can be compared.
            if abs(numeric[i] - again[i]).max() > 1e-6 or not -0.2 < apart < 1.0:
                continue
            np.testing.assert_allclose(gradient[i], numeric[i], atol=1e-6)
            seen["links" if i < pairs else "obstacles"][int(apart < 0.0)] += 1
    assert min(seen["links"][0], seen["obstacles"][0]) > 50
    assert radius < 0.1 or min(seen["links"][1], seen["obstacles"][1]) > 5, seen


@pytest.mark.parametrize("least", [0.012, 0.001])
def test_the_velocity_is_the_one_of_all_rows(of_hulls: Robot, rng: np.random.Generator, least: float) -> None:
    """The reference measures every pair. From starts that are too near, too, where shares of rows are asked for."""
    bound, deviated = 0, 0
    for _ in range(60):
        q = clear_q(of_hulls, rng, least)
        obstacles = some_obstacles(rng, 2)
        state = kinematics.Kinematics(of_hulls, obstacles).state(q)
        targets = points(state.hands + rng.uniform(-3.0, 3.0, (2, 3)))
        expected = safe_velocity(of_hulls, state, targets, Gains(), Safety(), DT)
        native = NativeKinematics(of_hulls, obstacles)
        found = constrained_velocity(native, targets, Gains(), Safety(), DT)(q)
        np.testing.assert_allclose(found, expected, atol=1e-5)
        limits = constraints(of_hulls, state, Safety(), DT)
        kept = native.native.constraints()
        bound += len(kept[0]) < len(limits.rows)
        deviated += len(kept[0]) > 0
        assert (limits.rows @ found >= np.minimum(limits.sides, 0.0) - 1e-6).all()
    assert bound > 30  # rows were left out
    assert deviated > 10  # and others were not


def test_what_is_asked_before_does_not_matter(of_hulls: Robot, rng: np.random.Generator) -> None:
    native, targets = NativeKinematics(of_hulls), points(np.array([[-1.6, 0.6, 3.4], [-1.6, 2.2, 3.4]]))
    velocity = constrained_velocity(native, targets, Gains(), Safety(), DT)
    many = [clear_q(of_hulls, rng, 0.012) for _ in range(10)]
    first = [velocity(q) for q in many]
    np.testing.assert_array_equal([velocity(q) for q in reversed(many)][::-1], first)


@pytest.mark.parametrize("method", ["qp", "auto"])
def test_motions_keep_the_distance(of_hulls: Robot, scene: Scene, method: str) -> None:
    found = plan(of_hulls, scene, method)
    assert found.status == "reached"
    assert found.certified
    reference = NativeKinematics(of_hulls, scene.obstacles)
    assert min(reference.measure(q).self_clearance.min() for q in found.q) >= 0.01 - 1e-5


def near_pair(robot: Robot, rng: np.random.Generator, near: float = 0.006) -> tuple[np.ndarray, int]:
    """Return a configuration in which one pair is so near, and all others are clear; and the number of the pair."""
    reference = NativeKinematics(robot)
    while True:
        a, b = clear_q(robot, rng, 0.02), random_q(robot, rng)
        for share in np.linspace(0.0, 1.0, 400):
            apart = reference.measure(a + share * (b - a)).self_clearance
            pair = int(apart.argmin())
            if apart[pair] < near:
                break
        if near / 2 < apart[pair] < near and np.delete(apart, pair).min() > 0.02:
            return a + share * (b - a), pair


@pytest.mark.parametrize("hulls", [False, True])
def test_a_pair_keeps_a_distance_of_its_own(robot: Robot, rng: np.random.Generator, hulls: bool) -> None:
    """Velocities, configurations, edges and goals: with the safety distance they are refused, with its own allowed."""
    known = hulled(robot) if hulls else robot
    q, pair = near_pair(known, rng)
    own = replace(known, pair_distances={known.self_collision_pairs[pair]: 0.001})
    state, own_state = (kinematics.Kinematics(r).state(q) for r in (known, own))
    targets = points(state.hands)
    asked = Safety()
    for r, s in ((known, state), (own, own_state)):
        expected = safe_velocity(r, s, targets, Gains(c_mu=0.0), asked, DT)
        found = constrained_velocity(NativeKinematics(r), targets, Gains(c_mu=0.0), asked, DT)(q)
        np.testing.assert_allclose(found, expected, atol=1e-5)
        rate = state.links.gradient[pair] @ found
        assert (rate > 1e-4) == (r is known)
    still = q + 1e-9
    assert not EdgeChecker(known, (), 0.01).is_valid(q)
    assert EdgeChecker(own, (), 0.01).is_valid(q)
    assert EdgeChecker(own, (), 0.01).is_edge_valid(q, np.clip(still, own.lower, own.upper))
    assert not EdgeChecker(replace(own, pair_distances={own.self_collision_pairs[pair]: 0.008}), (), 0.01).is_valid(q)
    assert EdgeChecker(replace(own, pair_distances={own.self_collision_pairs[pair]: 0.008}), (), 0.01, 0.1).is_valid(q)
    there = InverseKinematics(own, ()).solve(q, targets, 0.01)
    assert there.reached
    np.testing.assert_allclose(there.q, q, atol=1e-12)
    assert (InverseKinematics(known, ()).solve(q, targets, 0.01).q != q).any()


@pytest.mark.parametrize("method", ["qp", "auto"])
def test_a_motion_from_there_keeps_it_and_says_the_true_bound(
    robot: Robot, rng: np.random.Generator, method: str
) -> None:
    q, pair = near_pair(robot, rng)
    own = replace(robot, pair_distances={robot.self_collision_pairs[pair]: 0.002})
    hands = NativeKinematics(own).state(q).hands
    places = hands + np.array([0.0, 0.0, 0.002])
    targets = {name: tuple(place) for name, place in zip(own.hand_names, places, strict=True)}
    found = plan(own, Scene(name="near", initial=tuple(q), targets=targets), method, c_mu=0.0, tolerance=1e-3)
    assert found.status == "reached", found.reason
    reference = NativeKinematics(own)
    apart = np.array([reference.measure(q).self_clearance for q in found.q])
    assert apart[:, pair].min() >= 0.95 * 0.002 - 1e-6
    assert np.delete(apart, pair, axis=1).min() >= 0.01 - 1e-6
    assert found.clearance_bound == pytest.approx(apart.min(), abs=2e-3)
    assert found.clearance_bound <= apart.min()
    # Nothing else is nearer than it has to be, and that is proven too.
    assert found.certificate is not None
    assert found.certificate.others_bound is not None
    others = np.delete(apart, pair, axis=1).min()
    assert others - 2e-3 <= found.certificate.others_bound <= others
    assert "could not be kept" not in found.reason
