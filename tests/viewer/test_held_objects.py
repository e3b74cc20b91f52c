"""Objects on the page are where they are."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from humanoid_rail import load_robot, load_scene, plan
from humanoid_rail.resampling import evaluate
from humanoid_rail.viewer.held_objects import objects_data

pytestmark = pytest.mark.filterwarnings("ignore:no collision body")


def test_objects_stand_or_move_with_joints() -> None:
    robot, scene = load_robot("human-sized"), load_scene("scenes/kit.yaml")
    trajectory = plan(robot, scene)
    data = {one["name"]: one["parts"] for one in objects_data(robot, scene, trajectory)}
    assert set(data) == {"bottle", "box", "can", "pack"}
    for event in trajectory.events:
        part = [part for part in data[event.object] if part["t"] <= event.t][-1]
        q = evaluate(trajectory.motion, np.array([event.t]))[0][0]
        model_data = robot.model.createData()
        pin.forwardKinematics(robot.model, model_data, robot.full_configuration(q))
        placement = np.array(part["placement"]).reshape(4, 4).T
        there = model_data.oMi[part["joint"]].homogeneous @ placement
        np.testing.assert_allclose(there[:3, 3], event.position, atol=1e-6)
