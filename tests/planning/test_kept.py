"""What is kept along motions: by every method, between samples, after retiming, and beside Pinocchio."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from humanoid_rail import (
    Auto,
    AxisTask,
    DistanceTask,
    GradientProjection,
    InvalidInput,
    PointTask,
    Problem,
    Robot,
    SafeVelocity,
    Scene,
    Status,
    Trajectory,
    make_scene,
    plan,
    read_trajectory,
    retime,
    solve,
    verify,
    write_trajectory,
)
from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.planning.keeping import line_to, orientation_kept
from humanoid_rail.resampling import evaluate

METHODS = (Auto(), Auto(optimise=False), SafeVelocity(), GradientProjection())
LEFT, RIGHT = (-1.0, -1.2, 3.2), (-0.5, 2.4, 3.0)


def hands_along(robot: Robot, trajectory: Trajectory) -> tuple[list[pin.SE3], list[pin.SE3]]:
    """Return where both hands are every millisecond, by Pinocchio."""
    t = np.arange(0.0, trajectory.duration, 1e-3)
    q, _, _ = evaluate(trajectory.motion, np.append(t, trajectory.duration))
    data, found = robot.model.createData(), ([], [])
    for row in q:
        pin.framesForwardKinematics(robot.model, data, robot.full_configuration(row))
        for hand, places in zip(("left", "right"), found, strict=True):
            places.append(data.oMf[robot.model.getFrameId(f"{hand}_hand")].copy())
    return found


def tilts(places: list[pin.SE3]) -> Array:
    """Return how far what points up at the beginning is from up, rad."""
    axis = places[0].rotation.T @ [0.0, 0.0, 1.0]
    return np.array(
        [np.arctan2(np.hypot(*(place.rotation @ axis)[:2]), (place.rotation @ axis)[2]) for place in places]
    )


def turned(places: list[pin.SE3]) -> Array:
    return np.array([np.linalg.norm(pin.log3(place.rotation @ places[0].rotation.T)) for place in places])


def scene(keep: Any, left: Any = LEFT, right: Any = None, **more: Any) -> Scene:
    return make_scene({"name": "kept", "targets": {"left": left, "right": right, "keep": keep}, **more})


def first_hands(robot: Robot) -> tuple[Array, Array]:
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.full_configuration(robot.initial))
    left, right = (data.oMf[robot.model.getFrameId(f"{hand}_hand")].translation.copy() for hand in ("left", "right"))
    return left, right


@pytest.mark.parametrize("method", METHODS, ids=["auto", "quick", "qp", "gradient projection"])
def test_a_tray_stays_level(robot: Robot, method: Any) -> None:
    trajectory = plan(robot, scene({"upright": "left"}), method)
    assert trajectory.status is Status.REACHED
    assert trajectory.certificate is not None
    (deviation,) = trajectory.certificate.deviations
    assert tilts(hands_along(robot, trajectory)[0]).max() <= deviation.bound + 1e-9 <= method.max_tilt


@pytest.mark.parametrize("method", METHODS, ids=["auto", "quick", "qp", "gradient projection"])
def test_a_hand_moves_straight_and_stays_as_it_is_turned(robot: Robot, method: Any) -> None:
    left, _ = first_hands(robot)
    along = np.array([-1.0, -0.2, 0.1])
    keep = [{"line": {"hand": "left", "direction": along.tolist()}}, {"orientation": "left"}]
    trajectory = plan(robot, scene(keep, (left + 0.4 * along).tolist()), method)
    assert trajectory.status is Status.REACHED
    assert trajectory.certificate is not None
    line, orientation = trajectory.certificate.deviations
    places, _ = hands_along(robot, trajectory)
    away = np.cross([place.translation - left for place in places], along / np.linalg.norm(along))
    assert np.linalg.norm(away, axis=1).max() <= line.bound + 1e-9 <= method.max_deviation
    assert turned(places).max() <= orientation.bound + 1e-9 <= method.max_tilt


@pytest.mark.parametrize("method", METHODS, ids=["auto", "quick", "qp", "gradient projection"])
def test_two_hands_keep_their_relative_pose_and_their_distance(robot: Robot, method: Any) -> None:
    left, _ = first_hands(robot)
    keep = [{"relative": ["left", "right"]}, {"distance": ["left", "right"]}]
    trajectory = plan(robot, scene(keep, (left + np.array([-0.3, 0.5, 0.0])).tolist()), method)
    assert trajectory.status is Status.REACHED
    places = hands_along(robot, trajectory)
    between = [one.actInv(other) for one, other in zip(*places, strict=True)]
    moved = [np.linalg.norm(one.translation - between[0].translation) for one in between]
    assert max(moved) <= method.max_deviation
    assert turned(between).max() <= method.max_tilt


def test_what_is_kept_is_kept_among_obstacles(robot: Robot) -> None:
    wall = {"type": "box", "center": [-0.35, -1.6, 3.1], "size": [0.1, 0.7, 0.7]}
    trajectory = plan(robot, scene({"upright": "left"}, (-0.9, -1.4, 3.1), obstacles=[wall]))
    assert trajectory.status is Status.REACHED
    assert trajectory.certified
    assert tilts(hands_along(robot, trajectory)[0]).max() <= Auto().max_tilt


STEPS = (
    {"left": LEFT, "right": None, "keep": [{"upright": "left"}]},
    {"left": (-1.2, -0.8, 3.0), "right": None},
    {"left": (-1.0, -1.0, 3.2), "right": None, "keep": [{"upright": "left"}, {"point": "right"}]},
)


def test_each_step_keeps_its_own_after_retiming_and_by_verification_too(robot: Robot, tmp_path: Path) -> None:
    steps = make_scene({"name": "steps", "targets": list(STEPS)})
    planned = plan(robot, steps)
    assert planned.status is Status.REACHED
    for trajectory in (planned, retime(planned, dwell=0.2, speed=0.5)):
        assert trajectory.status is Status.REACHED
        assert trajectory.certificate is not None
        found = trajectory.certificate.deviations
        assert [deviation.name for deviation in found] == [
            "the direction of the hand left",
            "the direction of the hand left",
            "the place of the hand right",
        ]
        assert found[0].end == pytest.approx(trajectory.arrivals[0])
        assert found[2].end == pytest.approx(trajectory.arrivals[2])
        by_verification = verify(robot, steps, trajectory).deviations
        assert [one.name for one in by_verification] == [one.name for one in found]
        np.testing.assert_allclose([one.bound for one in by_verification], [one.bound for one in found], atol=2e-5)
        write_trajectory(trajectory, tmp_path / "plan")
        back = read_trajectory(tmp_path / "plan").certificate
        assert back is not None
        assert back.deviations == found


def test_a_motion_that_does_not_keep_it_is_not_verified(robot: Robot) -> None:
    free = plan(robot, scene([]))
    (found,) = verify(robot, scene({"upright": "left"}), free).deviations
    assert found.bound == pytest.approx(tilts(hands_along(robot, free)[0]).max(), rel=0.05)
    assert found.bound > Auto().max_tilt


def test_a_motion_that_may_leave_a_constraint_too_far_is_not_reached(robot: Robot) -> None:
    trajectory = plan(robot, scene({"distance": ["left", "right"]}, (-0.8, -1.6, 3.2)), Auto(max_deviation=1e-9))
    assert trajectory.status is Status.UNCERTIFIED
    assert "the distance of the hands left and right is left by up to" in trajectory.reason
    assert "more than the 1e-06 mm that are allowed" in trajectory.reason


def test_targets_that_contradict_what_is_kept_are_said(robot: Robot) -> None:
    trajectory = plan(robot, scene({"distance": ["left", "right"]}, LEFT, RIGHT))
    assert trajectory.status is Status.TARGET_OUT_OF_REACH
    assert "no configuration there was found that keeps the distance of the hands left and right" in trajectory.reason


def test_constraints_of_a_problem_hold_at_its_start(robot: Robot) -> None:
    empty = Scene(targets={"left": LEFT, "right": None})
    with pytest.raises(InvalidInput, match=r"constraints\[0\].*the distance of the hands left and right is 2.46 m off"):
        Problem(robot, empty, (PointTask("left", LEFT),), robot.initial, (DistanceTask("left", "right", 2.0),))
    with pytest.raises(InvalidInput, match=r"constraints\[0\].hand"):
        Problem(robot, empty, (PointTask("left", LEFT),), robot.initial, (AxisTask("lfet", (0.0, 0.0, 1.0)),))


def test_a_problem_with_constraints_is_solved(robot: Robot) -> None:
    left, _ = first_hands(robot)
    there = left + np.array([-0.3, 0.1, 0.1])
    empty = Scene(targets={"left": LEFT, "right": None})
    state = Kinematics(robot).state(robot.initial)
    constraints = (line_to(state, "left", there), orientation_kept(state, "left"))
    trajectory = solve(Problem(robot, empty, (PointTask("left", tuple(there)),), robot.initial, constraints))
    assert trajectory.status is Status.REACHED
    along = (there - left) / np.linalg.norm(there - left)
    away = [np.linalg.norm(np.cross(place.translation - left, along)) for place in hands_along(robot, trajectory)[0]]
    assert max(away) <= 1e-3
    retimed = retime(trajectory, speed=0.3)
    assert retimed.certificate is not None
    assert len(retimed.certificate.deviations) == 2


def test_a_hand_that_is_where_a_line_ends_stays_there(robot: Robot) -> None:
    left, _ = first_hands(robot)
    assert line_to(Kinematics(robot).state(robot.initial), "left", left) == PointTask("left", tuple(left.tolist()))


def test_keeping_is_the_same_with_the_same_seed(robot: Robot) -> None:
    one, other = (plan(robot, scene({"upright": "left"}), Auto(seed=3)) for _ in range(2))
    np.testing.assert_array_equal(one.q, other.q)
