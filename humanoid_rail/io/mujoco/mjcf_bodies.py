"""The links of a robot as bodies of MJCF, the format of MuJoCo, and what else is written in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from xml.etree.ElementTree import Element, SubElement

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.io.mujoco.actuators import PositionActuator
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.urdf import read_urdf
from humanoid_rail.model.urdf_joint import Joint
from humanoid_rail.model.urdf_link import Link, MeshFile
from humanoid_rail.scene.shapes import PlacedShape
from humanoid_rail.viewer.colours import PLAIN, hand_colour, rgb

WORLD = "world"
"""MuJoCo gives this name to the body that everything stands on."""
SMALLEST_INERTIA = 1e-14
"""Masses and principal moments of inertia are greater than this, kg and kg m^2; MuJoCo refuses 1e-15."""
ROUNDING = 1e-6
"""A principal moment of inertia is greater than the sum of the others by at most this share of it, by rounding."""
PRECISION = 1e-9
"""No principal moment of inertia is nearer to the sum of the others than this share of it."""
SMALLEST_RANGE = 1e-6
"""The range of a joint that is held is this, m or rad, as MuJoCo has none of length 0."""


def add_robot(world: Element, robot: Robot, actuators: Sequence[PositionActuator]) -> None:
    """Add a robot to the world: a body for each link, and a site `NAME_hand` at each hand.

    Args:
        world: The element to add to.
        robot: The robot.
        actuators: Those of its actuated joints.

    Raises:
        InvalidInput: If a collision body has no thickness, MuJoCo cannot have an inertia, or a link called `world` is
            not the root.
    """
    urdf = read_urdf(robot.urdf)
    links, joints = urdf.links, urdf.joints
    limits = {actuator.joint: actuator.effort_limit for actuator in actuators}
    frames = robot.model.frames
    elements = {WORLD: world}
    for index, frame in enumerate(frames):
        if frame.type != pin.FrameType.BODY:
            continue
        joint_frame = frames[frame.parentFrame]
        joint = joints.get(joint_frame.name)
        if frame.name == WORLD and joint is not None:
            raise InvalidInput(f"link {WORLD}", f"moved by joint {joint.name}", "the root or another name, for MuJoCo")
        parent = world if joint is None else elements[frames[joint_frame.parentFrame].name]
        if frame.name != WORLD:
            place = _place(pin.SE3.Identity() if joint is None else joint.placement)
            elements[frame.name] = SubElement(parent, "body", {"name": frame.name, **place})
            _add_inertial(elements[frame.name], links[frame.name])
        body = elements[frame.name]
        if joint is not None and joint_frame.type == pin.FrameType.JOINT:
            _add_joint(body, joint, robot, limits.get(joint_frame.name))
        for visual, colour in visuals(links[frame.name]):
            SubElement(body, "geom", {"class": "visual", "rgba": colour, **shape_attributes(visual)})
        for collision in robot.collision_model.geometryObjects:
            if collision.parentFrame == index:
                _add_collision(body, collision, frame.placement.inverse() * collision.placement)
    for i, hand in enumerate(robot.hands):
        frame = frames[robot.model.getFrameId(hand.frame)]
        link = frame
        if frame.type != pin.FrameType.BODY:
            link = next(f for f in frames if (f.type, f.parentJoint) == (pin.FrameType.BODY, frame.parentJoint))
        place = _place(link.placement.inverse() * frame.placement)
        site = {"name": f"{hand.name}_hand", "size": "0.03", "rgba": f"{numbers(rgb(hand_colour(i)))} 1", **place}
        SubElement(elements[link.name], "site", site)


def _add_joint(body: Element, joint: Joint, robot: Robot, effort_limit: float | None) -> None:
    """Add a joint; `effort_limit` is None of passive ones, which follow their leaders without limits of their own."""
    kind = "slide" if joint.kind == "prismatic" else "hinge"
    attributes = {"name": joint.name, "type": kind, "axis": numbers(joint.axis)}
    if effort_limit is not None:
        i = robot.joint_names.index(joint.name)
        lower, upper = robot.lower[i], robot.upper[i]
        attributes["range"] = numbers([lower, max(upper, lower + SMALLEST_RANGE)])
        if np.isfinite(effort_limit):
            attributes["actuatorfrcrange"] = numbers([-effort_limit, effort_limit])
    SubElement(body, "joint", attributes)


def _add_collision(body: Element, collision: pin.GeometryObject, at: pin.SE3) -> None:
    shape = shape_attributes(PlacedShape(collision.geometry, coal_placement(at)))
    if not min(float(size) for size in shape["size"].split()) > 0:
        raise InvalidInput(f"collision body {collision.name}", shape["size"], "sizes greater than 0 m, for MuJoCo")
    SubElement(body, "geom", {"class": "collision", "name": collision.name, **shape})


def _add_inertial(body: Element, link: Link) -> None:
    """Add the inertia of a link, none if it has no mass.

    Raises:
        InvalidInput: If MuJoCo cannot have it.
    """
    inertial = link.inertial
    if inertial is None or (inertial.mass == 0 and not inertial.inertia.any()):
        return
    a, b, c = np.linalg.eigvalsh(inertial.inertia)
    # MuJoCo allows no rounding, which the inertias of flat bodies have.
    lacking = max(c - a - b + PRECISION * c, 0.0)
    if not (inertial.mass > SMALLEST_INERTIA and a > SMALLEST_INERTIA and lacking <= ROUNDING * c):
        found = f"mass {inertial.mass:g} and principal moments {a:g}, {b:g}, {c:g}"
        valid = f"all greater than {SMALLEST_INERTIA:g} and no moment greater than the sum of the others, for MuJoCo"
        raise InvalidInput(f"link {link.name}.inertial", found, valid)
    # MuJoCo takes a full inertia in the axes of the body alone.
    at = inertial.placement
    inertia = at.rotation @ (inertial.inertia + lacking * np.eye(3)) @ at.rotation.T
    SubElement(
        body,
        "inertial",
        pos=numbers(at.translation),
        mass=repr(inertial.mass),
        fullinertia=numbers(inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]),
    )


def visuals(link: Link) -> Iterator[tuple[PlacedShape, str]]:
    """Yield the primitive visual bodies of a link, in its frame, and their colours."""
    for body in link.visuals:
        if not isinstance(body.shape, MeshFile):
            yield (
                PlacedShape(body.shape, coal_placement(body.placement)),
                numbers(PLAIN if body.rgba is None else body.rgba),
            )


def shape_attributes(placed: PlacedShape) -> dict[str, str]:
    """Return the attributes of a geom but the vertices of a convex body, which are an asset."""
    shape, at = placed.shape, pin.SE3(placed.placement.getRotation(), placed.placement.getTranslation())
    match shape:
        case coal.Sphere():
            kind, size = "sphere", [shape.radius]
        case coal.Capsule():
            kind, size = "capsule", [shape.radius, shape.halfLength]
        case coal.Cylinder():
            kind, size = "cylinder", [shape.radius, shape.halfLength]
        case coal.Box():
            kind, size = "box", shape.halfSide
        case coal.Halfspace():  # it has no end: 0, and a grid of 1 m
            kind, size = "plane", [0.0, 0.0, 1.0]
            at = at * pin.SE3(pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), shape.n), shape.d * shape.n)
        case coal.ConvexBase():
            return {"type": "mesh", **_place(at)}
        case _:
            raise TypeError(f"MJCF has no {type(shape).__name__}")
    return {"type": kind, "size": numbers(size), **_place(at)}


def _place(at: pin.SE3) -> dict[str, str]:
    x, y, z, w = pin.Quaternion(at.rotation).coeffs()
    return {"pos": numbers(at.translation), "quat": numbers([w, x, y, z])}


def numbers(values: ArrayLike) -> str:
    """Return numbers as text, without loss."""
    return " ".join(repr(float(x)) for x in np.atleast_1d(np.asarray(values, float)))


def find(element: Element, path: str) -> Element:
    """Return a child that has to be there.

    Raises:
        InvalidInput: If it is not.
    """
    found = element.find(path)
    if found is None:
        raise InvalidInput(f"urdf.{element.tag}.{path}", MISSING, "an element of that name")
    return found
