"""Which hands hold what, where objects are, and the robot with the objects as bodies."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.model.attached import ObjectBody, with_objects
from humanoid_rail.model.hand_links import hand_bodies
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.objects import object_named, pieces_of, placed_at
from humanoid_rail.scene.obstacles import Obstacle, is_moving, name_of
from humanoid_rail.scene.placing import placement_of
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.shapes import PlacedShape, distance_between, placed_shapes

Contacts = Mapping[str, frozenset[str]]
"""What each object may touch, by its name: links, other objects, and obstacles as errors call them."""


@dataclass(frozen=True, eq=False)
class Held:
    """An object in the hands of a robot."""

    hands: tuple[str, ...]
    """The hands that hold it; it moves with the first one."""
    placement: pin.SE3
    """Where its frame is in that of the first hand."""


@dataclass(frozen=True, eq=False)
class Holding:
    """Where the objects of a scene are."""

    standing: Mapping[str, pin.SE3]
    """Where the frame of each object that no hand holds is in the base frame."""
    held: Mapping[str, Held] = field(default_factory=dict)
    """The others."""


def at_the_start(scene: Scene) -> Holding:
    """Return where the objects of a scene are at first: no hand holds any."""
    return Holding({str(one.name): placement_of(one) for one in scene.objects})


def hand_placement(robot: Robot, hand: str, q: Array) -> pin.SE3:
    """Return where the frame of a hand is in the base frame at a configuration (n,)."""
    data = robot.model.createData()
    frame = robot.model.getFrameId(robot.hands[robot.hand(hand)].frame)
    pin.forwardKinematics(robot.model, data, robot.full_configuration(q))
    return pin.updateFramePlacement(robot.model, data, frame).copy()


def object_placement(robot: Robot, holding: Holding, name: str, q: Array) -> pin.SE3:
    """Return where the frame of an object is in the base frame, with the robot at a configuration (n,)."""
    if name in holding.standing:
        return holding.standing[name]
    held = holding.held[name]
    return hand_placement(robot, held.hands[0], q) * held.placement


def after_release(robot: Robot, holding: Holding, names: Iterable[str], q: Array) -> Holding:
    """Return what is held after some objects were released at a configuration (n,): they stand where they are."""
    standing, held = dict(holding.standing), dict(holding.held)
    for name in names:
        standing[name] = object_placement(robot, holding, name, q)
        del held[name]
    return Holding(standing, held)


def after_grasp(robot: Robot, holding: Holding, grasps: Mapping[str, tuple[str, ...]], q: Array) -> Holding:
    """Return what is held after hands, by the names of objects, grasped these at a configuration (n,)."""
    standing, held = dict(holding.standing), dict(holding.held)
    for name, hands in grasps.items():
        held[name] = Held(hands, hand_placement(robot, hands[0], q).inverse() * standing.pop(name))
    return Holding(standing, held)


def supports(robot: Robot, scene: Scene, holding: Holding, name: str, q: Array, within: float) -> frozenset[str]:
    """Return the obstacles and other objects that an object is near, as a contact with them is called.

    Obstacles that move are none of them: an object on one would not stand still.

    Args:
        robot: The robot.
        scene: The scene.
        holding: Where its objects are.
        name: The object.
        q: Where the robot is (n,), m and rad.
        within: How near, m.
    """
    pieces = placed_at(object_named(scene.objects, name), object_placement(robot, holding, name, q))
    found = set[str]()
    for number, obstacle in enumerate(scene.obstacles):
        if not is_moving(obstacle) and _distance(pieces, placed_shapes(obstacle)) < within:
            found.add(name_of(scene.obstacles, number))
    for other, place in holding.standing.items():
        if other != name and _distance(pieces, placed_at(object_named(scene.objects, other), place)) < within:
            found.add(other)
    return frozenset(found)


def _distance(one: Iterable[PlacedShape], other: Collection[PlacedShape]) -> float:
    return min(distance_between(a, b) for a in one for b in other)


def robot_among(robot: Robot, scene: Scene, holding: Holding, contacts: Contacts) -> tuple[Robot, tuple[Obstacle, ...]]:
    """Return the robot with the objects as links, and the obstacles that are left.

    What an object may touch is not checked against it. An obstacle that one may touch becomes a link that stays where
    it is, as every link is checked against every obstacle.

    Args:
        robot: The robot.
        scene: The scene.
        holding: Where its objects are.
        contacts: What each of them may touch.
    """
    if not scene.objects:
        return robot, scene.obstacles
    touched = frozenset[str]().union(*contacts.values())
    names = [name_of(scene.obstacles, i) for i in range(len(scene.obstacles))]
    bodies = [_body(robot, scene, holding, str(one.name), contacts) for one in scene.objects]
    bodies += [
        ObjectBody(name, *pieces_of(obstacle, pin.SE3.Identity()))
        for name, obstacle in zip(names, scene.obstacles, strict=True)
        if name in touched
    ]
    return with_objects(robot, bodies), _left(scene.obstacles, [name not in touched for name in names])


def _left(obstacles: tuple[Obstacle, ...], stays: Sequence[bool]) -> tuple[Obstacle, ...]:
    """Return those obstacles that stay, called as before, although their numbers are others."""
    if all(stays):
        return obstacles
    return tuple(one.to_be_called(name_of(obstacles, i)) for i, one in enumerate(obstacles) if stays[i])


def among_moving(
    robot: Robot, scene: Scene, holding: Holding, contacts: Contacts
) -> tuple[Robot, tuple[Obstacle, ...]]:
    """Return the robot with the objects as links, and the obstacles that move.

    It is what :func:`robot_among` returns without obstacles as links: that one of these comes to touch one that moves
    says nothing of the robot.
    """
    bodies = [_body(robot, scene, holding, str(one.name), contacts) for one in scene.objects]
    return with_objects(robot, bodies), _left(scene.obstacles, [is_moving(one) for one in scene.obstacles])


def _body(robot: Robot, scene: Scene, holding: Holding, name: str, contacts: Contacts) -> ObjectBody:
    shape = object_named(scene.objects, name)
    shapes, placements = pieces_of(shape, placement_of(shape))
    joint, place = 0, holding.standing.get(name)
    may_touch = set(contacts.get(name, ()))
    if place is None:
        held = holding.held[name]
        frame = robot.model.frames[robot.model.getFrameId(robot.hands[robot.hand(held.hands[0])].frame)]
        joint, place = frame.parentJoint, frame.placement * held.placement
        may_touch.update(link for hand in held.hands for link in links_that_hold(robot, hand))
    return ObjectBody(name, shapes, tuple(place * there for there in placements), joint, frozenset(may_touch))


def links_that_hold(robot: Robot, hand: str) -> frozenset[str]:
    """Return the links that touch what a hand holds."""
    return frozenset(robot.link_names[body] for body in hand_bodies(robot, hand))


def allowed(robot: Robot, contacts: Iterable[str]) -> frozenset[str]:
    """Return what an object may touch by the names of links, other objects and obstacles; hands are their links."""
    found = set[str]()
    for name in contacts:
        found |= links_that_hold(robot, name) if name in robot.hand_names else {name}
    return frozenset(found)
