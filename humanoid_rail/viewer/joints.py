"""What a page's script knows of the joints of a robot, to put its links where they are."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from humanoid_rail.model.robot import Robot
from humanoid_rail.viewer.drawing import node_name


def joints_data(robot: Robot) -> list[dict[str, Any]]:
    """Return the joints of a robot in Pinocchio's order, as data that JSON can hold and kinematics.js takes; m, rad."""
    return [_joint(robot, number) for number in range(1, robot.model.njoints)]


def _joint(robot: Robot, number: int) -> dict[str, Any]:
    model, joint = robot.model, robot.model.joints[number]
    data = joint.createData()
    joint.calc(data, pin.neutral(model))
    along, about = np.asarray(data.S, float).reshape(6)[:3], np.asarray(data.S, float).reshape(6)[3:]
    row = robot.coupling[joint.idx_v]
    return {
        "node": node_name(model.names[number]),
        "parent": int(model.parents[number]),
        "placement": model.jointPlacements[number].homogeneous.T.ravel().tolist(),
        "kind": "revolute" if about.any() else "prismatic",
        "axis": (about if about.any() else along).tolist(),
        "follows": [[int(i), float(row[i])] for i in np.flatnonzero(row)],
        "offset": float(robot.offset[joint.idx_q]),
    }
