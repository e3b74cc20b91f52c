"""The links of a robot as bodies of MJCF, the format of MuJoCo, and what else is written in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.io.mujoco.actuators import PositionActuator
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.shapes import PlacedShape
from humanoid_rail.viewer.colours import hand_colour, rgb

WORLD = "world"
"""MuJoCo gives this name to the body that everything stands on."""
PLAIN = "0.7 0.7 0.7 1"
"""Bodies without a colour of their own are drawn in this one."""


def add_robot(world: Element, robot: Robot, actuators: Sequence[PositionActuator]) -> None:
    """Add a robot to the world: a body for each link, and a site `NAME_hand` at each hand.

    Args:
        world: The element to add to.
        robot: The robot.
        actuators: Those of its actuated joints.

    Raises:
        InvalidInput: If a collision body has no thickness.
    """
    urdf = ElementTree.fromstring(robot.urdf)
    links = {link.attrib["name"]: link for link in urdf.findall("link")}
    joints = {joint.attrib["name"]: joint for joint in urdf.findall("joint")}
    limits = {actuator.joint: actuator.effort_limit for actuator in actuators}
    frames = robot.model.frames
    elements = {WORLD: world}
    for index, frame in enumerate(frames):
        if frame.type != pin.FrameType.BODY:
            continue
        joint_frame = frames[frame.parentFrame]
        joint = joints.get(joint_frame.name)
        parent = world if joint is None else elements[frames[joint_frame.parentFrame].name]
        if frame.name != WORLD or joint is not None:
            place = _place(pin.SE3.Identity() if joint is None else _origin(joint))
            elements[frame.name] = SubElement(parent, "body", {"name": frame.name, **place})
            _add_inertial(elements[frame.name], links[frame.name])
        body = elements[frame.name]
        if joint is not None and joint_frame.type == pin.FrameType.JOINT:
            _add_joint(body, joint, robot, limits.get(joint_frame.name))
        for visual, colour in visuals(urdf, frame.name):
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


def _add_joint(body: Element, joint: Element, robot: Robot, effort_limit: float | None) -> None:
    """Add a joint; `effort_limit` is None of passive ones, which follow their leaders without limits of their own."""
    name, kind = joint.attrib["name"], "slide" if joint.attrib["type"] == "prismatic" else "hinge"
    axis = joint.find("axis")
    attributes = {"name": name, "type": kind, "axis": "1 0 0" if axis is None else axis.attrib["xyz"]}
    if effort_limit is not None:
        i = robot.joint_names.index(name)
        attributes["range"] = numbers([robot.lower[i], robot.upper[i]])
        if np.isfinite(effort_limit):
            attributes["actuatorfrcrange"] = numbers([-effort_limit, effort_limit])
    SubElement(body, "joint", attributes)


def _add_collision(body: Element, collision: pin.GeometryObject, at: pin.SE3) -> None:
    shape = shape_attributes(PlacedShape(collision.geometry, coal.Transform3s(at.rotation, at.translation)))
    if not min(float(size) for size in shape["size"].split()) > 0:
        raise InvalidInput(f"collision body {collision.name}", shape["size"], "sizes greater than 0 m, for MuJoCo")
    SubElement(body, "geom", {"class": "collision", "name": collision.name, **shape})


def _add_inertial(body: Element, link: Element) -> None:
    inertial = link.find("inertial")
    if inertial is None or not float(find(inertial, "mass").attrib["value"]) > 0:
        return
    at = _origin(inertial)
    xx, xy, xz, yy, yz, zz = (
        float(find(inertial, "inertia").attrib[name]) for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    )
    # MuJoCo takes a full inertia in the axes of the body alone.
    inertia = at.rotation @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ at.rotation.T
    SubElement(
        body,
        "inertial",
        pos=numbers(at.translation),
        mass=find(inertial, "mass").attrib["value"],
        fullinertia=numbers(inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]),
    )


def visuals(urdf: Element, link: str) -> Iterator[tuple[PlacedShape, str]]:
    """Yield the primitive visual bodies of a link, in its frame, and their colours."""
    materials = {material.get("name"): material for material in urdf.findall("material")}
    for visual in (v for each in urdf.findall("link") if each.get("name") == link for v in each.findall("visual")):
        material = visual.find("material")
        if material is not None and material.find("color") is None:
            material = materials.get(material.get("name"))
        colour = None if material is None else material.find("color")
        at = _origin(visual)
        placement = coal.Transform3s(at.rotation, at.translation)
        shape = _primitive(link, find(visual, "geometry/*"))
        if shape is not None:
            yield PlacedShape(shape, placement), PLAIN if colour is None else colour.attrib["rgba"]


def _primitive(link: str, element: Element) -> coal.ShapeBase | None:
    """Return a shape of a URDF; None of a mesh.

    Raises:
        InvalidInput: If it is a shape that URDF does not have.
    """
    size = {name: [float(x) for x in element.get(name, "").split()] for name in ("size", "radius", "length")}
    match element.tag:
        case "box":
            return coal.Box(*size["size"])
        case "cylinder":
            return coal.Cylinder(*size["radius"], *size["length"])
        case "sphere":
            return coal.Sphere(*size["radius"])
        case "mesh":
            return None
        case tag:
            raise InvalidInput(f"visual body of {link}", tag, "box, cylinder, sphere or mesh")


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


def _origin(element: Element) -> pin.SE3:
    """Return the `<origin>` of an element of a URDF, which may be missing."""
    origin = element.find("origin")
    xyz, rpy = ("0 0 0", "0 0 0") if origin is None else (origin.get(k, "0 0 0") for k in ("xyz", "rpy"))
    return pin.SE3(pin.rpy.rpyToMatrix(*map(float, rpy.split())), np.array(xyz.split(), float))


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
