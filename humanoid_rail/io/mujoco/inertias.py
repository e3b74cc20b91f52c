"""The inertias of a robot's links as MuJoCo can have them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.urdf import read_urdf
from humanoid_rail.model.urdf_link import Inertial

SMALLEST = 1e-14
"""Masses and principal moments of inertia are greater than this, kg and kg m^2; MuJoCo refuses 1e-15."""
ROUNDING = 1e-6
"""A principal moment of inertia is greater than the sum of the others by at most this share of it, by rounding."""
PRECISION = 1e-9
"""No principal moment of inertia is nearer to the sum of the others than this share of it."""
MASS = 1e-3
"""What moves and has no mass gets this one, kg."""
SIZE = 0.01
"""What moves and has too little inertia gets that of its mass at this distance, m."""


@dataclass(frozen=True, eq=False)
class BodyInertia:
    """The inertia of a body."""

    mass: float
    """kg."""
    centre: Array
    """The centre of mass (3,) in the frame of the body, m."""
    matrix: Array
    """(3, 3) about the centre of mass in the axes of the body, kg m^2."""


@dataclass(frozen=True, eq=False)
class Inertias:
    """The inertias of a robot as MuJoCo can have them."""

    bodies: Mapping[str, BodyInertia]
    """By link; links without one are not in it."""
    model: pin.Model
    """The robot's model, with what its joints move here."""
    assumed: tuple[str, ...]
    """What is not as in the URDF, a sentence each."""


def mended_inertias(robot: Robot) -> Inertias:
    """Return the inertias of a robot's links, mended where MuJoCo cannot have them.

    MuJoCo wants a mass and three moments of inertia of each body, none greater than the sum of the others. Where a link
    has others, all that its joint moves is one inertia, that of the joint's own link: the motion is the same. Where
    that is none either, the smallest change that makes it one is assumed. What no joint moves needs no inertia.

    Raises:
        InvalidInput: If a joint moves something with a negative moment of inertia.
    """
    links = read_urdf(robot.urdf).links
    moved: dict[int, list[str]] = {}
    for frame in robot.model.frames:
        if frame.type == pin.FrameType.BODY:
            moved.setdefault(frame.parentJoint, []).append(frame.name)
    model, assumed = robot.model, list[str]()
    bodies: dict[str, BodyInertia] = {}
    for joint, names in moved.items():
        own = {name: links[name].inertial for name in names}
        found = {name: _as_written(inertial) for name, inertial in own.items() if _has_any(inertial)}
        able = {name: inertia for name, inertia in found.items() if inertia is not None}
        if joint == 0 or (len(able) == len(found) and found.get(names[0]) is not None):
            bodies |= able
            continue
        total, why = _total(model.names[joint], robot.model.inertias[joint])
        bodies[names[0]] = total
        if why:
            if model is robot.model:
                model = robot.model.copy()
            model.inertias[joint] = pin.Inertia(total.mass, total.centre, total.matrix)
            assumed.append(why)
    return Inertias(bodies, model, tuple(assumed))


def _has_any(inertial: Inertial | None) -> bool:
    return inertial is not None and (inertial.mass != 0 or bool(inertial.inertia.any()))


def _as_written(inertial: Inertial | None) -> BodyInertia | None:
    """Return the inertia of a link; None if MuJoCo cannot have it."""
    assert inertial is not None
    a, b, c = np.linalg.eigvalsh(inertial.inertia)
    # MuJoCo allows no rounding, which the inertias of flat bodies have.
    lacking = max(c - a - b + PRECISION * c, 0.0)
    if not (inertial.mass > SMALLEST and a > SMALLEST and lacking <= ROUNDING * c):
        return None
    # MuJoCo takes a full inertia in the axes of the body alone.
    R = inertial.placement.rotation
    return BodyInertia(
        inertial.mass, inertial.placement.translation, R @ (inertial.inertia + lacking * np.eye(3)) @ R.T
    )


def _total(joint: str, inertia: pin.Inertia) -> tuple[BodyInertia, str]:
    """Return all that a joint moves, up to the next joints, as MuJoCo can have it, and what was assumed, if anything.

    Raises:
        InvalidInput: If a moment of inertia is negative.
    """
    mass, matrix = float(inertia.mass), np.array(inertia.inertia)
    moments, axes = np.linalg.eigh(matrix)
    if moments[0] < -ROUNDING * abs(moments).max():
        valid = "an inertia without negative moments"
        raise InvalidInput(f"inertial of what {joint} moves", moments.tolist(), valid)
    notes, centre = [], np.array(inertia.lever)
    if not mass > SMALLEST:
        mass = MASS
        notes.append(f"a mass of {MASS:g} kg")
    if not moments[0] > SMALLEST:
        least = max(mass * SIZE**2, 2 * SMALLEST)
        moments = np.maximum(moments, least)
        notes.append(f"moments of inertia of at least {least:.2g} kg m^2")
    lacking = max(float(moments[2] - moments[0] - moments[1] + PRECISION * moments[2]), 0.0)
    if lacking > ROUNDING * moments[2]:
        notes.append(f"moments of inertia that are greater by {lacking:.2g} kg m^2")
    matrix = axes @ np.diag(moments + lacking) @ axes.T
    why = f"MuJoCo cannot have the inertia of what {joint} moves; assumed are {' and '.join(notes)}"
    return BodyInertia(mass, centre, (matrix + matrix.T) / 2), why if notes else ""
