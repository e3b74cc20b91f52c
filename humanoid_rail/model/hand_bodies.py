"""Which bodies of a robot are those of a hand: they may touch what it grasps."""

from __future__ import annotations

from humanoid_rail.model.robot import Robot


def hand_bodies(robot: Robot, hand: str) -> tuple[int, ...]:
    """Return the collision bodies that no joint moves relative to a hand's frame."""
    joint = robot.model.frames[robot.model.getFrameId(robot.hands[robot.hand(hand)].frame)].parentJoint
    bodies = robot.collision_model.geometryObjects
    return tuple(i for i, body in enumerate(bodies) if body.parentJoint == joint)
