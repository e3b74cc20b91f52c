"""Limits of `<mimic>` joints."""

from __future__ import annotations

import numpy as np
import pytest
from arms import arm, joint

from humanoid_rail import InvalidInput, Kinematics, Robot, Scene, load_robot, plan, retime
from humanoid_rail.kinematics.joint_limits import limit_violations, sampled


def with_follower(limit: str, leader: str = "j1", multiplier: float = 3.0, offset: float = 0.0) -> Robot:
    """Return an arm with a joint that follows one of the others, and one that follows the follower."""
    fast = 'lower="-2" upper="2" velocity="2" drake:acceleration="10"'
    mimic = f'<mimic joint="{leader}" multiplier="{multiplier}" offset="{offset}"/>'
    more = '<link name="finger"/>' + joint("follower", "b2", "finger", 0.5, limit, more=mimic)
    return arm(limits={f"j{i}": fast for i in range(3)}, more=more)


def full_motion(robot: Robot, q: np.ndarray) -> np.ndarray:
    return q @ robot.coupling.T + robot.offset


def test_limits_of_a_follower_are_folded_into_its_leaders() -> None:
    robot = with_follower('lower="-0.5" upper="0.4" velocity="0.5" drake:acceleration="1.5"', offset=0.1)
    np.testing.assert_allclose([robot.lower[1], robot.upper[1]], [-0.2, 0.1])
    np.testing.assert_allclose([robot.velocity_limit[1], robot.acceleration_limit[1]], [0.5 / 3, 0.5])
    np.testing.assert_array_equal(robot.lower[[0, 2]], -2.0)
    backwards = with_follower('lower="-0.5" upper="0.4" velocity="9"', multiplier=-2.0)
    np.testing.assert_allclose([backwards.lower[1], backwards.upper[1]], [-0.2, 0.25])
    assert (backwards.velocity_limit[1], backwards.acceleration_limit[1]) == (2.0, 10.0)


def test_limits_that_just_cover_what_the_leaders_do_change_nothing() -> None:
    for arguments in ({}, {"spine_pitch_upper": 1.1, "waist_pitch_lower": -0.123456}, {"revolute_velocity": 0.3}):
        robot = load_robot(**arguments)
        own = [robot.model.joints[robot.model.getJointId(name)].idx_q for name in robot.joint_names]
        np.testing.assert_array_equal(robot.lower, robot.model.lowerPositionLimit[own])
        np.testing.assert_array_equal(robot.upper, robot.model.upperPositionLimit[own])
        np.testing.assert_array_equal(robot.velocity_limit, robot.model.velocityLimit[own])


@pytest.mark.parametrize("method", ["auto", "qp"])
def test_planned_and_retimed_motions_keep_the_limits_of_followers(method: str) -> None:
    robot = with_follower('lower="-0.5" upper="0.5" velocity="0.5" drake:acceleration="2"')
    model, there = robot.model, Kinematics(robot).hand_positions(np.array([0.5, 0.16, 0.6]))[0]
    scene = Scene(name="bend", targets={"tool": tuple(there)}, initial=(0.0, -0.16, -0.3))
    trajectory = plan(robot, scene, method)
    assert trajectory.status == "reached", trajectory.reason
    retimed = retime(trajectory, robot, scene)
    for motion in (trajectory, retimed):
        full = full_motion(robot, motion.q)
        assert (full >= model.lowerPositionLimit - 1e-9).all()
        assert (full <= model.upperPositionLimit + 1e-9).all()
        speed = abs(np.diff(full, axis=0)) / np.diff(motion.t)[:, None]
        assert (speed <= model.velocityLimit + 1e-6).all()
        assert motion.limits_ok
    assert abs(retimed.timing.acceleration @ robot.coupling.T)[:, 3].max() <= 2.0 + 1e-9


def test_a_verdict_names_what_a_follower_would_exceed() -> None:
    robot = with_follower('lower="-0.5" upper="0.5" velocity="0.5"')
    q = np.array([[0.0, 0.0, 0.0], [0.0, 0.8, 0.0]])
    found = limit_violations(robot, sampled(np.array([0.0, 0.4]), q))
    assert {(violation.joint, violation.quantity) for violation in found} == {("j1", "position"), ("j1", "velocity")}


def test_a_follower_that_cannot_keep_its_limits_is_refused_by_name() -> None:
    with pytest.raises(InvalidInput, match=r"limits of joint follower is \(7.0, 8.0\).*j1"):
        with_follower('lower="7" upper="8" velocity="1"')
    with pytest.raises(InvalidInput, match=r"limits of joint follower.*always stands at 3"):
        with_follower('lower="-1" upper="1" velocity="1"', multiplier=0.0, offset=3.0)
