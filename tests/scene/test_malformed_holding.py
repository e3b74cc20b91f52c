"""Malformed uses of objects: one clear line each, which names the field, the value and what would be right."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from humanoid_rail import Event, InvalidInput, Robot, load_robot, load_scene, plan, verify
from humanoid_rail.scene.scene import check_scene

DOWN = {"direction": [0, 0, -1], "distance": 0.1}
UP = {"direction": [0, 0, 1], "distance": 0.1}
FIRST: dict[str, Any] = {"left": {"position": [-0.6, 0.3, 0.95], "approach": DOWN, "retreat": UP}, "right": None}
SECOND: dict[str, Any] = {"left": {"position": [0.6, 0.9, 0.97], "approach": DOWN, "retreat": UP}, "right": None}
LAST: dict[str, Any] = {"left": [0.6, 0.9, 1.2], "right": None}
VALID: dict[str, Any] = {
    "name": "carry",
    "robot": "human-sized",
    "targets": [
        {**FIRST, "grasp": {"left": "part"}},
        {**SECOND, "release": {"left": "part"}, "contacts": {"part": ["shelf"]}},
        LAST,
    ],
    "objects": [
        {"type": "box", "name": "part", "center": [-0.6, 0.3, 0.951], "size": [0.05, 0.05, 0.08]},
        {"type": "sphere", "name": "ball", "center": [-0.6, 0.8, 0.96], "radius": 0.03},
    ],
    "obstacles": [
        {"type": "box", "name": "board", "center": [-0.6, 0.3, 0.9], "size": [0.3, 0.5, 0.02]},
        {"type": "box", "name": "shelf", "center": [0.6, 0.9, 0.9], "size": [0.3, 0.5, 0.02]},
        {"type": "halfspace", "name": "floor", "normal": [0, 0, 1], "offset": -0.5},
        {"type": "sphere", "name": "ghost", "center": [3, 3, 3], "radius": 0.1, "velocity": [0.1, 0, 0]},
    ],
}
Path_ = tuple[str | int, ...]
Case = tuple[str, list[tuple[Path_, Any]], str, str]
REMOVED = object()


def put(data: dict[str, Any], path: Path_, value: Any) -> None:
    """Put a value into plain data, or remove what is there."""
    node: Any = data
    for key in path[:-1]:
        node = node[key] if isinstance(node, list) else node.setdefault(key, {})
    if value is REMOVED:
        del node[path[-1]]
    elif isinstance(node, list) and path[-1] == len(node):
        node.append(value)
    else:
        node[path[-1]] = value


def at(step: int, *path: str | int) -> Path_:
    return ("targets", step, *path)


def body(number: int, *path: str | int) -> Path_:
    return ("objects", number, *path)


BOTH = {"left": "part", "right": "part"}
FAR = {"position": [-0.6, 0.9, 0.95], "approach": DOWN, "retreat": UP}
NEAR = {"position": [-0.6, 0.8, 0.98], "approach": DOWN, "retreat": UP}
SCENES: list[Case] = [
    # What is grasped.
    ("grasp of what is not there", [(at(0, "grasp", "left"), "cup")], "targets[0].grasp.left", "there are: part, ball"),
    ("grasp of what is misspelt", [(at(0, "grasp", "left"), "prat")], "targets[0].grasp.left", "did you mean part?"),
    ("grasp in capitals", [(at(0, "grasp", "left"), "Part")], "targets[0].grasp.left", "did you mean part?"),
    ("grasp of an obstacle", [(at(0, "grasp", "left"), "board")], "targets[0].grasp.left", "an object of the scene"),
    ("grasp of a hand", [(at(0, "grasp", "left"), "right")], "targets[0].grasp.left", "an object of the scene"),
    ("grasp of nothing", [(at(0, "grasp", "left"), "")], "targets[0].grasp.left", "there are: part, ball"),
    ("grasp of null", [(at(0, "grasp", "left"), None)], "targets[0].grasp.left", "string"),
    ("grasp of a number", [(at(0, "grasp", "left"), 1)], "targets[0].grasp.left", "string"),
    ("grasp of a list", [(at(0, "grasp", "left"), ["part"])], "targets[0].grasp.left", "string"),
    ("grasp without a hand", [(at(0, "grasp"), "part")], "targets[0].grasp", ""),
    ("grasp by a list", [(at(0, "grasp"), ["left"])], "targets[0].grasp", ""),
    ("grasp by an unknown hand", [(at(0, "grasp"), {"third": "part"})], "targets[0].grasp.third", "left, right"),
    ("grasp by a misspelt hand", [(at(0, "grasp"), {"lef": "part"})], "targets[0].grasp.lef", "did you mean left?"),
    ("no objects", [(("objects",), [])], "targets[0]", "none"),
    ("grasp by a hand without a target", [(at(0, "grasp"), {"right": "part"})], "targets[0].grasp.right", "target"),
    (
        "grasp out of reach of the hand",
        [(at(0, "left", "position"), [-0.6, 0.5, 0.95])],
        "targets[0].grasp.left",
        "0.05 m",
    ),
    (
        "grasp above the object",
        [(at(0, "left", "position"), [-0.6, 0.3, 1.06])],
        "targets[0].grasp.left",
        "within 0.05 m",
    ),
    ("grasp of the other object", [(at(0, "grasp", "left"), "ball")], "targets[0].grasp.left", "m away"),
    ("grasp in millimetres", [(at(0, "left", "position"), [-600, 300, 950])], "targets[0].grasp.left", "m away"),
    ("object in millimetres", [(body(0, "center"), [-600, 300, 951])], "targets[0].grasp.left", "m away"),
    ("a point out of reach", [(at(0, "left"), [0.0, 0.0, 0.0])], "targets[0].grasp.left", "within 0.05 m"),
    ("a line that ends elsewhere", [(at(0, "left"), {"end": [0, 0, 1]})], "targets[0].grasp.left", "within 0.05 m"),
    ("hands too far apart", [(at(0, "right"), FAR), (at(0, "grasp"), BOTH)], "targets[0].grasp.right", "within 0.05 m"),
    ("the second grasp out of reach", [(at(2, "grasp"), {"left": "ball"})], "targets[2].grasp.left", "within 0.05 m"),
    (
        "grasp of what is held",
        [(at(1, "right"), NEAR), (at(1, "grasp"), {"right": "part"}), (at(1, "release"), {}), (at(1, "contacts"), {})],
        "targets[1].grasp.right",
        "left has it",
    ),
    (
        "grasp again by the same hand",
        [(at(1, "grasp"), {"left": "part"}), (at(1, "release"), {})],
        "targets[1].grasp.left",
        "holds nothing",
    ),
    (
        "grasp by a hand that is full",
        [(at(1, "left"), NEAR), (at(1, "grasp"), {"left": "ball"}), (at(1, "release"), {})],
        "targets[1].grasp.left",
        "left holds part",
    ),
    ("grasp while passing", [(at(0, "stop"), False)], "targets[0].stop", "rest"),
    ("release while passing", [(at(1, "stop"), False)], "targets[1].stop", "rest"),
    ("stop as text", [(at(0, "stop"), "maybe")], "targets[0].stop", ""),
    # What is released.
    ("release of what is not held", [(at(0, "grasp"), {})], "targets[1]", "holds"),
    (
        "release of the other object",
        [(at(1, "release"), {"left": "ball"}), (at(1, "contacts"), {})],
        "targets[1].release.left",
        "part",
    ),
    (
        "release of what is not there",
        [(at(1, "release"), {"left": "cup"})],
        "targets[1].release.left",
        "there are: part, ball",
    ),
    ("release misspelt", [(at(1, "release"), {"left": "prt"})], "targets[1].release.left", "did you mean part?"),
    ("release by the other hand", [(at(1, "release"), {"right": "part"})], "targets[1].release.right", "holds nothing"),
    (
        "release by an unknown hand",
        [(at(1, "release"), {"middle": "part"})],
        "targets[1].release.middle",
        "left, right",
    ),
    (
        "release before the grasp",
        [(at(0, "grasp"), {}), (at(0, "release"), {"left": "part"})],
        "targets[0].release.left",
        "holds nothing",
    ),
    ("release twice", [(at(2, "release"), {"left": "part"})], "targets[2].release.left", "holds nothing"),
    ("release of a list", [(at(1, "release"), ["part"])], "targets[1].release", ""),
    ("release as text", [(at(1, "release"), "part")], "targets[1].release", ""),
    (
        "release by one of two hands",
        [(at(0, "right"), FIRST["left"]), (at(0, "grasp"), BOTH)],
        "targets[1].release",
        "left, right",
    ),
    (
        "release in the step of the grasp",
        [(at(0, "release"), {"left": "part"})],
        "targets[0].release.left",
        "holds nothing",
    ),
    # The objects.
    (
        "a half-space as an object",
        [(body(1), {"type": "halfspace", "name": "ball", "normal": [0, 0, 1], "offset": 0})],
        "objects",
        "no end",
    ),
    ("an object that moves", [(body(1, "velocity"), [0, 0, 0.1])], "objects", "velocity"),
    ("an object without a name", [(body(1, "name"), REMOVED)], "objects", "objects[1] has none"),
    ("an object with an empty name", [(body(1, "name"), "")], "objects[1].name", ""),
    ("two objects of a name", [(body(1, "name"), "part")], "objects", "two are called part"),
    ("the name of a link", [(body(1, "name"), "left_forearm")], "objects[1].name", "link"),
    ("the name of a hand", [(body(1, "name"), "left")], "objects[1].name", "hand"),
    ("the name of an obstacle", [(body(1, "name"), "board")], "objects[1].name", "no obstacle"),
    ("a name that is a number", [(body(1, "name"), 7)], "objects[1].name", "string"),
    ("an unknown shape", [(body(1, "type"), "cone")], "objects[1].type", ""),
    ("a misspelt shape", [(body(1, "type"), "spere")], "objects[1].type", "did you mean sphere?"),
    ("no shape", [(body(1, "type"), REMOVED)], "objects[1].type", ""),
    ("a negative radius", [(body(1, "radius"), -0.1)], "objects[1].radius", "greater than 0"),
    ("no size", [(body(0, "size"), REMOVED)], "objects[0].size", ""),
    ("a size of two numbers", [(body(0, "size"), [1, 2])], "objects[0].size", "three numbers"),
    (
        "a mesh that is not there",
        [(body(1), {"type": "mesh", "name": "ball", "file": "none.obj", "center": [0, 0, 0]})],
        "objects[1].file",
        "existing file",
    ),
    ("objects as text", [(("objects",), "part")], "objects", ""),
    ("objects by name", [(("objects",), {"part": {"type": "sphere"}})], "objects", ""),
    ("objects misspelt", [(("object",), []), (("objects",), REMOVED)], "object", "did you mean objects?"),
    # Contacts.
    (
        "contacts of what is not there",
        [(at(1, "contacts"), {"cup": ["shelf"]})],
        "targets[1].contacts.cup",
        "there are: part, ball",
    ),
    ("contacts of an obstacle", [(at(1, "contacts"), {"shelf": ["part"]})], "targets[1].contacts.shelf", "an object"),
    (
        "contacts with what is not there",
        [(at(1, "contacts", "part"), ["table"])],
        "targets[1].contacts.part",
        "there are: part, ball, board",
    ),
    ("contacts misspelt", [(at(1, "contacts", "part"), ["shelv"])], "targets[1].contacts.part", "did you mean shelf?"),
    ("contacts with itself", [(at(1, "contacts", "part"), ["part"])], "targets[1].contacts.part", "another object"),
    ("contacts with a link", [(at(1, "contacts", "part"), ["left_forearm"])], "targets[1].contacts.part", "obstacle"),
    ("contacts with a half-space", [(at(1, "contacts", "part"), ["floor"])], "targets[1].contacts.part", "half-space"),
    ("contacts with what moves", [(at(1, "contacts", "part"), ["ghost"])], "targets[1].contacts.part", "velocity"),
    ("contacts as a name", [(at(1, "contacts", "part"), "shelf")], "targets[1].contacts.part", ""),
    ("contacts of numbers", [(at(1, "contacts", "part"), [1])], "targets[1].contacts.part[0]", "string"),
    ("contacts without an object", [(at(1, "contacts"), ["shelf"])], "targets[1].contacts", ""),
    ("contacts without straight paths", [(at(1, "left"), [0.6, 0.9, 0.97])], "targets[1].contacts", "straight"),
    (
        "contact instead of contacts",
        [(at(1, "contact"), {"part": ["shelf"]}), (at(1, "contacts"), REMOVED)],
        "targets[1].contact",
        "contacts",
    ),
    # Straight paths.
    (
        "a distance of 0",
        [(at(0, "left", "approach"), {**DOWN, "distance": 0})],
        "targets[0].left.approach.distance",
        "greater than 0",
    ),
    (
        "a negative distance",
        [(at(0, "left", "retreat"), {**UP, "distance": -0.1})],
        "targets[0].left.retreat.distance",
        "greater than 0",
    ),
    (
        "a distance in millimetres",
        [(at(0, "left", "approach"), {**DOWN, "distance": 100})],
        "targets[0].left.approach.distance",
        "m",
    ),
    (
        "a retreat in millimetres",
        [(at(0, "left", "retreat"), {**UP, "distance": 150})],
        "targets[0].left.retreat.distance",
        "m",
    ),
    (
        "an infinite distance",
        [(at(0, "left", "approach"), {**DOWN, "distance": "inf"})],
        "targets[0].left.approach.distance",
        "",
    ),
    ("no distance", [(at(0, "left", "approach"), {"direction": [0, 0, -1]})], "targets[0].left.approach.distance", ""),
    ("no direction", [(at(0, "left", "approach"), {"distance": 0.1})], "targets[0].left.approach.direction", ""),
    (
        "direction zero",
        [(at(0, "left", "approach"), {**DOWN, "direction": [0, 0, 0]})],
        "targets[0].left.approach.direction",
        "longer",
    ),
    (
        "direction of a retreat zero",
        [(at(0, "left", "retreat"), {**UP, "direction": [0, 0, 0]})],
        "targets[0].left.retreat.direction",
        "longer",
    ),
    (
        "a direction as text",
        [(at(0, "left", "approach"), {**DOWN, "direction": "down"})],
        "targets[0].left.approach.direction",
        "",
    ),
    ("a retreat as a direction", [(at(0, "left", "retreat"), [0, 0, 1])], "targets[0].left.retreat", "distance"),
    (
        "pointing and rpy",
        [(at(0, "left"), {**FIRST["left"], "approach": {**DOWN, "pointing": True}, "rpy": [0, 0, 0]})],
        "targets[0].left",
        "not approach and rpy",
    ),
    (
        "pointing as text",
        [(at(0, "left", "approach"), {**DOWN, "pointing": "down"})],
        "targets[0].left.approach.pointing",
        "",
    ),
    ("an unknown field", [(at(0, "left", "approach"), {**DOWN, "length": 1})], "targets[0].left.approach.length", ""),
    ("a line with a start alone", [(at(0, "left"), {"start": [-0.6, 0.3, 0.95]})], "targets[0].left.end", "required"),
    ("a line of two numbers", [(at(0, "left"), {"end": [-0.6, 0.3]})], "targets[0].left.end", "three numbers"),
    (
        "a line with a position",
        [(at(2, "left"), {"end": [0, 0, 1], "position": [0, 0, 1]})],
        "targets[2].left.position",
        "",
    ),
    # Targets of objects.
    ("a target of what no hand holds", [(at(2, "ball"), [0.6, 0.9, 1.2])], "targets[2].ball", "a hand holds"),
    ("a target of what was released", [(at(2, "part"), [0.6, 0.9, 1.2])], "targets[2].part", "a hand holds"),
    ("targets of an object and its hand", [(at(1, "part"), [0.6, 0.9, 0.95])], "targets[1].left", "no target"),
    ("a target of an obstacle", [(at(2, "board"), [0.6, 0.9, 1.2])], "targets[2].board", "hands"),
]


@pytest.fixture(scope="module")
def small() -> Robot:
    return load_robot("human-sized")


def written(data: dict[str, Any], folder: Path) -> Path:
    path = folder / "scene.yaml"
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


def is_clear(error: InvalidInput, field: str, says: str) -> None:
    message = str(error)
    assert error.field.startswith(field), message
    assert says in error.valid, message
    assert message.count("\n") == 0
    assert "; valid: " in message
    assert len(error.valid) > 3, message
    assert len(message) < 400, message


def test_the_scene_itself_is_valid(small: Robot, tmp_path: Path) -> None:
    check_scene(small, load_scene(written(VALID, tmp_path)))


@pytest.mark.parametrize(("changes", "field", "says"), [case[1:] for case in SCENES], ids=[case[0] for case in SCENES])
def test_what_is_wrong_in_a_scene(
    changes: list[tuple[Path_, Any]], field: str, says: str, small: Robot, tmp_path: Path
) -> None:
    data = copy.deepcopy(VALID)
    for path, value in changes:
        put(data, path, value)
    with pytest.raises(InvalidInput) as caught:
        check_scene(small, load_scene(written(data, tmp_path)))
    is_clear(caught.value, field, says)


class Standing:
    """A robot that stands still for two seconds, with what happens meanwhile."""

    def __init__(self, robot: Robot, events: tuple[Event, ...]) -> None:
        self.t = np.linspace(0.0, 2.0, 3)
        self.q = np.tile(robot.initial, (3, 1))
        self.events = events


def happens(t: float, kind: str, name: str = "part", hands: Any = ("left",), contacts: Any = ()) -> Callable[[], Event]:
    return lambda: Event(t, kind, name, hands, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), contacts)


GRASP = happens(0.5, "grasp")
EVENTS: list[tuple[str, tuple[Callable[[], Event], ...], str, str]] = [
    ("out of order", (GRASP, happens(0.2, "release")), "trajectory.events[1].t", "not before"),
    ("before the motion", (happens(-0.1, "grasp"),), "event.t", "from 0"),
    ("after the motion", (happens(2.1, "grasp"),), "trajectory.events[0].t", "from 0 to 2 s"),
    ("never", (happens(float("nan"), "grasp"),), "event.t", "from 0"),
    ("of an unknown kind", (happens(0.5, "drop"),), "event.kind", "release"),
    ("of a misspelt kind", (happens(0.5, "graps"),), "event.kind", "did you mean grasp?"),
    ("of an unknown object", (happens(0.5, "grasp", "cup"),), "trajectory.events[0].object", "part"),
    ("of an obstacle", (happens(0.5, "grasp", "board"),), "trajectory.events[0].object", "one of part, ball"),
    ("by an unknown hand", (happens(0.5, "grasp", hands=("third",)),), "trajectory.events[0].hands", "left, right"),
    ("by no hand", (happens(0.5, "grasp", hands=()),), "trajectory.events[0]", "hands that hold nothing"),
    ("grasped twice", (GRASP, happens(0.7, "grasp", hands=("right",))), "trajectory.events[1]", "no hand holds"),
    ("by a full hand", (GRASP, happens(0.7, "grasp", "ball")), "trajectory.events[1]", "hold nothing"),
    ("released before", (happens(0.5, "release"),), "trajectory.events[0]", "held then"),
    ("released twice", (GRASP, happens(0.7, "release"), happens(0.8, "release")), "trajectory.events[2]", "held then"),
    ("by one hand twice", (happens(0.5, "grasp", hands=("left", "left")),), "event.hands", "each once"),
    ("contacts as a name in an event", (happens(0.5, "clear", contacts="left"),), "event.contacts", "a list"),
    ("contacts unknown", (happens(0.5, "clear", contacts=("table",)),), "trajectory.events[0].contacts", "one of"),
    (
        "contacts with a half-space in an event",
        (happens(0.5, "clear", contacts=("obstacles[2] (floor)",)),),
        "trajectory.events[0].contacts",
        "half-space",
    ),
    (
        "contacts with what moves in an event",
        (happens(0.5, "clear", contacts=("obstacles[3] (ghost)",)),),
        "trajectory.events[0].contacts",
        "velocity",
    ),
]


@pytest.mark.parametrize(("events", "field", "says"), [case[1:] for case in EVENTS], ids=[case[0] for case in EVENTS])
def test_what_is_wrong_in_events(
    events: tuple[Callable[[], Event], ...], field: str, says: str, small: Robot, tmp_path: Path
) -> None:
    scene = load_scene(written(VALID, tmp_path))
    with pytest.raises(InvalidInput) as caught:
        verify(small, scene, Standing(small, tuple(event() for event in events)))
    is_clear(caught.value, field, says)


def test_what_stands_on_something_is_lifted_straight(small: Robot, tmp_path: Path) -> None:
    data = copy.deepcopy(VALID)
    del data["targets"][0]["left"]["retreat"]
    with pytest.raises(InvalidInput) as caught:
        plan(small, load_scene(written(data, tmp_path)))
    is_clear(caught.value, "targets[0].left.retreat", "part stands on obstacles[0] (board)")


def test_there_are_as_many_as_promised() -> None:
    names = [case[0] for case in SCENES] + [case[0] for case in EVENTS]
    assert len(names) == len(set(names)) >= 100
