"""What a hand is made of: grippers of the paper's robot, bodies that robot files give, links that are found."""

from __future__ import annotations

import shutil
import subprocess
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import pytest
from conftest import ROOT, random_q

from humanoid_rail import InvalidInput, Kinematics, Robot, Scene, build_urdf, hand_bodies, load_robot, plan
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.paper import dh_table as dh

ROBOTS = {"paper": ("humanoid-rail-with-grippers", 1.0), "human": ("human-sized", 0.45)}
"""Robots with grippers, and the lengths of their forearms, m."""
BODIES: list[dict[str, Any]] = [
    {"type": "box", "center": [0.0, 0.0, -0.2], "size": [0.2, 0.1, 0.04], "rpy": [0.0, 0.0, 0.5]},
    {"type": "capsule", "center": [0.1, 0.0, 0.0], "radius": 0.02, "length": 0.2},
    {"type": "sphere", "center": [-0.1, 0.0, 0.0], "radius": 0.03},
]


@pytest.fixture(scope="module", params=ROBOTS)
def gripping(request: pytest.FixtureRequest) -> tuple[Robot, float]:
    name, forearm = ROBOTS[request.param]
    return quiet(name), forearm


def quiet(*source: str, **arguments: Any) -> Robot:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return load_robot(*source, **arguments)


def links_of(robot: Robot, hand: str) -> list[str]:
    bodies = hand_bodies(robot, hand)
    return list(dict.fromkeys(robot.link_names[i] for i in bodies))


def distance_from_hand(robot: Robot, hand: str, body: int, shape: coal.ShapeBase, at: pin.SE3) -> float:
    """Return how far a body is from a shape that is placed in a hand's frame and moves with it, m."""
    model, geometry = robot.model, robot.collision_model.geometryObjects[body]
    frame = model.frames[model.getFrameId(robot.hands[robot.hand(hand)].frame)]
    assert geometry.parentJoint == frame.parentJoint
    result = coal.DistanceResult()
    placed = coal_placement(frame.placement * at)
    coal.distance(geometry.geometry, coal_placement(geometry.placement), shape, placed, coal.DistanceRequest(), result)
    return float(result.min_distance)


@pytest.mark.parametrize("hand", ["left", "right"])
def test_a_part_fits_between_the_fingers(gripping: tuple[Robot, float], hand: str) -> None:
    """A cube of a fifth of the forearm around the hand point touches nothing; one of a quarter touches both fingers."""
    robot, forearm = gripping
    joint = robot.model.frames[robot.model.getFrameId(f"{hand}_hand")].parentJoint
    bodies = [i for i, body in enumerate(robot.collision_model.geometryObjects) if body.parentJoint == joint]
    middle = pin.SE3.Identity()
    for side, touching in ((0.2, set()), (0.25, {f"{hand}_hand", f"{hand}_finger_1", f"{hand}_finger_2"})):
        cube = coal.Box(*3 * [side * forearm])
        near = {robot.link_names[i] for i in bodies if distance_from_hand(robot, hand, i, cube, middle) <= 0.0}
        assert near - {f"{hand}_forearm"} == touching if touching else not near


@pytest.mark.parametrize("hand", ["left", "right"])
def test_a_hand_is_its_palm_and_its_fingers(gripping: tuple[Robot, float], hand: str) -> None:
    robot, _ = gripping
    assert links_of(robot, hand) == [f"{hand}_hand", f"{hand}_finger_1", f"{hand}_finger_2"]


def test_kinematics_with_grippers_are_those_of_the_table(rng: np.random.Generator) -> None:
    robot = quiet("humanoid-rail-with-grippers")
    for _ in range(10):
        q = random_q(robot, rng)
        np.testing.assert_allclose(Kinematics(robot).measure(q).hands, dh.hands(q), atol=1e-9)


def test_parts_of_one_gripper_are_left_out_and_those_of_two_are_checked(gripping: tuple[Robot, float]) -> None:
    robot, _ = gripping
    links = robot.link_names
    checked = {frozenset((links[i], links[j])) for i, j in robot.self_collision_pairs}
    parts = {hand: [f"{hand}_{part}" for part in ("hand", "finger_1", "finger_2")] for hand in ("left", "right")}
    for hand, own in parts.items():
        for part in own:
            assert not [other for other in (*own, f"{hand}_forearm") if frozenset((part, other)) in checked]
            assert frozenset((part, f"{hand}_upper_arm")) in checked
    assert all(frozenset((one, other)) in checked for one in parts["left"] for other in parts["right"])


