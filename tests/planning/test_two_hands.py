"""Two hands of a robot with two arms of seven joints move one object that both hold."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from humanoid_rail import Trajectory, load_robot, plan, retime
from humanoid_rail.holding.holding import hand_placement
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import make_scene

SHIFT = np.array([0.08, 0.0, 0.1])


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("dual_fr3")


@pytest.fixture(scope="module")
def carried(robot: Robot) -> Trajectory:
    left, right = (hand_placement(robot, name, robot.initial).translation for name in robot.hand_names)
    middle = (left + right) / 2.0
    scene = make_scene(
        {
            "name": "beam",
            "objects": [{"type": "box", "name": "beam", "center": middle.tolist(), "size": [0.06, 0.62, 0.06]}],
            "targets": [
                {"left": left.tolist(), "right": right.tolist(), "grasp": {"left": "beam", "right": "beam"}},
                {"beam": (middle + SHIFT).tolist()},
                {"beam": {"position": (middle + 0.5 * SHIFT).tolist(), "rpy": [0.0, 0.0, 0.1]}},
            ],
        }
    )
    return plan(robot, scene)


@pytest.mark.parametrize("retimed", [False, True])
def test_both_hands_keep_the_object(robot: Robot, carried: Trajectory, retimed: bool) -> None:
    trajectory = retime(carried, speed=0.5) if retimed else carried
    assert trajectory.status == "reached", trajectory.reason
    assert trajectory.certified
    relative = [
        hand_placement(robot, "left", q).inverse() * hand_placement(robot, "right", q)
        for q in trajectory.resample(0.001).q
    ]
    off = [relative[0].inverse() * one for one in relative]
    assert max(np.linalg.norm(one.translation) for one in off) < 1e-3
    assert max(np.linalg.norm(pin.log3(one.rotation)) for one in off) < np.deg2rad(0.2)


def test_the_object_is_at_its_targets(robot: Robot, carried: Trajectory) -> None:
    start, end = (hand_placement(robot, "left", q) for q in (robot.initial, carried.q[-1]))
    assert carried.scene is not None
    beam = carried.scene.objects[0]
    assert beam.type == "box"
    placed = end * start.inverse() * pin.SE3(np.eye(3), np.array(beam.center))
    np.testing.assert_allclose(placed.translation, np.array(beam.center) + 0.5 * SHIFT, atol=1e-5)
    np.testing.assert_allclose(pin.rpy.matrixToRpy(placed.rotation), [0.0, 0.0, 0.1], atol=1e-5)
