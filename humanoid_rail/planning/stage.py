"""What has happened to the objects of a scene up to a moment of a motion, and what happens next."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array, triple
from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.events import Event, EventKind
from humanoid_rail.holding.holding import (
    Contacts,
    Holding,
    after_grasp,
    after_release,
    allowed,
    at_the_start,
    hand_placement,
    object_placement,
    robot_among,
    supports,
)
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.moves import Happening, Move
from humanoid_rail.scene.objects import GRASP_REACH, distance_from_point, object_named, why_no_contact
from humanoid_rail.scene.obstacles import Obstacle, name_of
from humanoid_rail.scene.scene import Scene, field_of_step

SUPPORT = 0.02
"""An object stands on what is nearer to it than this when it is grasped, m."""


@dataclass(frozen=True, eq=False)
class Stage:
    """Where objects are, what they may touch, and what has happened to them."""

    holding: Holding
    contacts: Contacts = field(default_factory=dict)
    events: tuple[Event, ...] = ()

    def robot(self, robot: Robot, scene: Scene) -> tuple[Robot, tuple[Obstacle, ...]]:
        """Return the robot with the objects as links, and what is an obstacle."""
        return robot_among(robot, scene, self.holding, self.contacts)


def first_stage(scene: Scene) -> Stage:
    """Return where the objects of a scene are before anything has happened."""
    return Stage(at_the_start(scene))


def after_happenings(
    stage: Stage, robot: Robot, scene: Scene, move: Move, happenings: Sequence[Happening], t: float, q: Array
) -> Stage:
    """Return what is true after something has happened to objects.

    Args:
        stage: What was true before.
        robot: The robot, without objects.
        scene: The scene.
        move: The move at whose begin or end it happens.
        happenings: What happens, in order.
        t: When, s.
        q: Where the robot is (n,), m and rad.

    Raises:
        InvalidInput: If a hand is not at what it is to grasp, or an object that stands on something is not to be lifted
            from it by a straight retreat.
    """
    for happening in happenings:
        stage = _after(stage, robot, scene, move, happening, t, q)
    return stage


def _after(stage: Stage, robot: Robot, scene: Scene, move: Move, happening: Happening, t: float, q: Array) -> Stage:
    name, hands, contacts, holding = happening.object, happening.hands, list(happening.contacts), stage.holding
    if happening.kind is EventKind.RELEASE:
        holding = after_release(robot, holding, [name], q)
    elif happening.kind is EventKind.GRASP:
        _check_at_hands(stage, robot, scene, move, happening, q)
        below = supports(robot, scene, holding, name, q, SUPPORT)
        _check_supports(scene, happening, below)
        _check_retreat(scene, move, happening, sorted(below - set(contacts)))
        contacts += sorted(below - set(contacts))
        holding = after_grasp(robot, holding, {name: hands}, q)
    place = object_placement(robot, holding, name, q)
    w_last = pin.Quaternion(place.rotation).coeffs()
    event = Event(t, happening.kind, name, hands, triple(place.translation), _w_first(w_last), tuple(contacts))
    touched = {**stage.contacts, name: allowed(robot, contacts)}
    return replace(stage, holding=holding, contacts=touched, events=(*stage.events, event))


def _w_first(coefficients: Array) -> tuple[float, float, float, float]:
    x, y, z, w = (float(c) for c in coefficients)
    return (w, x, y, z)


def _check_at_hands(stage: Stage, robot: Robot, scene: Scene, move: Move, happening: Happening, q: Array) -> None:
    for hand in happening.hands:
        point: Array = np.array(hand_placement(robot, hand, q).translation)
        shape = object_named(scene.objects, happening.object)
        far = distance_from_point(shape, stage.holding.standing[happening.object], point)
        if far > GRASP_REACH:
            valid = f"an object at the hand, within {GRASP_REACH:g} m of its point; it is {far:.3g} m away then"
            raise InvalidInput(f"{field_of_step(scene, move.step)}.grasp.{hand}", happening.object, valid)


def _check_supports(scene: Scene, happening: Happening, below: Collection[str]) -> None:
    for number, obstacle in enumerate(scene.obstacles):
        if name_of(scene.obstacles, number) in below and (valid := why_no_contact(obstacle)):
            raise InvalidInput(f"obstacles[{number}]", obstacle.type, f"{valid}, and {happening.object} stands on it")


def _check_retreat(scene: Scene, move: Move, happening: Happening, below: Sequence[str]) -> None:
    step = scene.steps[move.step]
    if below and all(getattr(step.get(hand), "retreat", None) is None for hand in happening.hands):
        hand = happening.hands[0]
        valid = "given, such as {direction: [0, 0, 1], distance: 0.1}"
        valid += f": {happening.object} stands on {', '.join(below)}, from which it is lifted straight"
        raise InvalidInput(f"{field_of_step(scene, move.step)}.{hand}.retreat", MISSING, valid)
