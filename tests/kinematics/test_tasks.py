"""Poses as points that have to reach points."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from conftest import assert_gradient, random_q
from humanoid_rail.planning.engines import get_engine

from humanoid_rail import Robot, make_scene
from humanoid_rail.kinematics.task import LEVER, Task, rows_of, tasks_of

KINDS = ("point", "approach", "rpy")


def pose_of(robot: Robot, q: np.ndarray, kind: str, hand: str) -> Any:
    """Return what a target has to be for a hand to be at it, by Pinocchio."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.full_configuration(q))
    at = data.oMf[robot.model.getFrameId(f"{hand}_hand")]
    position, turned = at.translation.tolist(), at.rotation
    if kind == "point":
        return position
    how = (turned[:, 0] * 2.0).tolist() if kind == "approach" else pin.rpy.matrixToRpy(turned).tolist()
    return {"position": position, kind: how}


def task(robot: Robot, q: np.ndarray, left: str, right: str) -> Task:
    targets = {"left": pose_of(robot, q, left, "left"), "right": pose_of(robot, q, right, "right")}
    (found,) = tasks_of(robot, make_scene({"name": "poses", "targets": targets}))
    return found


@pytest.mark.parametrize("right", KINDS)
@pytest.mark.parametrize("left", KINDS)
def test_where_hands_are_turned_as_they_have_to_be_their_points_are_there(
    robot: Robot, engine: str, rng: np.random.Generator, left: str, right: str
) -> None:
    q = random_q(robot, rng)
    found = task(robot, q, left, right)
    count = {"point": 1, "approach": 2, "rpy": 3}
    assert sorted(found.owners) == [0] * count[left] + [1] * count[right]
    there = get_engine(engine).kinematics(found.posed, ()).measure(q, 0.0).hands
    np.testing.assert_allclose(there, found.points, atol=1e-9)
    for hand, kind in enumerate((left, right)):
        own = [i for i, owner in enumerate(found.owners) if owner == hand]
        lengths = np.linalg.norm(found.points[own] - found.points[own[0]], axis=1)
        np.testing.assert_allclose(lengths[1:], LEVER, atol=1e-12)
        assert len(own) == count[kind]


@pytest.mark.parametrize("kind", ["approach", "rpy"])
def test_the_jacobian_of_the_points_is_their_derivative(
    robot: Robot, engine: str, rng: np.random.Generator, kind: str
) -> None:
    """Every row and every column, by central differences."""
    found = task(robot, random_q(robot, rng), kind, kind)
    kinematics = get_engine(engine).kinematics(found.posed, ())
    for _ in range(5):
        q = random_q(robot, rng)
        jacobian = kinematics.state(q).jacobian
        assert jacobian.shape == (3 * len(found.points), robot.n)
        assert_gradient(lambda q: kinematics.measure(q, 0.0).hands.ravel(), jacobian, q)


def test_a_free_hand_has_no_rows(robot: Robot) -> None:
    (found,) = tasks_of(robot, make_scene({"name": "one", "targets": {"left": None, "right": [0.0, 2.0, 3.0]}}))
    assert found.robot.hand_names == ("right",)
    assert rows_of(robot, found) == [3, 4, 5]
    assert not found.is_oriented
