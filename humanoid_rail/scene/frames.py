"""Targets in the frame of something in the scene, as targets in the base frame."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array, triple
from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.scene.obstacles import HalfSpace, Obstacle, is_moving
from humanoid_rail.scene.placing import placement_of
from humanoid_rail.scene.targets import AnyOf, Pose, Step, Straight, Target, alternatives, orientation

SHOWN = 12
"""Errors list so many names at most."""


def in_base(step: Step, shapes: Sequence[Obstacle], where: str) -> Step:
    """Return a step whose poses are in the base frame.

    Args:
        step: The step, some of whose poses may be in the frames of shapes.
        shapes: Obstacles and objects, whose names the poses give.
        where: What errors call the step.

    Raises:
        InvalidInput: If a name is that of no shape or of several, or the shape moves or has no frame.
    """
    stated = [one for target in step.values() for one in alternatives(target)]
    if not any(isinstance(target, Pose) and target.frame is not None for target in stated):
        return step
    return step.with_targets({hand: _target(target, shapes, f"{where}.{hand}") for hand, target in step.items()})


def frame_named(shapes: Sequence[Obstacle], name: str, field: str) -> pin.SE3:
    """Return where the frame of the shape of a name is in the base frame.

    Raises:
        InvalidInput: As for :func:`in_base`; it names the field.
    """
    found = [shape for shape in shapes if shape.name == name]
    if not found and (bay := _bay(shapes, name)) is not None:
        return bay
    if not found:
        names = list(dict.fromkeys(str(shape.name) for shape in shapes if shape.name is not None))
        listed = ", ".join(names[:SHOWN]) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")
        near = did_you_mean(name, names)
        valid = f"the name of an obstacle, of an object or of a bay such as `shelf/bay 2`{near}"
        raise InvalidInput(field, name, f"{valid}; there are: {listed or 'none'}")
    if len(found) > 1:
        raise InvalidInput(field, name, f"a name that one obstacle or object has; {len(found)} are called so")
    if isinstance(found[0], HalfSpace):
        raise InvalidInput(field, name, "an obstacle with a centre; a half-space has none")
    if is_moving(found[0]):
        raise InvalidInput(field, name, "an obstacle that stands still; this one has a velocity")
    return placement_of(found[0])


def _bay(shapes: Sequence[Obstacle], name: str) -> pin.SE3 | None:
    """Return the frame of the bay of a shelf, in its middle and turned like the shelf; None if there is no such bay.

    `SHELF/bay 2` is the second one from below; `SHELF/bay 2-1` of a shelf with columns is the first one in that row,
    counted along the y axis.
    """
    match = re.fullmatch(r"(.+)/bay ([1-9]\d{0,5})(?:-([1-9]\d{0,5}))?", name)
    if match is None:
        return None
    shelf, row, column = match[1], int(match[2]), int(match[3] or 1)
    around = [f"board {row}", f"board {row + 1}", f"side {column}", f"side {column + 1}"]
    found = [[shape for shape in shapes if shape.name == f"{shelf}/{part}"] for part in around]
    several_columns = any(shape.name == f"{shelf}/side 3" for shape in shapes)
    if several_columns != (match[3] is not None) or any(len(one) != 1 or is_moving(one[0]) for one in found):
        return None
    below, above, *sides = (placement_of(one[0]) for one in found)
    middle = np.mean([below.actInv(side.translation) for side in sides], axis=0)
    y, z = float(middle[1]), float(below.actInv(above.translation)[2]) / 2
    return below * pin.SE3(np.eye(3), np.array([0.0, y, z]))


def _target(target: Target, shapes: Sequence[Obstacle], where: str) -> Target:
    if isinstance(target, AnyOf):
        found = [_target(one, shapes, f"{where}.any_of[{i}]") for i, one in enumerate(target.any_of)]
        return target.model_copy(update={"any_of": tuple(found)})
    if not isinstance(target, Pose) or target.frame is None:
        return target
    frame = frame_named(shapes, target.frame, f"{where}.frame")
    turned, approach = orientation(target), target.approach
    new: dict[str, object] = {"frame": None, "position": triple(frame.act(np.array(target.position)))}
    if isinstance(approach, Straight):
        new["approach"] = _turned(approach, frame.rotation)
    elif approach is not None:
        new["approach"] = triple(frame.rotation @ np.array(approach))
    if target.retreat is not None:
        new["retreat"] = _turned(target.retreat, frame.rotation)
    if turned is not None:
        x, y, z, w = pin.Quaternion(frame.rotation @ turned).coeffs().tolist()
        new |= {"rpy": None, "quaternion": (w, x, y, z)}
    x_axis, y_axis, z_axis = (triple(column) for column in frame.rotation.T)
    return target.model_copy(update=new).in_axes((x_axis, y_axis, z_axis))


def _turned(straight: Straight, rotation: Array) -> Straight:
    return straight.model_copy(update={"direction": triple(rotation @ np.array(straight.direction))})