def test_the_argument_and_the_robot_file_make_the_same_robot() -> None:
    by_argument, by_file = quiet(grippers=1), quiet("humanoid-rail-with-grippers")
    assert by_argument.link_names == by_file.link_names
    assert by_argument.self_collision_pairs == by_file.self_collision_pairs
    np.testing.assert_array_equal(by_argument.initial, by_file.initial)


def test_bodies_of_the_papers_robot_that_are_rigid_to_each_other_are_not_checked() -> None:
    """A hand that is inside of its forearm would make every motion one in contact."""
    robot = quiet(trunk_bodies=1, grippers=1)
    bodies = robot.collision_model.geometryObjects
    assert not [pair for pair in robot.self_collision_pairs if len({bodies[i].parentJoint for i in pair}) == 1]


def test_the_robot_has_no_grippers_unless_they_are_asked_for(robot: Robot) -> None:
    assert build_urdf() == build_urdf(grippers=0)
    assert not [name for name in robot.link_names if "finger" in name or "hand" in name]
    with pytest.raises(InvalidInput, match=r"grippers.*1 or 0"):
        build_urdf(grippers=0.5)


def test_motions_with_grippers_are_certified() -> None:
    robot = quiet(grippers=1)
    trajectory = plan(robot, Scene(name="x", targets={"left": (-1.6, 0.6, 3.4), "right": (-1.6, 2.2, 3.4)}))
    assert trajectory.certified
    assert trajectory.status == "reached"


def test_other_tools_read_the_urdf_with_grippers(tmp_path: Path, rng: np.random.Generator) -> None:
    yourdfpy, mujoco = pytest.importorskip("yourdfpy"), pytest.importorskip("mujoco")
    robot, file = quiet(grippers=1), tmp_path / "robot.urdf"
    file.write_text(robot.urdf)
    q = random_q(robot, rng)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.full_configuration(q))
    urdf, model = yourdfpy.URDF.load(str(file)), mujoco.MjModel.from_xml_path(str(file))
    urdf.update_cfg(q)
    state = mujoco.MjData(model)
    for joint, value in zip(list(robot.model.names)[1:], robot.full_configuration(q), strict=True):
        state.qpos[model.joint(joint).qposadr[0]] = value
    mujoco.mj_forward(model, state)
    for link in ("left_hand", "left_finger_1", "left_finger_2", "right_hand", "right_finger_1", "right_finger_2"):
        expected = data.oMf[robot.model.getFrameId(link)]
        np.testing.assert_allclose(urdf.get_transform(link), expected.homogeneous, atol=1e-9)
        np.testing.assert_allclose(state.body(link).xpos, expected.translation, atol=1e-9)
        assert robot.model.inertias[robot.model.frames[robot.model.getFrameId(link)].parentJoint].mass > 0
        assert model.body(link).mass > 0


def test_check_urdf_takes_the_urdf_with_grippers(tmp_path: Path) -> None:
    if shutil.which("check_urdf") is None:
        pytest.skip("no check_urdf")
    (tmp_path / "robot.urdf").write_text(build_urdf(grippers=1))
    done = subprocess.run(["check_urdf", tmp_path / "robot.urdf"], capture_output=True, text=True, check=True)
    assert "left_finger_1" in done.stdout
    assert not done.stderr


def test_without_grippers_the_forearm_is_the_hand(robot: Robot) -> None:
    """Nothing else is there that could touch an object."""
    assert links_of(robot, "left") == ["left_forearm"]


def test_links_of_a_hand_can_be_named() -> None:
    robot = quiet(grippers=1)
    for links in (("left_finger_1",), ()):
        hands = (replace(robot.hands[0], links=links), robot.hands[1])
        assert links_of(replace(robot, hands=hands), "left") == list(links)


