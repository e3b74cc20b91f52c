"""Obstacles that are given in a frame of their own, put where that frame is."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import triple
from humanoid_rail.scene.obstacles import HalfSpace, Obstacle, Sphere


def frame_of(center: tuple[float, float, float], rpy: tuple[float, float, float]) -> pin.SE3:
    """Return where a frame is whose origin and whose angles, as in URDF, are given, m and rad."""
    return pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.array(center))


def placement_of(shape: Obstacle) -> pin.SE3:
    """Return where the frame of an obstacle or an object is in the base frame; of a half-space it is the base frame."""
    if isinstance(shape, HalfSpace):
        return pin.SE3.Identity()
    return frame_of(shape.center, (0.0, 0.0, 0.0) if isinstance(shape, Sphere) else shape.rpy)


def put_into(frame: pin.SE3, obstacle: Obstacle, more: Mapping[str, object]) -> Obstacle:
    """Return an obstacle that is given in a frame as one in the base frame.

    Args:
        frame: Where the frame is in the base frame.
        obstacle: The obstacle in the frame.
        more: Other fields that change, such as its velocity.
    """
    if isinstance(obstacle, HalfSpace):
        normal = frame.rotation @ obstacle.normal
        offset = obstacle.offset + float(normal @ frame.translation)
        return obstacle.model_copy(update={"normal": triple(normal), "offset": offset, **more})
    center = triple(frame.act(np.array(obstacle.center)))
    new = {"center": center, **more}
    # Where nothing turns no angle changes, not even by rounding.
    if not isinstance(obstacle, Sphere) and not np.array_equal(frame.rotation, np.eye(3)):
        turn = frame.rotation @ pin.rpy.rpyToMatrix(*obstacle.rpy)
        new["rpy"] = triple(pin.rpy.matrixToRpy(turn))
    return obstacle.model_copy(update=new)
