"""Motions to targets as people state them: joints, postures, alternatives, tolerances, frames."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from humanoid_rail import AnyOf, Follower, Gains, InvalidInput, Robot, Status, Trajectory, make_scene, plan
from humanoid_rail.live.world import World
from humanoid_rail.viewer.camera import best_view
from humanoid_rail.viewer.motion_data import scene_data

LEFT = [0.6, 0.4, 1.2]
FAR = [30.0, 1.5, 1.2]


@pytest.fixture(scope="module")
def posed(robot: Robot) -> Robot:
    return replace(robot, postures={"home": tuple((robot.initial + 0.1).tolist())})


def planned(robot: Robot, targets: Any, method: str = "auto", **more: Any) -> Trajectory:
    found = plan(robot, make_scene({"targets": targets, **more}), method)
    assert found.status is Status.REACHED, found.reason
    return found


def hand(robot: Robot, q: np.ndarray, name: str) -> pin.SE3:
    """Return where a hand is, by Pinocchio."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.full_configuration(q))
    return data.oMf[robot.model.getFrameId(f"{name}_hand")]


@pytest.mark.parametrize("method", ["auto", "qp", "gradient-projection"])
def test_joints_get_where_they_have_to_be(robot: Robot, method: str) -> None:
    found = planned(robot, {"joints": {"rail": 0.5, "left_elbow_pitch": -0.4}}, method)
    there = dict(zip(robot.joint_names, found.q[-1], strict=True))
    assert there["rail"] == pytest.approx(0.5, abs=1e-7 if method == "auto" else 0.01)
    assert there["left_elbow_pitch"] == pytest.approx(-0.4, abs=1e-7 if method == "auto" else 0.01)


def test_a_posture_is_reached_exactly_after_targets_of_hands(posed: Robot) -> None:
    found = planned(posed, [{"left": LEFT, "right": None}, {"posture": "home"}])
    np.testing.assert_allclose(found.q[-1], posed.postures["home"], atol=1e-7)
    assert len(found.arrivals) == 2


def test_a_hand_and_joints_are_reached_together(posed: Robot) -> None:
    found = planned(posed, {"left": LEFT, "joints": {"rail": 0.3}, "posture": "home"})
    np.testing.assert_allclose(hand(posed, found.q[-1], "left").translation, LEFT, atol=1e-6)
    there = dict(zip(posed.joint_names, found.q[-1], strict=True))
    home = dict(zip(posed.joint_names, posed.postures["home"], strict=True))
    assert there["rail"] == pytest.approx(0.3, abs=1e-7)
    for name in posed.joint_names:
        if name.startswith("right"):
            assert there[name] == pytest.approx(home[name], abs=1e-7)


def test_a_posture_behind_an_obstacle_says_why(posed: Robot) -> None:
    there = hand(posed, np.array(posed.postures["home"]), "left").translation
    box = {"type": "sphere", "center": np.add(there, (0.0, 0.0, 0.3)).tolist(), "radius": 0.25}
    start = posed.initial.copy()
    start[0] = 3.0
    found = plan(posed, make_scene({"targets": {"posture": "home"}, "obstacles": [box], "initial": start.tolist()}))
    assert found.status is not Status.REACHED
    assert found.diagnosis is not None


def test_auto_takes_the_alternative_that_can_be_reached(robot: Robot) -> None:
    found = planned(robot, {"left": {"any_of": [FAR, LEFT]}, "right": None})
    np.testing.assert_allclose(hand(robot, found.q[-1], "left").translation, LEFT, atol=1e-6)
    assert "left takes alternative 2 of 2" in found.reason


def test_auto_takes_the_alternative_that_is_free(robot: Robot) -> None:
    ball = {"type": "sphere", "center": LEFT, "radius": 0.1}
    other = [0.6, 1.4, 1.2]
    found = planned(robot, {"left": {"any_of": [LEFT, other]}, "right": None}, obstacles=[ball])
    np.testing.assert_allclose(hand(robot, found.q[-1], "left").translation, other, atol=1e-6)


def test_qp_takes_the_alternative_that_is_nearest(robot: Robot) -> None:
    start = hand(robot, robot.initial, "left").translation
    near, far = np.add(start, (0.3, 0.0, -0.3)).tolist(), np.add(start, (2.0, 0.0, -1.0)).tolist()
    found = planned(robot, {"left": {"any_of": [far, near]}, "right": None}, "qp")
    np.testing.assert_allclose(hand(robot, found.q[-1], "left").translation, near, atol=0.011)
    assert "left takes alternative 2 of 2" in found.reason


def test_all_moves_of_a_step_go_to_the_same_alternative(robot: Robot) -> None:
    straight = {"approach": {"direction": [1, 0, 0], "distance": 0.1}}
    choices = [{"position": FAR, **straight}, {"position": LEFT, **straight}]
    found = planned(robot, {"left": {"any_of": choices}, "right": None})
    path = np.array([hand(robot, q, "left").translation for q in found.q])
    np.testing.assert_allclose(path[-1], LEFT, atol=1e-5)
    near = path[np.linalg.norm(path - LEFT, axis=1) < 0.05]
    assert abs(near[:, 1:] - LEFT[1:]).max() < 2e-3


