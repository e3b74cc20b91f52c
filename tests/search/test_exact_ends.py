"""Where motions of `auto` end: at their targets, also from within the tolerance of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import AHEAD

from humanoid_rail import Auto, Kinematics, PointTask, Problem, Robot, Scene, Sphere, plan, retime, solve

EXACT = 1e-6


def errors(robot: Robot, scene: Scene, trajectory: object) -> list[float]:
    """Return how far the hands are from each target in turn when the motion says that they are there, m."""
    kinematics = Kinematics(robot)
    found = []
    for t, step in zip(trajectory.arrivals, scene.steps, strict=True):
        hands = dict(zip(robot.hand_names, kinematics.hand_positions(trajectory.configuration(t)), strict=True))
        found += [float(np.linalg.norm(hands[name] - target)) for name, target in step.items() if target is not None]
    return found


@pytest.mark.parametrize(("step", "tolerance"), [(0.005, 0.01), (0.003, 0.05), (1e-5, 0.01)])
def test_targets_nearer_than_the_tolerance_are_gone_to(robot: Robot, step: float, tolerance: float) -> None:
    x, y, z = AHEAD["left"]
    scene = Scene(name="line", targets=tuple({"left": (x, y + step * k, z), "right": AHEAD["right"]} for k in range(6)))
    trajectory = plan(robot, scene, Auto(tolerance=tolerance))
    assert trajectory.status == "reached"
    assert max(errors(robot, scene, trajectory)) <= EXACT
    assert (np.diff([0.0, *trajectory.arrivals]) > 0).all()
    assert (np.diff(trajectory.t) > 0).all()
    assert trajectory.certified
    assert trajectory.limits_ok
    retimed = retime(trajectory, robot, scene)
    assert retimed.status == "reached"
    assert max(errors(robot, scene, retimed)) <= EXACT


def test_a_motion_that_is_at_its_targets_stays(robot: Robot) -> None:
    here = Kinematics(robot).hand_positions(robot.initial)
    scene = Scene(name="here", targets={"left": tuple(here[0]), "right": tuple(here[1])})
    assert plan(robot, scene).duration == 0.0


def test_where_the_exact_target_is_blocked_the_reason_says_what_is_left(robot: Robot) -> None:
    """The target is at the edge of what the safety distance leaves; the tolerance covers what is missing."""
    x, y, z = AHEAD["left"]
    body = 0.05  # of the forearm around the hand
    obstacle = Sphere(center=(x, y, z - 0.3), radius=0.3 - body - 0.006)
    scene = Scene(name="edge", targets={"left": AHEAD["left"], "right": None}, obstacles=(obstacle,))
    trajectory = plan(robot, scene, Auto(tolerance=0.02))
    assert trajectory.status == "reached"
    assert trajectory.certified
    left = errors(robot, scene, trajectory)[0]
    assert EXACT < left <= 0.02
    assert "within tolerance = 0.02 m" in trajectory.reason
    assert f"{left:.2g}" in trajectory.reason


def test_tasks_of_ones_own_end_exactly_too(robot: Robot) -> None:
    near = Kinematics(robot).hand_positions(robot.initial)[0] + [0.004, 0.0, 0.0]
    scene = Scene(name="own", targets=AHEAD)
    problem = Problem(robot, scene, (PointTask("left", tuple(near)),), robot.initial)
    trajectory = solve(problem, replace(Auto(), tolerance=0.01))
    assert np.linalg.norm(trajectory.hands[-1, 0] - near) <= EXACT