def bodied(hands: dict[str, Any] | None = None) -> Robot:
    """Return the paper's robot with bodies that its hands are given as in a robot file."""
    hands = {
        "left": {"frame": "left_hand", "bodies": BODIES, "pointing": [1, 0, 0]},
        "right": "right_hand",
        **(hands or {}),
    }
    return quiet(str(ROOT / "robots" / "humanoid_rail.yaml"), hands=hands, pairs={})


def test_bodies_of_a_robot_file_are_fixed_to_the_frame_of_the_hand() -> None:
    robot = bodied()
    assert links_of(robot, "left") == ["left_hand_bodies"]
    own = hand_bodies(robot, "left")
    box, capsule, ball = (robot.collision_model.geometryObjects[i].geometry for i in own)
    assert (box.halfSide.tolist(), capsule.radius, 2 * capsule.halfLength) == ([0.1, 0.05, 0.02], 0.02, 0.2)
    assert isinstance(capsule, coal.Capsule)
    assert ball.radius == 0.03
    for body, given in zip(own, BODIES, strict=True):
        turn = pin.rpy.rpyToMatrix(*given.get("rpy", (0.0, 0.0, 0.0)))
        at = robot.collision_model.geometryObjects[body].placement
        frame = robot.model.frames[robot.model.getFrameId("left_hand")].placement
        np.testing.assert_allclose(at.homogeneous, (frame * pin.SE3(turn, np.array(given["center"]))).homogeneous)


def test_bodies_of_a_robot_file_are_in_reports_and_saved(tmp_path: Path) -> None:
    robot = bodied()
    assert "left_hand_bodies: box of 0.2 x 0.1 x 0.04 m, capsule of radius 0.02 m" in robot.report()
    assert "may touch what it grasps: left_hand_bodies" in robot.report()
    robot.save(tmp_path)
    again = quiet(str(tmp_path))
    assert again.hands == robot.hands
    assert again.link_names == robot.link_names
    assert again.self_collision_pairs == robot.self_collision_pairs
    assert [hand_bodies(again, name) for name in again.hand_names] == [
        hand_bodies(robot, name) for name in robot.hand_names
    ]
    again.save(tmp_path / "twice")
    assert (tmp_path / "twice" / "robot.yaml").read_text() == (tmp_path / "robot.yaml").read_text()


def test_links_and_bodies_of_a_robot_file_go_together() -> None:
    robot = bodied({"left": {"frame": "left_hand", "bodies": BODIES[:1], "links": ["left_forearm"]}})
    assert links_of(robot, "left") == ["left_forearm", "left_hand_bodies"]


@pytest.mark.parametrize(
    ("hand", "field"),
    [
        ({"links": ["left_forarm"]}, "hands.left.links[0]"),
        ({"bodies": [{"type": "box", "center": [0, 0, 0], "size": [0.1, 0, 0.1]}]}, "hands.left.bodies[0].size[1]"),
        ({"bodies": [{"type": "sphere", "radius": 0.1}]}, "hands.left.bodies[0].center"),
        ({"bodies": [{"type": "cone", "center": [0, 0, 0]}]}, "hands.left.bodies[0].type"),
        ({"bodies": [{"center": [0, 0, 0], "radius": 0.1}]}, "hands.left.bodies[0].type"),
        ({"bodies": [*BODIES, {"type": "sphere", "center": [0, 0, 0], "radius": -1}]}, "hands.left.bodies[3].radius"),
        ({"bodies": [BODIES[0], BODIES[0]]}, "hands.left.bodies[1]"),
        ({"bodies": [{**BODIES[2], "rpy": [0, 0, 0]}]}, "hands.left.bodies[0].rpy"),
    ],
)
def test_what_is_wrong_with_the_bodies_of_a_hand_is_said(hand: dict[str, Any], field: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        bodied({"left": {"frame": "left_hand", **hand}})
    assert caught.value.field == field


def test_bodies_and_links_of_arguments_are_those_of_hands() -> None:
    """Hands that are given as objects keep their links."""
    robot = quiet("human-sized")
    named = [replace(hand, links=(f"{hand.name}_finger_1",)) for hand in robot.hands]
    assert links_of(quiet("human-sized", hands=named), "right") == ["right_finger_1"]
