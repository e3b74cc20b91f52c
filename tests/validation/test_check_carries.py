"""The check of level trays: random carries begin and end as they have to, and tilts are measured as they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from humanoid_rail import load_robot
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.result import Status
from validation.check_carries import carry, largest_tilt, racks, random_carry

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")


def test_a_random_carry_is_level(rng: np.random.Generator) -> None:
    robot = load_robot("human-sized")
    found = carry(robot, random_carry(robot, InverseKinematics(robot, racks()), rng))
    assert found.status is Status.REACHED
    assert found.tilt <= found.bound <= np.deg2rad(0.2)


def test_a_tilt_is_measured_between_samples(robot: object) -> None:
    from humanoid_rail import Robot, paper_scene, plan

    assert isinstance(robot, Robot)
    trajectory = plan(robot, paper_scene(), "qp")
    few = replace(trajectory, motion=replace(trajectory.motion, t=trajectory.t[[0, -1]], q=trajectory.q[[0, -1]]))
    assert largest_tilt(robot, few, (0.0, 0.0, 1.0)) > 0.0
