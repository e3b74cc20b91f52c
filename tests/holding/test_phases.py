"""Certificates of motions on which objects are grasped: what contacts are called, and what is checked."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from humanoid_rail import Certificate, Event, InvalidInput, Robot, Scene, verify
from humanoid_rail._native import why_no_engine
from humanoid_rail.paper import dh_table as dh

pytestmark = pytest.mark.skipif(why_no_engine() is not None, reason="certificates take the native engine")


def at_hand(robot: Robot, offset: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> tuple[float, ...]:
    """Return a point near the left hand at the start, m."""
    return tuple((dh.hands(robot.initial)[0] + offset).tolist())


def grasp(contacts: tuple[str, ...] = ()) -> tuple[Event, ...]:
    place: Any = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
    return (
        Event(0.0, "approach", "part", ("left",), *place, ("left",)),
        Event(0.5, "grasp", "part", ("left",), *place, contacts),
    )


def certificate(robot: Robot, obstacles: list[dict[str, Any]], events: tuple[Event, ...], reach: float) -> Certificate:
    """Return the certificate of a motion of the carriage by `reach`, m, with a ball in the left hand."""
    q = np.array(robot.initial) + np.outer([0.0, 0.0, reach], np.eye(12)[0])
    ball = {"type": "sphere", "name": "part", "center": at_hand(robot), "radius": 0.06}
    scene = Scene.model_validate({"name": "s", "targets": {}, "objects": [ball], "obstacles": obstacles})
    return verify(robot, scene, SimpleNamespace(t=np.array([0.0, 0.5, 2.0]), q=q, events=events))


def sphere(center: tuple[float, ...], **more: Any) -> dict[str, Any]:
    return {"type": "sphere", "center": center, "radius": 0.05, **more}


def test_contacts_are_called_as_in_the_scene_where_another_obstacle_may_be_touched(robot: Robot) -> None:
    """The number of an obstacle does not change as one before it becomes a link."""
    below, ahead = at_hand(robot, (0.0, -0.5, -2.0)), at_hand(robot, (0.0, 1.0, 0.0))
    found = certificate(robot, [sphere(below), sphere(ahead)], grasp(("obstacles[0] (sphere)",)), 1.5)
    assert found.contact is not None
    assert found.contact.other == "obstacles[1] (sphere)"
    pairs = {frozenset((pair.link, pair.other)) for pair in found.unchecked_pairs}
    assert {frozenset(("part", "left_forearm")), frozenset(("part", "obstacles[0] (sphere)"))} <= pairs


def test_obstacles_that_come_to_touch_each_other_say_nothing_of_the_robot(robot: Robot) -> None:
    here = at_hand(robot, (0.0, 0.0, -0.5))
    start = at_hand(robot, (0.0, 0.0, -1.0))
    through = sphere(start, velocity=(0.0, 0.0, 0.3))
    contacts = grasp(("obstacles[0] (sphere)",))
    found = certificate(robot, [sphere(here), {**through, "center": start}], contacts, 0.0)
    assert found.certified, found.contact
    # What moves is checked nevertheless.
    faster = certificate(robot, [sphere(here), {**through, "velocity": (0.0, 0.0, 0.7)}], contacts, 0.0)
    assert faster.contact is not None
    assert faster.contact.other == "obstacles[1] (sphere)"


def test_an_object_that_is_dragged_through_an_obstacle_is_not_certified(robot: Robot) -> None:
    ahead = at_hand(robot, (0.0, 0.5, -0.1))
    dragged, free = (certificate(robot, [sphere(ahead)], grasp(), reach) for reach in (1.0, 0.2))
    assert free.certified, free.contact
    assert not dragged.certified
    assert dragged.contact is not None
    assert {dragged.contact.link, dragged.contact.other} >= {"obstacles[0] (sphere)"}


@pytest.mark.parametrize(
    ("obstacle", "says"),
    [
        ({"type": "halfspace", "normal": (0.0, 0.0, 1.0), "offset": -1.0}, "half-space"),
        ({**sphere((3.0, 3.0, 3.0)), "velocity": (0.1, 0.0, 0.0)}, "velocity"),
    ],
)
def test_what_has_no_end_or_moves_cannot_be_touched(robot: Robot, obstacle: dict[str, Any], says: str) -> None:
    with pytest.raises(InvalidInput, match=says):
        certificate(robot, [obstacle], grasp((f"obstacles[0] ({obstacle['type']})",)), 0.1)
