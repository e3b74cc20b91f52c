"""Why there may be no goals, and how far goals are."""

import numpy as np
import pytest
from conftest import points
from scipy.optimize import minimize

from humanoid_rail import Robot, Scene, Sphere, load_robot
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.kinematics.task import PointTask
from humanoid_rail.paper import dh_table as dh
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.search.blocked_targets import blocked_target
from humanoid_rail.search.goal_sampler import seeds
from humanoid_rail.search.reachability import out_of_reach

FREE = {"left": (0.6, -1.8, 2.6), "right": (0.6, 1.8, 2.6)}
RADIUS = 0.05
"""Of the robot's links, m."""


def scene(*obstacles: Sphere, **targets: tuple[float, float, float]) -> Scene:
    return Scene(name="test", targets={**FREE, **targets}, obstacles=obstacles)


def asked(scene: Scene) -> tuple[tuple[PointTask, ...], tuple[Obstacle, ...]]:
    """Return tasks and obstacles."""
    return points(np.array([scene.targets[name] for name in ("left", "right")])), scene.obstacles


@pytest.mark.parametrize(("gap", "blocked"), [(-0.1, True), (-0.011, True), (-0.009, False), (0.2, False)])
def test_a_target_is_blocked_where_the_forearm_does_not_fit(robot: Robot, gap: float, blocked: bool) -> None:
    """Up to the tolerance: the hand may stay 0.01 m away."""
    ball = Sphere(center=(0.6, -1.8, 2.6 + 0.2 + RADIUS + gap), radius=0.2)
    reason = blocked_target(robot, *asked(scene(ball)), 0.0, 0.01)
    assert (reason is not None) is blocked
    if reason:
        assert f"left hand at its target would be {-gap:.3g} m inside obstacles[0] (sphere)" in reason


def test_the_safety_distance_counts(robot: Robot) -> None:
    ball = Sphere(center=(0.6, -1.8, 2.6 + 0.2 + RADIUS + 0.02), radius=0.2)
    assert blocked_target(robot, *asked(scene(ball)), 0.01, 0.01) is None
    assert "nearer than the safety distance" in str(blocked_target(robot, *asked(scene(ball)), 0.05, 0.01))


def test_hands_need_room_beside_each_other(robot: Robot) -> None:
    close = scene(left=(0.8, 0.0, 2.8), right=(0.8, 0.06, 2.8))
    assert "the left hand would be 0.04 m inside the right hand" in str(
        blocked_target(robot, *asked(close), 0.01, 0.01)
    )
    thin = load_robot(link_radius=0.0)
    assert blocked_target(thin, *asked(close), 0.01, 0.01) is None


@pytest.mark.parametrize("away", [0.05, 0.5, 3.0])
def test_how_far_a_target_is_out_of_reach(robot: Robot, rng: np.random.Generator, away: float) -> None:
    """Against SciPy's own searches for the configuration of the DH table that is nearest."""
    top = dh.hands(robot.initial)[1] + [0.0, 0.0, 2.5 + away]
    bounds = list(zip(robot.lower, robot.upper, strict=True))
    least = min(
        minimize(lambda q: np.square(dh.hands(q)[1] - top).sum(), q0, bounds=bounds).fun
        for q0 in rng.uniform(robot.lower, robot.upper, (12, robot.n))
    )
    targets = np.array([dh.hands(robot.initial)[0], top])
    reason = out_of_reach(robot, points(targets), robot.initial, rng, 0.01)
    assert reason is not None
    assert "right hand is" in reason
    assert float(reason.split(" is ")[1].split(" m ")[0]) == pytest.approx(least**0.5, rel=0.01, abs=2e-3)


def test_what_is_in_reach(robot: Robot, rng: np.random.Generator) -> None:
    for q in rng.uniform(robot.lower, robot.upper, (20, robot.n)):
        assert out_of_reach(robot, points(dh.hands(q)), robot.initial, rng, 0.01) is None


def test_targets_that_are_too_far_apart(robot: Robot, rng: np.random.Generator) -> None:
    targets = np.array([[0.6, -2.0, 2.6], [0.6, 5.5, 2.6]])
    reason = str(out_of_reach(robot, points(targets), robot.initial, rng, 0.01))
    assert reason.startswith("each target is in reach of its hand")


def test_seeds_begin_at_the_start_and_stay_within_the_limits(robot: Robot, rng: np.random.Generator) -> None:
    some = seeds(robot, robot.initial, rng)
    first, *others = [next(some) for _ in range(200)]
    np.testing.assert_array_equal(first, robot.initial)
    assert (np.array(others) >= robot.lower).all()
    assert (np.array(others) <= robot.upper).all()
    assert len(np.unique(others, axis=0)) == 199


def test_a_goal_is_pulled_to_the_start(robot: Robot, rng: np.random.Generator) -> None:
    solver = InverseKinematics(robot, ())
    targets = dh.hands(robot.initial).ravel() + 0.1
    goals = [
        posture.q
        for seed, _ in zip(seeds(robot, robot.initial, rng), range(40), strict=False)
        if (posture := solver.solve(seed, points(targets), 0.01)).reached
    ]
    shorter = 0
    for goal in goals:
        nearer = solver.pulled(goal, robot.initial, points(targets), 0.01)
        before, after = np.linalg.norm(goal - robot.initial), np.linalg.norm(nearer - robot.initial)
        assert after <= before
        shorter += after < 0.9 * before
        np.testing.assert_allclose(dh.hands(nearer).ravel(), targets, atol=1e-6)
    assert shorter > len(goals) / 2
