"""Targets as people state them: what is taken, where it is in the base frame, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from humanoid_rail import InvalidInput, Robot, make_scene
from humanoid_rail.planning.target_tasks import tasks_of
from humanoid_rail.scene.joint_targets import joint_targets
from humanoid_rail.scene.poses import Pose, orientation
from humanoid_rail.scene.scene import check_scene

SHELF = {"type": "shelf", "name": "shelf", "center": [1, 0.5, 0.2], "size": [0.4, 1.2, 1.6], "rpy": [0, 0, 0.7]}
BOX = {"type": "box", "name": "box", "center": [1, 0.4, 1], "size": [0.1, 0.1, 0.1], "rpy": [0.3, -0.4, 0.5]}
TWINS = [{"type": "sphere", "name": "twin", "center": [x, 5, 5], "radius": 0.1} for x in (4, 5)]
MOVING = {"type": "sphere", "name": "cart", "center": [5, 5, 5], "radius": 0.1, "velocity": [0.1, 0, 0]}
FLOOR = {"type": "halfspace", "name": "floor", "normal": [0, 0, 1], "offset": -5}
OBSTACLES = [SHELF, BOX, *TWINS, MOVING, FLOOR]


@pytest.fixture(scope="module")
def posed(robot: Robot) -> Robot:
    return replace(robot, postures={"home": tuple(robot.initial.tolist())})


def steps_of(targets: Any) -> Any:
    return make_scene({"targets": targets, "obstacles": OBSTACLES}).steps


def left_of(target: Any) -> Any:
    return steps_of({"left": target, "right": None})[0].get("left")


def test_a_quaternion_is_the_rotation_of_the_same_angles() -> None:
    rng = np.random.default_rng(3)
    for angles in [*rng.uniform(-3, 3, (20, 3)), (0.3, np.pi / 2, 0.0), (0.0, -np.pi / 2, 1.0), (np.pi, 0.0, 0.0)]:
        turned = pin.rpy.rpyToMatrix(*angles)
        x, y, z, w = pin.Quaternion(turned).coeffs()
        pose = left_of({"position": [0, 0, 1], "quaternion": [w, x, y, z]})
        np.testing.assert_allclose(orientation(pose), turned, atol=1e-14)


def test_a_quaternion_that_is_rounded_gets_length_1() -> None:
    pose = left_of({"position": [0, 0, 1], "quaternion": [0.707, 0, 0.7071, 0]})
    assert np.linalg.norm(pose.quaternion) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("how", ["point", "rpy", "quaternion", "approach", "straight"])
def test_a_pose_in_the_frame_of_a_box_is_where_the_box_takes_it(how: str) -> None:
    frame = pin.SE3(pin.rpy.rpyToMatrix(*BOX["rpy"]), np.array(BOX["center"], float))
    turned, towards = pin.rpy.rpyToMatrix(0.2, 0.3, -0.9), np.array([0.0, 0.6, 0.8])
    x, y, z, w = pin.Quaternion(turned).coeffs()
    more: Any = {
        "point": {},
        "rpy": {"rpy": [0.2, 0.3, -0.9]},
        "quaternion": {"quaternion": [w, x, y, z]},
        "approach": {"approach": towards.tolist()},
        "straight": {"approach": {"direction": towards.tolist(), "distance": 0.1}},
    }[how]
    pose = left_of({"position": [0.1, 0.2, -0.3], "frame": "box", **more})
    np.testing.assert_allclose(pose.position, frame.act(np.array([0.1, 0.2, -0.3])), atol=1e-14)
    assert pose.frame is None
    if how in ("rpy", "quaternion"):
        np.testing.assert_allclose(orientation(pose), frame.rotation @ turned, atol=1e-14)
    if how in ("approach", "straight"):
        there = pose.approach if how == "approach" else pose.approach.direction
        np.testing.assert_allclose(there, frame.rotation @ towards, atol=1e-14)


def test_a_scene_keeps_its_targets_as_they_are_stated() -> None:
    scene = make_scene(
        {"targets": {"left": {"position": [0, 0, 0], "frame": "box"}, "right": None}, "obstacles": OBSTACLES}
    )
    assert scene.targets.get("left") == Pose(position=(0.0, 0.0, 0.0), frame="box")


@pytest.mark.parametrize(("columns", "name", "across"), [(1, "bay 2", 0.0), (3, "bay 2-3", 1.0)])
def test_a_bay_is_in_the_middle_of_its_boards(columns: int, name: str, across: float) -> None:
    shelf = {**SHELF, "columns": columns, "rows": 4}
    scene = make_scene(
        {
            "targets": {"left": {"position": [0.05, 0, 0], "frame": f"shelf/{name}"}, "right": None},
            "obstacles": [shelf],
        }
    )
    pose = scene.steps[0].get("left")
    _, width, height = SHELF["size"]
    # The free height of four bays with five boards, and the free width of three with four.
    row = (height - 5 * 0.02) / 4
    column = (width - (columns + 1) * 0.02) / columns
    inside = np.array([0.05, across * (column + 0.02), 0.02 + row + 0.02 + row / 2])
    expected = pin.rpy.rpyToMatrix(*SHELF["rpy"]) @ inside + SHELF["center"]
    np.testing.assert_allclose(pose.position, expected, atol=1e-12)


def test_tolerances_are_along_the_axes_of_the_frame(robot: Robot) -> None:
    (step,) = steps_of({"left": {"position": [0, 0, 0], "frame": "box", "tolerance": [0.1, 0.2, 0.3]}, "right": None})
    (task,) = tasks_of(robot, step)
    np.testing.assert_allclose(task.tolerance, [0.1, 0.2, 0.3], atol=2e-6)
    np.testing.assert_allclose(np.array(task.axes).T, pin.rpy.rpyToMatrix(*BOX["rpy"]), atol=1e-15)


def test_a_posture_is_about_the_joints_that_move_no_hand_with_a_target(posed: Robot) -> None:
    alone, mixed, both = steps_of(
        [
            {"posture": "home"},
            {"posture": "home", "left": [0.6, 0.4, 1.2], "joints": {"rail": 0.5}},
            {"posture": "home", "joints": {"rail": 0.5}},
        ]
    )
    assert joint_targets(posed, alone) == dict(zip(posed.joint_names, posed.initial.tolist(), strict=True))
    right = [name for name in posed.joint_names if name.startswith("right")]
    assert set(joint_targets(posed, mixed)) == {"rail", *right}
    assert joint_targets(posed, both)["rail"] == 0.5


def test_combinations_are_all_of_them() -> None:
    (step,) = steps_of({"left": {"any_of": [[1, 0, 0], [2, 0, 0]]}, "right": {"any_of": [[3, 0, 0], [4, 0, 0]]}})
    found = [(one.get("left")[0], one.get("right")[0]) for one in step.combinations]
    assert found == [(1, 3), (1, 4), (2, 3), (2, 4)]


def pose(**more: Any) -> dict[str, Any]:
    return {"left": {"position": [0.6, 0.4, 1.2], **more}, "right": None}


MALFORMED = [
    ({"joints": {"rai": 1.0}}, "targets.joints.rai", "did you mean rail"),
    ({"joints": {"rail": 9.5}}, "targets.joints.rail", "beyond the upper limit, 9 m"),
    ({"joints": {"rail": -1.5}}, "targets.joints.rail", "beyond the lower limit, -1 m"),
    ({"joints": {"rail": 2000}}, "targets.joints.rail", "given in millimetres?"),
    ({"joints": {"waist_yaw": 90}}, "targets.joints.waist_yaw", "given in degrees?"),
    ({"joints": {"rail": "far"}}, "targets.joints.rail", "a number"),
    ({"joints": {"rail": None}}, "targets.joints.rail", "a number"),
    ({"joints": {"rail": float("nan")}}, "targets.joints.rail", "number"),
    ({"joints": [1.0]}, "targets.joints", "a mapping"),
    ({"joints": {}}, "targets.left", "a target"),
    ({"posture": "hom"}, "targets.posture", "did you mean home"),
    ({"posture": 3}, "targets.posture", "string"),
    ({"posture": "home", "left": [0, 0, 1], "right": [0, 1, 1], "middle": None}, "targets.middle", "left, right"),
    ({"joint": {"rail": 1.0}}, "targets.joint", "did you mean joints"),
    ({"left": [0, 0, 1]}, "targets.right", "null for a hand"),
    (pose(quaternion=[1, 0, 0]), "targets.left.quaternion", "[w, x, y, z]"),
    (pose(quaternion=[1, 0, 0, 0.5]), "targets.left.quaternion", "its length is 1.11803"),
    (pose(quaternion=[0, 0, 0, 0]), "targets.left.quaternion", "its length is 0"),
    (pose(quaternion=[1, 0, 0, 0], rpy=[0, 0, 0]), "targets.left", "not rpy and quaternion"),
    (pose(quaternion=[1, 0, 0, 0], approach=[1, 0, 0]), "targets.left", "not approach and quaternion"),
    (pose(frame="bx"), "targets.left.frame", "did you mean box"),
    (pose(frame="twin"), "targets.left.frame", "2 are called so"),
    (pose(frame="cart"), "targets.left.frame", "stands still"),
    (pose(frame="floor"), "targets.left.frame", "a half-space has none"),
    (pose(frame="shelf/bay 9"), "targets.left.frame", "shelf/board 1"),
    (pose(frame=7), "targets.left.frame", "string"),
    (pose(tolerance=-0.1), "targets.left.tolerance", ""),
    (pose(tolerance=[0.1, 0.1]), "targets.left.tolerance", ""),
    (pose(tolerance="0.1"), "targets.left.tolerance", ""),
    (pose(angle_tolerance=0.1), "targets.left", "approach, rpy or quaternion with angle_tolerance"),
    (pose(angle_tolerance=10, rpy=[0, 0, 0]), "targets.left.angle_tolerance", ""),
    ({"left": {"any_of": []}, "right": None}, "targets.left.any_of", "1 at least"),
    ({"left": {"any_of": 3}, "right": None}, "targets.left.any_of", ""),
    ({"left": {"any_of": [[0, 0, 1], [0, 0]]}, "right": None}, "targets.left.any_of[1]", "three numbers"),
    ({"left": {"any_of": [[0, 0, 1], None]}, "right": None}, "targets.left.any_of[1]", "three numbers"),
    ({hand: {"any_of": [[0, 0, 1]] * 9} for hand in ("left", "right")}, "targets", "at most 64 combinations"),
    ({"left": {"any_of": [pose(frame="bx")["left"]]}, "right": None}, "targets.left.any_of[0].frame", "box"),
]


@pytest.mark.parametrize(("targets", "field", "said"), MALFORMED)
def test_what_is_wrong_is_named_in_one_line(posed: Robot, targets: Any, field: str, said: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        check_scene(posed, make_scene({"targets": targets, "obstacles": OBSTACLES}))
    assert caught.value.field == field
    assert said in caught.value.valid
    assert "\n" not in str(caught.value)
