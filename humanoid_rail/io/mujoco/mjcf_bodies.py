"""The links of a robot as bodies of MJCF, the format of MuJoCo, and what else is written in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from xml.etree.ElementTree import Element, SubElement

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.io.mujoco.actuators import PositionActuator
from humanoid_rail.io.mujoco.inertias import BodyInertia, Inertias
from humanoid_rail.io.mujoco.visual_meshes import FOLDER, VisualMeshes, file_of
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.urdf import read_urdf
from humanoid_rail.model.urdf_joint import Joint
from humanoid_rail.model.urdf_link import Link, MeshFile
from humanoid_rail.scene.shapes import PlacedShape, support
from humanoid_rail.viewer.colours import PLAIN, hand_colour, rgb

WORLD = "world"
"""MuJoCo gives this name to the body that everything stands on."""
SMALLEST_RANGE = 1e-6
"""The range of a joint that is held is this, m or rad, as MuJoCo has none of length 0."""


def body_names(robot: Robot) -> dict[str, str]:
    """Return what the links are called in MuJoCo, where only the root can be called `world`."""
    links = list(read_urdf(robot.urdf).links)
    names = dict(zip(links, links, strict=True))
    root = next(frame.name for frame in robot.model.frames if frame.type == pin.FrameType.BODY)
    if root != WORLD and WORLD in names:
        while names[WORLD] in links:
            names[WORLD] += "_"
    return names


def add_robot(
    world: Element, robot: Robot, actuators: Sequence[PositionActuator], inertias: Inertias, meshes: VisualMeshes
) -> None:
    """Add a robot to the world: a body for each link, and a site `NAME_hand` at each hand.

    Args:
        world: The element to add to.
        robot: The robot.
        actuators: Those of its actuated joints.
        inertias: Those of its links.
        meshes: Its visual meshes.

    Raises:
        InvalidInput: If a collision body has no thickness.
    """
    urdf, names = read_urdf(robot.urdf), body_names(robot)
    links, joints = urdf.links, urdf.joints
    limits = {actuator.joint: actuator.effort_limit for actuator in actuators}
    frames = robot.model.frames
    elements: dict[str, Element] = {}
    for index, frame in enumerate(frames):
        if frame.type != pin.FrameType.BODY:
            continue
        joint_frame = frames[frame.parentFrame]
        joint = None if not elements else joints[joint_frame.name]  # nothing holds the root
        body, name = world, names[frame.name]
        if name != WORLD:
            parent = world if joint is None else elements[joint.parent]
            place = place_attributes(pin.SE3.Identity() if joint is None else joint.placement)
            body = SubElement(parent, "body", {"name": name, **place})
            if frame.name in inertias.bodies:
                _add_inertial(body, inertias.bodies[frame.name])
        elements[frame.name] = body
        if joint is not None and joint_frame.type == pin.FrameType.JOINT:
            _add_joint(body, joint, robot, limits.get(joint_frame.name))
        for attributes in visual_attributes(links[frame.name], meshes):
            SubElement(body, "geom", {"class": "visual", **attributes})
        for collision in robot.collision_model.geometryObjects:
            if collision.parentFrame == index:
                _add_collision(body, collision, frame.placement.inverse() * collision.placement)
    _add_hands(elements, robot)


def _add_hands(elements: Mapping[str, Element], robot: Robot) -> None:
    frames = robot.model.frames
    for i, (hand, reach) in enumerate(zip(robot.hands, robot.arm_reaches, strict=True)):
        frame = frames[robot.model.getFrameId(hand.frame)]
        link = frame
        if frame.type != pin.FrameType.BODY:
            link = next(f for f in frames if (f.type, f.parentJoint) == (pin.FrameType.BODY, frame.parentJoint))
        place = place_attributes(link.placement.inverse() * frame.placement)
        size, rgba = numbers(site_size(reach, 0.03)), f"{numbers(rgb(hand_colour(i)))} 1"
        SubElement(elements[link.name], "site", {"name": f"{hand.name}_hand", "size": size, "rgba": rgba, **place})


def site_size(reach: float, largest: float) -> float:
    """Return the radius of a site at the hand of an arm of some reach, m: at most that at the paper's arm, of 2 m."""
    return float(min(largest, largest * max(reach, 0.1) / 2.0))


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
    if shape["type"] == "mesh":
        shape["mesh"] = collision.name
    elif not min(float(size) for size in shape["size"].split()) > 0:
        raise InvalidInput(f"collision body {collision.name}", shape["size"], "sizes greater than 0 m, for MuJoCo")
    SubElement(body, "geom", {"class": "collision", "name": collision.name, **shape})


def _add_inertial(body: Element, inertia: BodyInertia) -> None:
    SubElement(
        body,
        "inertial",
        pos=numbers(inertia.centre),
        mass=repr(inertia.mass),
        fullinertia=numbers(inertia.matrix[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]),
    )


def add_mesh_assets(assets: Element, robot: Robot, meshes: VisualMeshes) -> None:
    """Add the meshes of a robot: the files of the visual ones, and the corners of its convex collision bodies."""
    for parts in meshes.parts.values():
        for part in parts:
            # As a shell: other inertias need a volume, and none of them is used.
            SubElement(assets, "mesh", name=f"{FOLDER}/{part.name}", file=file_of(part), inertia="shell")
    for body in robot.collision_model.geometryObjects:
        if isinstance(body.geometry, coal.ConvexBase):
            corners = numbers(np.ravel(body.geometry.points()))
            SubElement(assets, "mesh", name=body.name, vertex=corners, inertia="shell")


def visual_attributes(link: Link, meshes: VisualMeshes) -> Iterator[dict[str, str]]:
    """Yield the attributes of the geoms that show a link: a mesh has one for each part of a colour."""
    for body in link.visuals:
        if isinstance(body.shape, MeshFile):
            for part in meshes.of(body):
                rgba = numbers(body.rgba or part.rgba or PLAIN)
                yield {
                    "rgba": rgba,
                    "type": "mesh",
                    "mesh": f"{FOLDER}/{part.name}",
                    **place_attributes(body.placement),
                }
        else:
            placed = PlacedShape(body.shape, coal_placement(body.placement))
            yield {"rgba": numbers(PLAIN if body.rgba is None else body.rgba), **shape_attributes(placed)}


def underside(robot: Robot, meshes: VisualMeshes) -> float:
    """Return the lowest point of what is seen of the links that no joint moves, m; 0 if that is nothing."""
    down, links = np.array([0.0, 0.0, -1.0]), read_urdf(robot.urdf).links
    lowest = []
    for frame in robot.model.frames:
        if frame.type != pin.FrameType.BODY or frame.parentJoint != 0:
            continue
        for body in links[frame.name].visuals:
            at = frame.placement * body.placement
            if not isinstance(body.shape, MeshFile):
                lowest.append(-support(PlacedShape(body.shape, coal_placement(at)), down))
            for part in meshes.of(body):
                heights = part.corners @ at.rotation[2] + at.translation[2]
                lowest.append(float(heights.min()))
    return min(lowest, default=0.0)


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
            return {"type": "mesh", **place_attributes(at)}
        case _:
            raise TypeError(f"MJCF has no {type(shape).__name__}")
    return {"type": kind, "size": numbers(size), **place_attributes(at)}


def place_attributes(at: pin.SE3) -> dict[str, str]:
    """Return the attributes of a body that say where it is."""
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
