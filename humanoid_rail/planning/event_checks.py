"""Whether the events of a motion, which may come from a file, are such as can be."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.events import Event, EventKind
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.objects import why_no_contact
from humanoid_rail.scene.obstacles import name_of
from humanoid_rail.scene.scene import Scene


def checked_events(robot: Robot, scene: Scene, t: Array, events: Sequence[Event]) -> tuple[Event, ...]:
    """Return the events of a motion.

    Args:
        robot: The robot, without objects.
        scene: The scene, with the objects.
        t: The times of the motion (N,), s.
        events: What happens along it.

    Raises:
        InvalidInput: If one is not in the motion or out of order, names what is not there, grasps what is held, or
            releases what is not.
    """
    for i, (sooner, later) in enumerate(pairwise(events), start=1):
        if later.t < sooner.t:
            raise InvalidInput(f"trajectory.events[{i}].t", later.t, f"not before the event before it, at {sooner.t} s")
    held: dict[str, tuple[str, ...]] = {}
    for i, event in enumerate(events):
        _check_names(f"trajectory.events[{i}]", robot, scene, event)
        if not t[0] <= event.t <= t[-1]:
            valid = f"a time of the motion, from {t[0]:.6g} to {t[-1]:.6g} s"
            raise InvalidInput(f"trajectory.events[{i}].t", event.t, valid)
        busy = {hand: name for name, hands in held.items() for hand in hands}
        if event.kind == EventKind.GRASP:
            taken = event.object in held or not event.hands or any(hand in busy for hand in event.hands)
            if taken:
                valid = f"an object that no hand holds, and hands that hold nothing; held then: {held or 'nothing'}"
                raise InvalidInput(f"trajectory.events[{i}]", str(event), valid)
            held[event.object] = event.hands
        elif event.kind == EventKind.RELEASE and held.pop(event.object, None) is None:
            raise InvalidInput(f"trajectory.events[{i}]", str(event), "the release of an object that is held then")
    return tuple(events)


def _check_names(field: str, robot: Robot, scene: Scene, event: Event) -> None:
    objects = [str(one.name) for one in scene.objects]
    obstacles = [name_of(scene.obstacles, i) for i in range(len(scene.obstacles))]
    kinds = [kind.value for kind in EventKind]
    known = {
        "kind": ([event.kind], kinds),
        "object": ([event.object], objects),
        "hands": (event.hands, robot.hand_names),
        "contacts": (event.contacts, [*robot.hand_names, *objects, *obstacles]),
    }
    for name, (given, valid) in known.items():
        for one in given:
            if one not in valid:
                there = ", ".join(valid) or "none"
                raise InvalidInput(f"{field}.{name}", one, f"one of {there}{did_you_mean(one, valid)}")
    for name, obstacle in zip(obstacles, scene.obstacles, strict=True):
        if name in event.contacts and (valid_instead := why_no_contact(obstacle)):
            raise InvalidInput(f"{field}.contacts", name, valid_instead)
