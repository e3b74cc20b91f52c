"""Numbers in the reasons of plans that failed: they agree, or it is said why they do not, and they have units."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest
from conftest import AHEAD, ROOT, PythonKinematics

from humanoid_rail import Auto, GradientProjection, Robot, SafeVelocity, Scene, Trajectory, load_robot, load_scene, plan

FOLDER = ROOT / "scenes" / "unsolvable"
NAMES = (
    "target_in_collision-1",
    "target_in_collision-3",
    "target_in_collision-5",
    "target_out_of_reach-1",
    "target_out_of_reach-3",
    "target_out_of_reach-4",
)


@cache
def planned(name: str) -> tuple[Scene, Trajectory]:
    scene = load_scene(FOLDER / f"{name}.yaml")
    return scene, plan(load_robot(), scene)


@pytest.mark.parametrize("name", NAMES)
def test_lengths_agree_or_it_is_said_why_they_do_not(name: str) -> None:
    scene, trajectory = planned(name)
    reason, moved = trajectory.reason, trajectory.diagnosis.remedies[0]
    assert "|e|" not in reason, "each hand has a distance of its own"
    missed = {miss.hand: miss.distance for miss in trajectory.diagnosis.misses}
    more = [np.linalg.norm(np.subtract(to, scene.targets[hand])) - missed[hand] for hand, to in moved.targets]
    assert min(more) > -1e-3
    assert (max(more) > 2e-3) == ("a little more than it misses" in moved.what)
    if trajectory.status == "target_in_collision":
        assert "has to keep safety_distance = 0.01 m from it" in reason
        assert moved.what.endswith("which keeps the safety distance too")
    else:
        assert ("by itself, " in reason) != ("but not both at once; " in reason)
        assert "nearest miss with all hands at once: " in reason


def test_limits_have_units() -> None:
    found = planned("target_out_of_reach-3")[1].diagnosis
    assert found.limits[0] == "rail is at its upper limit of 9 m"
    assert found.limits[1].endswith("-1.309 rad")
    assert any(re.fullmatch(r"open the upper limit of rail to [\d.]+ m", remedy.what) for remedy in found.remedies)


@pytest.mark.parametrize("method", [SafeVelocity(max_time=0.5), GradientProjection(max_time=0.5)])
def test_what_remains_is_said_of_each_hand(robot: Robot, method: SafeVelocity | GradientProjection) -> None:
    trajectory = plan(robot, Scene(name="x", targets=AHEAD), method)
    hands = PythonKinematics(robot).measure(trajectory.q[-1]).hands
    left, right = (np.linalg.norm(hands[robot.hand(hand)] - AHEAD[hand]) for hand in ("left", "right"))
    said = f"the left hand is {left:.3g} m and the right hand {right:.3g} m from their targets after the longest"
    assert trajectory.reason.startswith(said)


def test_the_reference_says_the_same(robot: Robot) -> None:
    reasons = [
        plan(robot, Scene(name="x", targets=AHEAD), GradientProjection(max_time=0.5, engine=engine)).reason
        for engine in ("python", "native")
    ]
    assert reasons[0].split("; ")[0] == reasons[1].split("; ")[0]


def test_a_motion_that_auto_gives_up_on_ends_at_a_time() -> None:
    trajectory = plan(load_robot(), load_scene(FOLDER / "stuck-3.yaml"), Auto(max_edge_checks=20))
    assert f"; the motion is as far as qp gets, until t = {trajectory.duration:.4g} s; " in trajectory.reason
