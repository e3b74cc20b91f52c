"""Objects that hands grasp and release, in MuJoCo: free bodies, which welds fix to hands from grasp to release."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import coal
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.events import Event, EventKind
from humanoid_rail.io.mujoco.mjcf_bodies import body_names, find, numbers, place_attributes, shape_attributes
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.model.hand_links import hand_bodies, link_of
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.urdf import read_urdf
from humanoid_rail.scene.objects import pieces_of
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.scene.placing import placement_of
from humanoid_rail.scene.shapes import PlacedShape
from humanoid_rail.trajectory import Trajectory

DENSITY = 400.0
"""Objects are as dense as light wood, kg/m^3."""


def inertia_of(shape: Obstacle) -> pin.Inertia:
    """Return the inertia of an object in its own frame."""
    inertia = pin.Inertia.Zero()
    for piece, at in _pieces(shape):
        mass = DENSITY * piece.computeVolume()
        own = pin.Inertia(mass, piece.computeCOM(), DENSITY * piece.computeMomentofInertiaRelatedToCOM())
        inertia += at.act(own)
    return inertia


def check_events(robot: Robot, objects: Sequence[Obstacle], trajectory: Trajectory) -> None:
    """Check that what the events name is there.

    Raises:
        InvalidInput: If an object or a hand is not, or two objects have one name, or one has none.
    """
    names = [str(shape.name) for shape in objects]
    for name in names:
        if name == "None" or names.count(name) > 1:
            raise InvalidInput("scene.objects", names, "objects with names of their own")
    for k, event in enumerate(trajectory.events):
        if event.object not in names:
            valid = f"an object of the scene{did_you_mean(event.object, names)}: {', '.join(names) or 'there are none'}"
            raise InvalidInput(f"trajectory.events[{k}].object", event.object, valid)
        for hand in event.hands:
            if hand not in robot.hand_names:
                raise InvalidInput(f"trajectory.events[{k}].hands", hand, f"hands: {', '.join(robot.hand_names)}")


def add_objects(document: Element, robot: Robot, objects: Sequence[Obstacle], trajectory: Trajectory) -> Array:
    """Add objects to a model, with a weld for each hand that grasps one; return what they add to qpos.

    A hand's own bodies and what it grasps do not touch.

    Args:
        document: The MJCF.
        robot: The robot.
        objects: The objects.
        trajectory: The motion with its events.

    Raises:
        InvalidInput: If an event names an object or a hand that is not there.
    """
    check_events(robot, objects, trajectory)
    world, assets, qpos = find(document, "worldbody"), find(document, "asset"), list[float]()
    names, links = object_names(robot, objects), body_names(robot)
    for shape in objects:
        name, pose = names[str(shape.name)], placement_of(shape)
        body = SubElement(world, "body", {"name": name, **place_attributes(pose)})
        SubElement(body, "freejoint", name=name)
        inertia = inertia_of(shape)
        moments = numbers(inertia.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])
        SubElement(body, "inertial", pos=numbers(inertia.lever), mass=repr(inertia.mass), fullinertia=moments)
        for k, (piece, at) in enumerate(_pieces(shape)):
            attributes = shape_attributes(PlacedShape(piece, coal_placement(at)))
            if isinstance(piece, coal.ConvexBase):
                attributes["mesh"] = f"{name} piece {k}"
                SubElement(assets, "mesh", name=attributes["mesh"], vertex=numbers(np.ravel(piece.points())))
            SubElement(body, "geom", {"class": "object", "name": f"{name} {k}" if k else name, **attributes})
        x, y, z, w = pin.Quaternion(pose.rotation).coeffs()
        qpos += [*pose.translation, w, x, y, z]
    held = [(grasp.object, hand) for grasp, _ in grasps(trajectory.events) for hand in grasp.hands]
    for name, hand in dict.fromkeys(held):
        own = robot.hands[robot.hand(hand)]
        bodies = links[link_of(read_urdf(robot.urdf), own.frame)], names[name]
        attributes = {"name": weld_name(name, hand), "body1": bodies[0], "body2": bodies[1], "active": "false"}
        SubElement(find(document, "equality"), "weld", attributes)
        for link in dict.fromkeys(robot.link_names[i] for i in hand_bodies(robot, hand)):
            SubElement(find(document, "contact"), "exclude", body1=links[link], body2=names[name])
    return np.array(qpos)


def object_names(robot: Robot, objects: Sequence[Obstacle]) -> dict[str, str]:
    """Return what objects are called in MuJoCo, where no link is called the same."""
    taken, names = {*body_names(robot).values(), *robot.model.names}, dict[str, str]()
    for shape in objects:
        name = str(shape.name)
        while name in taken or name in ("world", "universe"):
            name += "_"
        taken.add(name)
        names[str(shape.name)] = name
    return names


def weld_name(name: str, hand: str) -> str:
    """Return the name of the weld that fixes an object to a hand."""
    return f"{name} in {hand}"


def event_arrays(robot: Robot, objects: Sequence[Obstacle], trajectory: Trajectory) -> dict[str, Any]:
    """Return what the player has to know of events and objects; nothing without objects."""
    if not objects:
        return {}
    rows = [
        (t, weld_name(grasp.object, hand), active)
        for grasp, end in grasps(trajectory.events)
        for t, active in ((grasp.t, True), (end, False))
        for hand in grasp.hands
        if np.isfinite(t)
    ]
    ends = dict(zip(object_names(robot, objects).values(), (placement_of(o).translation for o in objects), strict=True))
    for event in trajectory.events:  # where one is that is held at the end is not known here
        if event.kind in (EventKind.GRASP, EventKind.RELEASE):
            name = object_names(robot, objects)[event.object]
            ends[name] = np.array(event.position if event.kind == EventKind.RELEASE else 3 * [np.nan])
    return {
        "event_time": np.array([t for t, _, _ in rows]),
        "event_weld": np.array([weld for _, weld, _ in rows], str),
        "event_active": np.array([active for _, _, active in rows], bool),
        "object_name": np.array(list(ends), str),
        "object_end": np.array(list(ends.values())).reshape(-1, 3),
    }


def grasps(events: Sequence[Event]) -> list[tuple[Event, float]]:
    """Return each grasp and when it ends, s; infinite of an object that is held to the end."""
    found = list[tuple[Event, float]]()
    for i, grasp in enumerate(events):
        if grasp.kind == EventKind.GRASP:
            after = (e.t for e in events[i + 1 :] if e.object == grasp.object and e.kind == EventKind.RELEASE)
            found.append((grasp, next(after, np.inf)))
    return found


def held_load(robot: Robot, objects: Sequence[Obstacle], trajectory: Trajectory) -> Array:
    """Return what bears the weight of objects that are held, at the samples (N, n), N and N m.

    Each of several hands bears the same share.
    """
    model, by_name = robot.model, {str(shape.name): shape for shape in objects}
    data, load = model.createData(), np.zeros_like(trajectory.q)
    for grasp, end in grasps(trajectory.events):
        w, x, y, z = grasp.quaternion
        pose = pin.SE3(pin.Quaternion(w, x, y, z), np.array(grasp.position))
        inertia = inertia_of(by_name[grasp.object])
        weight = -inertia.mass * model.gravity.linear / len(grasp.hands)
        middle = pose.act(inertia.lever)
        for hand in grasp.hands:
            frame = model.getFrameId(robot.hands[robot.hand(hand)].frame)
            at_grasp = robot.full_configuration(trajectory.configuration(grasp.t))
            pin.framesForwardKinematics(model, data, at_grasp)
            lever = data.oMf[frame].actInv(middle)
            for i in np.flatnonzero((trajectory.t >= grasp.t) & (trajectory.t < end)):
                load[i] += _bearing(robot, data, frame, lever, weight, trajectory.q[i])
    return load


def _bearing(robot: Robot, data: Any, frame: int, lever: Array, force: Array, q: Array) -> Array:
    """Return the forces of the actuators (n,) that make a force at a point of a frame, N and N m."""
    jacobian = pin.computeFrameJacobian(
        robot.model, data, robot.full_configuration(q), frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    )
    # The frame's placement is not always brought up to date by the above.
    arm = pin.updateFramePlacement(robot.model, data, frame).rotation @ lever
    torques: Array = robot.coupling.T @ (jacobian[:3].T @ force + jacobian[3:].T @ np.cross(arm, force))
    return torques


def _pieces(shape: Obstacle) -> list[tuple[Any, pin.SE3]]:
    """Return the convex pieces of an object and where they are in its frame, m."""
    return list(zip(*pieces_of(shape, placement_of(shape)), strict=True))
