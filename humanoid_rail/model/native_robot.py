"""Robots as the native engine has them."""

from __future__ import annotations

from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

from humanoid_rail._native import engine
from humanoid_rail.model.pair_distances import own_distances
from humanoid_rail.model.robot import Robot

if TYPE_CHECKING:
    from humanoid_rail import _engine

_robots: WeakKeyDictionary[Robot, _engine.Robot] = WeakKeyDictionary()


def native_robot(robot: Robot) -> _engine.Robot:
    """Return a robot as the native engine has it: frozen, made once for each robot and shared between threads.

    Raises:
        EngineMissing: If there is no native engine.
    """
    if robot not in _robots:
        hands = [(robot.model.getFrameId(hand.frame), robot.arm_columns(hand)) for hand in robot.hands]
        _robots[robot] = engine().Robot(
            robot.model.saveToString(),
            robot.collision_model.saveToString(),
            robot.coupling,
            robot.offset,
            hands,
            list(robot.self_collision_pairs),
            own_distances(robot),
            robot.lower,
            robot.upper,
            robot.velocity_limit,
        )
    return _robots[robot]