def test_alternatives_of_which_none_is_in_reach_say_so(robot: Robot) -> None:
    found = plan(robot, make_scene({"targets": {"left": {"any_of": [FAR, [-30, 1, 1]]}, "right": None}}))
    assert found.status is Status.TARGET_OUT_OF_REACH


def test_straight_ways_are_those_of_all_alternatives(robot: Robot) -> None:
    one = {"position": LEFT, "approach": {"direction": [1, 0, 0], "distance": 0.1}}
    with pytest.raises(InvalidInput, match="all have a straight approach"):
        plan(robot, make_scene({"targets": {"left": {"any_of": [LEFT, one]}, "right": None}}))


def test_a_hand_ends_within_its_tolerance(robot: Robot) -> None:
    most = np.array([0.3, 0.05, 0.02])
    exact = planned(robot, {"left": LEFT, "right": None})
    found = planned(robot, {"left": {"position": LEFT, "tolerance": most.tolist()}, "right": None})
    off = abs(hand(robot, found.q[-1], "left").translation - LEFT)
    assert (off <= most).all()
    assert off.max() > 0.01
    assert found.duration < exact.duration
    assert f"left is {np.linalg.norm(off):.3g} m off the middle of its tolerance" in found.reason


@pytest.mark.parametrize("how", ["approach", "quaternion"])
def test_a_hand_is_turned_within_its_tolerance(robot: Robot, how: str) -> None:
    wanted = hand(robot, robot.initial + 0.4, "left")
    x, y, z, w = pin.Quaternion(wanted.rotation).coeffs().tolist()
    given = {"approach": wanted.rotation[:, 0].tolist(), "quaternion": [w, x, y, z]}[how]
    pose = {"position": wanted.translation.tolist(), how: given, "angle_tolerance": 0.2}
    found = planned(robot, {"left": pose, "right": None})
    there = hand(robot, found.q[-1], "left")
    np.testing.assert_allclose(there.translation, wanted.translation, atol=1e-6)
    left = wanted.rotation.T @ there.rotation
    angle = np.linalg.norm(pin.log3(left)) if how == "quaternion" else np.arccos(left[0, 0])
    assert 0.01 < angle <= 0.2


def test_a_target_just_out_of_reach_is_reached_within_its_tolerance(robot: Robot) -> None:
    high = [0.0, 0.5, 5.5]
    exact = plan(robot, make_scene({"targets": {"left": high, "right": None}}))
    assert exact.status is Status.TARGET_OUT_OF_REACH
    planned(robot, {"left": {"position": high, "tolerance": [0.0, 0.0, 1.5]}, "right": None})


def test_a_tolerance_in_a_frame_is_along_its_axes(robot: Robot) -> None:
    box = {"type": "box", "name": "box", "center": LEFT, "size": [0.01] * 3, "rpy": [0, 0, 0.7]}
    pose = {"position": [0.3, 0.0, 0.1], "frame": "box", "tolerance": [0.2, 0.0, 0.0]}
    found = planned(robot, {"left": pose, "right": None}, obstacles=[box])
    frame = pin.SE3(pin.rpy.rpyToMatrix(0, 0, 0.7), np.array(LEFT))
    off = frame.actInv(hand(robot, found.q[-1], "left").translation) - [0.3, 0.0, 0.1]
    assert abs(off[0]) <= 0.2
    assert abs(off[1:]).max() < 1e-6


def test_a_follower_goes_to_joints_and_has_no_alternatives(robot: Robot) -> None:
    follower = Follower(robot, make_scene({"targets": {"joints": {"rail": 0.2}}}), gains=Gains(5.0))
    for _ in range(3000):
        state = follower.step()
    assert state.q[0] == pytest.approx(0.2, abs=0.01)
    with pytest.raises(InvalidInput, match="are for plan"):
        follower.set_targets({"left": AnyOf(any_of=(tuple(LEFT),)), "right": None})


def test_pictures_have_all_alternatives(robot: Robot) -> None:
    second = [0.6, 1.4, 1.2]
    targets = [{"left": {"any_of": [LEFT, second]}, "right": None}, {"left": LEFT, "joints": {"rail": 0.5}}]
    scene = make_scene({"targets": targets})
    drawn = scene_data(robot, scene, best_view(robot, scene), 0.0)["targets"]
    assert [(one["steps"], one["position"]) for one in drawn] == [("1, 2", LEFT), ("1", second), ("1, 2", LEFT)]
    with pytest.raises(InvalidInput, match="live has no alternatives"):
        World.of(robot, scene)


def test_a_dragged_target_leaves_joints_where_they_have_to_be(robot: Robot) -> None:
    world = World.of(robot, make_scene({"targets": {"left": LEFT, "joints": {"rail": 0.2}}}))
    (step,) = world.with_target(0, "left", (0.5, 0.4, 1.2)).scene.steps
    assert step.joints == {"rail": 0.2}
    assert step.get("left") == (0.5, 0.4, 1.2)
