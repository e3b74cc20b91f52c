"""The safe velocity: its constraints, what it minimises, and that nothing it does is unsafe."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import Plan, points, random_q, some_obstacles
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import LinearConstraint, minimize

from humanoid_rail import (
    Gains,
    InvalidInput,
    NativeKinematics,
    Robot,
    Safety,
    Scene,
    Sphere,
    Status,
    load_robot,
)
from humanoid_rail.kinematics import kinematics
from humanoid_rail.kinematics.native_tasks import native_tasks
from humanoid_rail.resolution.native_options import native_gains, native_safety
from humanoid_rail.resolution.native_velocity import constrained_velocity
from humanoid_rail.resolution.qp import FASTEST, TASK_WEIGHT, Constraints, Reachable, constraints, safe_velocity
from humanoid_rail.resolution.velocity import gradient_projection
from humanoid_rail.scene.obstacles import HalfSpace, Obstacle

TARGETS = np.array([[-1.6, 0.6, 3.4], [-1.6, 2.2, 3.4]])
DT = 0.01


def safe_state(robot: Robot, rng: np.random.Generator, distance: float) -> tuple[tuple[Obstacle, ...], np.ndarray]:
    """Return obstacles and a configuration with all clearances at least so large, some of them hardly larger."""
    q = random_q(robot, rng)
    while kinematics.Kinematics(robot).measure(q).self_clearance.min() < distance:
        q = random_q(robot, rng)
    kept: list[Obstacle] = []
    for obstacle in some_obstacles(rng, 9):
        psi = kinematics.Kinematics(robot, (obstacle,)).measure(q).clearance.min()
        if isinstance(obstacle, Sphere):  # just as near as it may be
            shift = psi - distance - rng.choice([0.0, 1e-6, 1e-3, 0.05])
            if obstacle.radius + shift > 0.02:
                kept.append(obstacle.model_copy(update={"radius": obstacle.radius + shift - 1e-9}))
        elif psi >= distance:
            kept.append(obstacle)
    return tuple(kept), q


def test_both_engines_have_the_same_velocity(robot: Robot, rng: np.random.Generator) -> None:
    """Two implementations, two solvers."""
    solved = 0
    for _ in range(60):
        obstacles, q = safe_state(robot, rng, 0.01)
        gains, safety = Gains(c_kappa=float(rng.uniform(0, 2)), epsilon=0.6), Safety()
        reference = kinematics.Kinematics(robot, obstacles)
        state = reference.state(q)
        expected = safe_velocity(robot, state, points(TARGETS), gains, safety, DT)
        found = constrained_velocity(NativeKinematics(robot, obstacles), points(TARGETS), gains, safety, DT)(q)
        solved += not np.allclose(slowed(robot, gradient_projection(state, points(TARGETS), gains)), expected)
        np.testing.assert_allclose(found, expected, atol=2e-6)
    assert solved > 20


def slowed(robot: Robot, velocity: np.ndarray) -> np.ndarray:
    return velocity / max(1.0, (abs(velocity) / robot.velocity_limit).max())


def test_it_is_the_closest_velocity_that_the_constraints_allow(robot: Robot, rng: np.random.Generator) -> None:
    """Against a general solver of another kind."""
    compared = 0
    while compared < 8:
        obstacles, q = safe_state(robot, rng, 0.01)
        state = kinematics.Kinematics(robot, obstacles).state(q)
        found = safe_velocity(robot, state, points(TARGETS), Gains(), Safety(), DT)
        r = slowed(robot, gradient_projection(state, points(TARGETS), Gains()))
        if np.allclose(found, r):
            continue
        limits, H = (
            constraints(robot, state, Safety(), DT),
            np.eye(12) + TASK_WEIGHT * state.jacobian.T @ state.jacobian,
        )
        assert_within(found, limits)
        best = minimize(
            lambda x, r=r, H=H: 0.5 * (x - r) @ H @ (x - r),
            np.zeros(12),
            jac=lambda x, r=r, H=H: H @ (x - r),
            hess=lambda x, H=H: H,
            method="trust-constr",
            bounds=list(zip(limits.lower, limits.upper, strict=True)),
            constraints=[LinearConstraint(limits.rows, limits.sides, np.inf)] if len(limits.rows) else [],
            options={"gtol": 1e-10, "xtol": 1e-12, "maxiter": 3000},
        )
        cost = 0.5 * (found - r) @ H @ (found - r)
        assert cost <= best.fun + 1e-6 * (1 + abs(best.fun))
        compared += 1


def assert_within(velocity: np.ndarray, limits: Constraints, tolerance: float = 1e-7) -> None:
    assert (velocity <= limits.upper + tolerance).all()
    assert (velocity >= limits.lower - tolerance).all()
    assert (limits.rows @ velocity >= limits.sides - tolerance).all()


def test_without_anything_in_the_way_it_is_eq_4_9(robot: Robot, Kinematics: type) -> None:
    free = Kinematics(robot)
    q = robot.initial
    near = free.state(q).hands + 0.1
    expected = gradient_projection(free.state(q), points(near), Gains(c_mu=0.1))
    assert (abs(expected) < robot.velocity_limit).all()
    found = safe_velocity(robot, free.state(q), points(near), Gains(c_mu=0.1), Safety(), DT)
    np.testing.assert_array_equal(found, expected)
    # Beyond the speed limits it keeps its direction, so that the hands stay on their path.
    fast = gradient_projection(free.state(q), points(TARGETS), Gains())
    assert (abs(fast) > robot.velocity_limit).any()
    found = safe_velocity(robot, free.state(q), points(TARGETS), Gains(), Safety(), DT)
    np.testing.assert_allclose(found, slowed(robot, fast), atol=1e-12)


def test_the_hands_give_way_before_a_constraint_does(robot: Robot) -> None:
    """A wall between hand and target: the hand stops, the constraint holds."""
    q = robot.initial
    reference = kinematics.Kinematics(robot)
    hand = reference.hand_positions(q)[0]
    wall = HalfSpace(normal=(0.0, 1.0, 0.0), offset=float(hand[1]) - 0.05 - 0.011)
    state = kinematics.Kinematics(robot, (wall,)).state(q)
    behind = reference.hand_positions(q) + np.array([[0.0, -0.3, 0.0], [0.0, 0.0, 0.0]])
    velocity = safe_velocity(robot, state, points(behind), Gains(c_mu=0.0, c_kappa=0.0), Safety(), DT)
    assert_within(velocity, constraints(robot, state, Safety(), DT))
    assert abs((state.jacobian @ velocity)[1]) < 1e-6
    wanted = gradient_projection(state, points(behind), Gains(c_mu=0.0, c_kappa=0.0))
    assert (state.jacobian @ wanted)[1] < -0.1


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    distance=st.sampled_from([1e-5, 0.005, 0.05]),
    dt=st.sampled_from([0.002, 0.01, 0.05]),
)
def test_a_step_from_a_safe_state_is_safe_and_within_limits(seed: int, distance: float, dt: float) -> None:
    robot = load_robot()
    rng = np.random.default_rng(seed)
    obstacles, q = safe_state(robot, rng, distance)
    step_is_safe(robot, obstacles, q, distance, dt, rng)


def step_is_safe(
    robot: Robot, obstacles: tuple[Obstacle, ...], q: np.ndarray, distance: float, dt: float, rng: np.random.Generator
) -> None:
    from conftest import plan

    targets = {"left": tuple(rng.uniform(-2, 4, 3)), "right": tuple(rng.uniform(-2, 4, 3))}
    scene = Scene(name="a step", initial=tuple(q), targets=targets, obstacles=obstacles)
    gain, c_kappa = float(rng.choice([0.5, 2.0, 10.0])), float(rng.choice([0.0, 1.0]))
    after = plan(robot, scene, "qp", gain=gain, c_kappa=c_kappa, dt=dt, max_time=dt, safety_distance=distance)
    assert after.limits_ok, after.violations
    assert (abs(np.diff(after.q, axis=0)) <= robot.velocity_limit * np.diff(after.t)[:, None] + 1e-9).all()
    assert (after.q <= robot.upper).all()
    assert (after.q >= robot.lower).all()
    measured = kinematics.Kinematics(robot, obstacles).measure(after.q[-1])
    assert measured.clearance.min(initial=np.inf) >= distance - 1e-8
    assert measured.self_clearance.min() >= distance - 1e-8
    assert after.certified


@settings(max_examples=40, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1))
def test_standing_still_is_always_allowed_among_obstacles_at_rest(seed: int) -> None:
    robot = load_robot()
    rng = np.random.default_rng(seed)
    safety = Safety()
    obstacles, q = safe_state(robot, rng, safety.target)
    limits = constraints(robot, kinematics.Kinematics(robot, obstacles).state(q), safety, DT)
    assert_within(np.zeros(robot.n), limits)


@pytest.mark.parametrize("gap", [0.0001, 0.005, 0.03])
def test_a_start_that_is_too_near_is_led_away(robot: Robot, plan: Plan, gap: float) -> None:
    """By a sphere beside the forearm: first away, to the safety distance, then on to the targets."""
    end = kinematics.Kinematics(robot).bones(robot.initial)[list(robot.link_names).index("left_forearm")]
    middle = end.mean(axis=0)
    sphere = Sphere(center=tuple(middle - np.array([0.05 + 0.2 + gap, 0.0, 0.0])), radius=0.2)
    hands = kinematics.Kinematics(robot).hand_positions(robot.initial)
    targets = {"left": tuple(hands[0] + np.array([0.0, 0.3, 0.1])), "right": tuple(hands[1])}
    scene = Scene(name="too near", targets=targets, obstacles=(sphere,))
    led = plan(robot, scene, "qp", safety_distance=0.04)
    assert led.status is Status.REACHED
    psi = kinematics.Kinematics(robot, (sphere,)).along(led.q).clearance[:, 0]
    assert psi[0] == pytest.approx(gap, abs=1e-6)
    assert (np.diff(psi[psi < 0.04]) > 0).all()
    assert psi[-1] >= 0.04
    assert led.certified


def test_where_the_wanted_speed_cannot_be_had_nothing_gets_nearer(robot: Robot) -> None:
    """Jammed between two walls, both too near: what is left is to stand still, not to fail."""
    q = robot.initial
    walls = (
        HalfSpace(normal=(0, 1, 0), offset=-2.2321 - 0.05 - 0.001),
        HalfSpace(normal=(0, -1, 0), offset=-(2.2321 + 0.05 + 0.001)),
    )
    for engine_kinematics in (kinematics.Kinematics, NativeKinematics):
        state = engine_kinematics(robot, walls).state(q)
        assert 0 < state.clearance.min() < 0.0011
    safety = Safety(safety_distance=1.5)
    state = kinematics.Kinematics(robot, walls).state(q)
    velocity = safe_velocity(robot, state, points(TARGETS), Gains(), safety, DT)
    fast = constrained_velocity(NativeKinematics(robot, walls), points(TARGETS), Gains(), safety, DT)(q)
    near = state.pieces.distance < safety.target
    for found in (velocity, fast):
        assert (state.pieces.gradient[near] @ found >= -1e-7).all()
        assert (abs(found) <= robot.velocity_limit + 1e-9).all()


def test_speed_limits_may_be_infinite(robot: Robot, scene: Scene) -> None:
    endless = replace(robot, velocity_limit=np.full(robot.n, np.inf))
    state = kinematics.Kinematics(endless, scene.obstacles).state(robot.initial)
    limits = constraints(endless, state, Safety(), DT)
    assert limits.upper.max() <= FASTEST
    expected = safe_velocity(endless, state, points(TARGETS), Gains(), Safety(), DT)
    found = constrained_velocity(NativeKinematics(endless, scene.obstacles), points(TARGETS), Gains(), Safety(), DT)(
        robot.initial
    )
    assert np.isfinite(expected).all()
    np.testing.assert_allclose(found, expected, atol=1e-6)


@pytest.mark.parametrize(
    ("field", "value"),
    [("safety_distance", -0.1), ("safety_distance", np.nan), ("damper_gain", 0.0), ("damper_gain", "fast")],
)
def test_bad_parameters_are_named(robot: Robot, scene: Scene, plan: Plan, field: str, value: object) -> None:
    with pytest.raises(InvalidInput, match=field):
        Safety(**{field: value})
    with pytest.raises(InvalidInput, match=field):
        plan(robot, scene, "qp", **{field: value})


def test_both_engines_have_the_same_velocity_among_those_that_can_be_had(
    robot: Robot, rng: np.random.Generator
) -> None:
    """Within bounds around a velocity at hand; what they allow is never worse for a row than the fallback."""
    bound = relaxed = 0
    for _ in range(60):
        obstacles, q = safe_state(robot, rng, 0.01)
        gains, safety = Gains(epsilon=0.6), Safety()
        before = rng.uniform(-0.3, 0.3, robot.n) * robot.velocity_limit
        change = rng.uniform(0.01, 0.1, robot.n) * robot.velocity_limit
        fallback = before - np.clip(0.1 * before, -change, change)
        reachable = Reachable(before - change, before + change, fallback)
        state = kinematics.Kinematics(robot, obstacles).state(q)
        expected = safe_velocity(robot, state, points(TARGETS), gains, safety, DT, reachable)
        native = NativeKinematics(robot, obstacles)
        stack = native_tasks(robot, points(TARGETS), native.state_for_callback)
        converted = native_gains(robot, gains, stack.rows, native.state_for_callback)
        limits = native_safety(safety, native.state_for_callback)
        found = native.native.reachable_velocity(q, 0.0, stack, converted, limits, DT, *reachable)
        np.testing.assert_allclose(found, expected, atol=2e-6)
        assert (found <= np.maximum(reachable.upper, fallback) + 1e-9).all()
        assert (found >= np.minimum(reachable.lower, fallback) - 1e-9).all()
        rows = constraints(robot, state, safety, DT, reachable)
        least = np.minimum(rows.sides, rows.rows @ fallback)
        assert (rows.rows @ found >= least - 1e-5).all()
        bound += bool((abs(abs(found - before) - change) < 1e-9).any())
        relaxed += bool((rows.sides > rows.rows @ fallback).any())
    assert bound > 20
    assert relaxed > 5
