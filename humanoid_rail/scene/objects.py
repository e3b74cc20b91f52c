"""The objects of a scene that hands can hold: where they stand, and whether steps say what can be done with them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import coal
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import HalfSpace, Obstacle, is_moving
from humanoid_rail.scene.placing import placement_of
from humanoid_rail.scene.shapes import PlacedShape, distance_between, placed_shapes
from humanoid_rail.scene.targets import Line, Pose, Step, Straight, Target, pointing_direction, position

GRASP_REACH = 0.05
"""The point of a hand is no farther than this from what it grasps, m."""
Pieces = tuple[tuple[coal.CollisionGeometry, ...], tuple[pin.SE3, ...]]
"""The convex pieces of an object, and where each is in its frame."""


def pieces_of(shape: Obstacle, frame: pin.SE3) -> Pieces:
    """Return the convex pieces of an object or an obstacle in a frame, given in the base frame."""
    placed = placed_shapes(shape)
    inverse = frame.inverse()
    return (
        tuple(piece.shape for piece in placed),
        tuple(inverse * pin.SE3(piece.placement.getRotation(), piece.placement.getTranslation()) for piece in placed),
    )


def placed_at(shape: Obstacle, frame: pin.SE3) -> list[PlacedShape]:
    """Return the convex pieces of an object in the base frame, its own frame being at a place."""
    pieces = zip(*pieces_of(shape, placement_of(shape)), strict=True)
    return [PlacedShape(one, coal_placement(frame * there)) for one, there in pieces]


def distance_from_point(shape: Obstacle, frame: pin.SE3, point: Array) -> float:
    """Return how far a point (3,) is from an object whose frame is at a place, m; negative within it."""
    tip = PlacedShape(coal.Sphere(0.0), coal.Transform3s(np.eye(3), point))
    return min(distance_between(piece, tip) for piece in placed_at(shape, frame))


def check_objects(objects: Sequence[Obstacle]) -> None:
    """Check that objects can be held: each has a name of its own, ends somewhere and does not move by itself.

    Raises:
        ValueError: If one cannot be.
    """
    known = set[str]()
    for number, one in enumerate(objects):
        if one.name is None:
            raise ValueError(
                f"objects with a name each: the steps say by it what is grasped; objects[{number}] has none"
            )
        if one.name in known:
            raise ValueError(f"objects with a name each; two are called {one.name}")
        if isinstance(one, HalfSpace):
            raise ValueError(f"objects that a hand can hold; {one.name} is a half-space, which has no end")
        if is_moving(one):
            raise ValueError(f"objects that stand still until they are grasped; {one.name} has a velocity")
        known.add(one.name)


def why_no_contact(obstacle: Obstacle) -> str | None:
    """Return what would be right where an object may not touch an obstacle; None if it may.

    What an object may touch counts as a link that stays where it is and ends somewhere.
    """
    if isinstance(obstacle, HalfSpace):
        return "an obstacle that ends somewhere, such as a box as large as the floor; this one is a half-space"
    if is_moving(obstacle):
        return "an obstacle that stands still; this one has a velocity"
    return None


def object_named(objects: Sequence[Obstacle], name: str) -> Obstacle:
    """Return the object of a name, which is there."""
    return next(one for one in objects if one.name == name)


def check_holding(
    robot: Robot,
    objects: Sequence[Obstacle],
    obstacles: Sequence[Obstacle],
    steps: Sequence[Step],
    fields: Sequence[str],
) -> None:
    """Check what steps say of objects: who grasps, holds, releases and moves what.

    Args:
        robot: The robot.
        objects: What can be held.
        obstacles: What cannot.
        steps: The steps, one after the other.
        fields: What errors call each of them.

    Raises:
        InvalidInput: If a hand grasps what is not there or held, holds something already, releases what it does not
            hold, or a name is not known.
    """
    frames = {frame.name for frame in robot.model.frames}
    for number, one in enumerate(objects):
        if one.name in frames or one.name in robot.hand_names:
            valid = f"a name that nothing of the robot has; it is that of {_what(robot, str(one.name))}"
            raise InvalidInput(f"objects[{number}].name", one.name, valid)
        if one.name in {obstacle.name for obstacle in obstacles}:
            valid = "a name that no obstacle has, as contacts say by it what may be touched"
            raise InvalidInput(f"objects[{number}].name", one.name, valid)
    names = [str(one.name) for one in objects]
    held: dict[str, tuple[str, ...]] = {}
    standing = {str(one.name): one for one in objects}
    for where, step in zip(fields, steps, strict=True):
        _check_contacts(where, step, names, obstacles)
        _check_targets(where, robot, step, names, held)
        _check_release(where, robot, step, names, held)
        _check_grasp(where, robot, step, names, held)
        held = held_after(step, held)
        _check_reach(where, step, standing)
        standing = {name: one for name, one in standing.items() if name not in held}


def by_object(hands: Mapping[str, str]) -> dict[str, tuple[str, ...]]:
    """Return the hands of each object from the objects of hands."""
    found: dict[str, tuple[str, ...]] = {}
    for hand, name in hands.items():
        found[name] = (*found.get(name, ()), hand)
    return found


def held_after(step: Step, held: Mapping[str, tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
    """Return the hands of each object that is held after a step, from those before it."""
    kept = {name: hands for name, hands in held.items() if name not in step.release.values()}
    return {**kept, **by_object(step.grasp)}


def held_targets(steps: Sequence[Step], number: int) -> dict[str, tuple[str, ...]]:
    """Return the hands of each held object that a step has a target for, of steps whose grasps were checked."""
    held: dict[str, tuple[str, ...]] = {}
    for step in steps[:number]:
        held = held_after(step, held)
    return {name: hands for name, hands in held.items() if name in steps[number]}


def _check_targets(
    where: str, robot: Robot, step: Step, names: Sequence[str], held: Mapping[str, tuple[str, ...]]
) -> None:
    """Check the targets of objects: they have to be held, and their hands have no targets of their own."""
    for name, target in step.items():
        if name not in names or target is None:
            continue
        if name not in held:
            raise InvalidInput(
                f"{where}.{name}", target, "a target for an object that a hand holds; no hand holds it then"
            )
        if isinstance(target, Pose) and pointing_direction(target) is not None:
            valid = "the orientation of an object as rpy: an object points nowhere"
            raise InvalidInput(f"{where}.{name}.approach", pointing_direction(target), valid)
        for hand in held[name]:
            if step.get(hand) is not None:
                valid = f"no target: the hand holds {name}, which has one"
                raise InvalidInput(f"{where}.{hand}", step[hand], valid)


def check_straight(robot: Robot, where: str, target: Target) -> None:
    """Check that the straight ways of a hand to a target and from it are not longer than it can go.

    Raises:
        InvalidInput: If one is.
    """
    if not isinstance(target, Pose):
        return
    for name, way in (("approach", target.approach), ("retreat", target.retreat)):
        if isinstance(way, Straight) and way.distance > 2.0 * robot.farthest_hand:
            valid = (
                f"at most {2.0 * robot.farthest_hand:.4g} m: no hand gets half as far from the base; in millimetres?"
            )
            raise InvalidInput(f"{where}.{name}.distance", way.distance, valid)


def _what(robot: Robot, name: str) -> str:
    return "a hand" if name in robot.hand_names else "a link or frame"


def _check_contacts(where: str, step: Step, names: Sequence[str], obstacles: Sequence[Obstacle]) -> None:
    others = [*names, *(str(one.name) for one in obstacles if one.name is not None)]
    for name, touched in step.contacts.items():
        _check_known(f"{where}.contacts.{name}", name, names)
        for other in touched:
            if other not in others or other == name:
                valid = f"the name of an obstacle or of another object{did_you_mean(other, others)}"
                raise InvalidInput(
                    f"{where}.contacts.{name}", other, f"{valid}; there are: {', '.join(others) or 'none'}"
                )
            for obstacle in obstacles:
                if obstacle.name == other and (valid_instead := why_no_contact(obstacle)):
                    raise InvalidInput(f"{where}.contacts.{name}", other, valid_instead)
    if step.contacts and not any(_is_straight(target) for target in step.values()):
        valid = "given for a step with a straight approach or retreat: contacts are allowed on these alone"
        raise InvalidInput(f"{where}.contacts", dict(step.contacts), valid)


def _is_straight(target: object) -> bool:
    if isinstance(target, Line):
        return True
    return isinstance(target, Pose) and (isinstance(target.approach, Straight) or target.retreat is not None)


def _check_release(
    where: str, robot: Robot, step: Step, names: Sequence[str], held: Mapping[str, tuple[str, ...]]
) -> None:
    """Check that hands release what they hold, all that hold an object together."""
    for hand, name in step.release.items():
        field = f"{where}.release.{hand}"
        _check_hand(field, robot, hand)
        _check_known(field, name, names)
        if hand not in held.get(name, ()):
            holding = next((other for other, hands in held.items() if hand in hands), None)
            valid = f"what the hand holds then: {holding}" if holding else "nothing: the hand holds nothing then"
            raise InvalidInput(field, name, valid)
    for name, hands in held.items():
        letting_go = {hand for hand in hands if step.release.get(hand) == name}
        if letting_go and letting_go != set(hands):
            valid = f"released by all hands that hold it: {', '.join(hands)}"
            raise InvalidInput(f"{where}.release", dict(step.release), f"{name} {valid}")


def _check_grasp(
    where: str, robot: Robot, step: Step, names: Sequence[str], before: Mapping[str, tuple[str, ...]]
) -> None:
    """Check that hands which hold nothing grasp objects that nothing holds, once a step has released what it says."""
    if not step.stop and (step.grasp or step.release):
        raise InvalidInput(f"{where}.stop", False, "true where hands grasp or release something: they rest meanwhile")
    held = {name: hands for name, hands in before.items() if name not in step.release.values()}
    for hand, name in step.grasp.items():
        field = f"{where}.grasp.{hand}"
        _check_hand(field, robot, hand)
        _check_known(field, name, names)
        if step.get(hand) is None:
            raise InvalidInput(field, name, f"a grasp of a hand that has a target in this step; {hand} has none")
        holding = next((other for other, hands in held.items() if hand in hands), None)
        if holding is not None:
            raise InvalidInput(field, name, f"an object for a hand that holds nothing; {hand} holds {holding} then")
        if name in held:
            raise InvalidInput(field, name, f"an object that no hand holds; {', '.join(held[name])} has it then")


def _check_reach(where: str, step: Step, standing: Mapping[str, Obstacle]) -> None:
    """Check that hands are where they grasp: at what stands where the scene has put it."""
    for hand, name in step.grasp.items():
        target = step[hand]
        if name not in standing or target is None:
            continue
        far = distance_from_point(standing[name], placement_of(standing[name]), np.array(position(target)))
        if far > GRASP_REACH:
            valid = f"an object at the target of the hand, within {GRASP_REACH:g} m; it is {far:.3g} m away"
            raise InvalidInput(f"{where}.grasp.{hand}", name, valid)


def _check_hand(field: str, robot: Robot, hand: str) -> None:
    if hand not in robot.hand_names:
        near = did_you_mean(hand, robot.hand_names)
        raise InvalidInput(field, hand, f"a hand of the robot{near}; there are: {', '.join(robot.hand_names)}")


def _check_known(field: str, name: str, names: Sequence[str]) -> None:
    if name not in names:
        valid = (
            f"the name of an object of the scene{did_you_mean(name, names)}; there are: {', '.join(names) or 'none'}"
        )
        raise InvalidInput(field, name, valid)
