"""Where joints have to be at the end of a step: single ones, and those of a named posture."""

from __future__ import annotations

import numpy as np

from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.model.position_limits import OTHER_UNIT, beyond_limits
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.targets import Step


def joint_targets(robot: Robot, step: Step) -> dict[str, float]:
    """Return where joints have to be at the end of a step that was checked, by their names, m and rad.

    Of a posture these are all joints but those that move a hand which has a target.
    """
    found = dict(step.joints)
    if step.posture is not None:
        moved = {name for hand in robot.hand_names if step.get(hand) is not None for name in _moving(robot, hand)}
        posture = zip(robot.joint_names, robot.postures[step.posture], strict=True)
        found = {**{name: float(x) for name, x in posture if name not in moved}, **found}
    # What is beyond a limit by rounding is at it.
    limits = dict(zip(robot.joint_names, zip(robot.lower.tolist(), robot.upper.tolist(), strict=True), strict=True))
    return {name: min(max(x, limits[name][0]), limits[name][1]) for name, x in found.items()}


def check_joint_targets(robot: Robot, step: Step, where: str) -> None:
    """Check that a robot has the joints and the posture of a step, and that joints may be there.

    Args:
        robot: The robot.
        step: The step.
        where: What errors call it.

    Raises:
        InvalidInput: If not; the error names what there is, or the limit.
    """
    if step.posture is not None and step.posture not in robot.postures:
        near, known = did_you_mean(step.posture, robot.postures), ", ".join(robot.postures) or "none"
        valid = f"a posture of the robot{near}; there are: {known}"
        raise InvalidInput(f"{where}.posture", step.posture, valid)
    for name, value in step.joints.items():
        if name not in robot.joint_names:
            near = did_you_mean(name, robot.joint_names)
            valid = f"a joint that moves{near}; there are: {', '.join(robot.joint_names)}"
            raise InvalidInput(f"{where}.joints.{name}", value, valid)
    for name, value in step.joints.items():
        i = robot.joint_names.index(name)
        if beyond_limits(np.array([value], float), robot.lower[i : i + 1], robot.upper[i : i + 1]):
            raise InvalidInput(f"{where}.joints.{name}", value, _within(robot, i, float(value)))
    others = [name for name, target in step.items() if target is not None and name not in robot.hand_names]
    if step.posture is not None and others:
        valid = f"joints instead: {others[0]} has a target, and a hand with all its joints holds it"
        raise InvalidInput(f"{where}.posture", step.posture, valid)
    if step.posture is not None and not joint_targets(robot, step):
        valid = "a posture with joints that move no hand which has a target; all of them do: give joints instead"
        raise InvalidInput(f"{where}.posture", step.posture, valid)


def _within(robot: Robot, i: int, value: float) -> str:
    """Return what is right for a joint that is beyond a limit."""
    unit = robot.unit_of(robot.joint_names[i])
    lower, upper = float(robot.lower[i]), float(robot.upper[i])
    side, limit = ("lower", lower) if value < lower else ("upper", upper)
    factor, other = (1e-3, "millimetres") if unit == "m" else (np.pi / 180.0, "degrees")
    hint = f"; given in {other}?" if abs(value) > OTHER_UNIT and lower <= factor * value <= upper else ""
    return (
        f"a position within {lower:.6g} to {upper:.6g} {unit}; it is beyond the {side} limit, {limit:.6g} {unit}{hint}"
    )


def _moving(robot: Robot, hand: str) -> frozenset[str]:
    """Return the joints that move a hand."""
    frame = robot.model.frames[robot.model.getFrameId(robot.hands[robot.hand(hand)].frame)]
    chain = {robot.model.names[joint] for joint in robot.model.supports[frame.parentJoint]}
    return frozenset(name for name in robot.joint_names if name in chain)
