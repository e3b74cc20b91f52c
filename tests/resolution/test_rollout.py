"""The motion by the safe velocity: where it ends, and that it is safe on the way."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import ROOT, Plan
from conftest import plan as plan_natively

from humanoid_rail import (
    Box,
    GradientProjection,
    HalfSpace,
    InvalidInput,
    Kinematics,
    Robot,
    Scene,
    Sphere,
    Status,
    load_robot,
    load_scene,
    verify,
)

FREE = {"left": (-1.6, 0.6, 3.4), "right": (-1.6, 2.2, 3.4)}


@pytest.mark.parametrize("family", ["sparse", "dense", "shelf", "deep"])
def test_nothing_is_touched_and_no_limit_exceeded(robot: Robot, family: str) -> None:
    """On four scenes of each family; `scripts/evaluate.py` has them all."""
    for path in sorted((ROOT / "scenes" / "dev").glob(f"{family}-*.json"))[:4]:
        scene = load_scene(path)
        trajectory = plan_natively(robot, scene, "qp")
        assert trajectory.certified, path.name
        assert trajectory.limits_ok, trajectory.violations
        measured = [Kinematics(robot, scene.obstacles).measure(q) for q in trajectory.q[::40]]
        assert min(m.clearance.min() for m in measured) >= 0.01 - 1e-8
        assert min(m.self_clearance.min() for m in measured) >= 0.01 - 1e-8
        if family in ("sparse", "dense"):
            assert trajectory.status is Status.REACHED
            assert np.linalg.norm(trajectory.hands[-1] - [scene.targets[h] for h in robot.hand_names]) <= 0.01 + 1e-9
        if family == "deep":
            assert trajectory.status is Status.STALLED
            assert "keeps clear" in trajectory.reason


def test_without_obstacles_the_hands_go_straight_as_by_eq_4_9(robot: Robot, plan: Plan) -> None:
    """Speed limits slow it down as a whole: e keeps its direction."""
    scene = Scene(name="free", targets=FREE)
    safe, plain = plan(robot, scene, "qp", dt=0.02, c_mu=0.2), plan(robot, scene, dt=0.02, c_mu=0.2)
    assert (safe.status, plain.status) == (Status.REACHED, Status.REACHED)
    assert safe.limits_ok
    assert not plain.limits_ok
    targets = np.array([FREE[name] for name in robot.hand_names])
    for trajectory in (safe, plain):
        e = (trajectory.hands - targets).reshape(len(trajectory.t), -1)
        along = e @ e[0] / np.linalg.norm(e[0])
        assert np.linalg.norm(e - np.outer(along, e[0]) / np.linalg.norm(e[0]), axis=1).max() < 0.02


def test_arrival_is_where_the_error_falls_to_the_tolerance(robot: Robot, plan: Plan) -> None:
    trajectory = plan(robot, Scene(name="free", targets=FREE), "qp", dt=0.05, tolerance=0.03)
    e = trajectory.hands[-1] - [FREE[name] for name in robot.hand_names]
    assert np.linalg.norm(e) == pytest.approx(0.03, abs=1e-9)
    assert "0.03 m" in trajectory.reason


def test_already_there(robot: Robot, plan: Plan) -> None:
    hands = Kinematics(robot).hand_positions(robot.initial)
    scene = Scene(name="there", targets=dict(zip(robot.hand_names, map(tuple, hands), strict=True)))
    trajectory = plan(robot, scene, "qp")
    assert (trajectory.status, trajectory.duration, len(trajectory.t)) == (Status.REACHED, 0.0, 1)
    assert trajectory.certified


def test_out_of_reach_and_out_of_time(robot: Robot, plan: Plan) -> None:
    far = Scene(name="far", targets={"left": (-9.0, 0.6, 3.4), "right": (-1.6, 2.2, 3.4)})
    trajectory = plan(robot, far, "qp", dt=0.05)
    assert trajectory.status in (Status.SINGULAR, Status.STALLED)
    assert trajectory.certified
    trajectory = plan(robot, Scene(name="free", targets=FREE), "qp", dt=0.05, max_time=0.42)
    assert trajectory.status is Status.TIME_LIMIT
    assert trajectory.t[-1] == pytest.approx(0.42)
    assert len(trajectory.t) == 10


def test_a_wall_between_hand_and_target_is_not_crossed(robot: Robot, plan: Plan) -> None:
    wall = Box(center=(-1.2, 1.4, 3.4), size=(0.05, 8.0, 4.0))
    trajectory = plan(robot, Scene(name="wall", targets=FREE, obstacles=(wall,)), "qp", dt=0.05)
    assert trajectory.status is Status.STALLED
    assert trajectory.certified
    assert trajectory.min_clearance_obstacles >= 0.01 - 1e-8
    assert trajectory.min_clearance_obstacles < 0.05


def test_a_slow_obstacle_is_evaded(robot: Robot, plan: Plan) -> None:
    """A ball comes down on the hand that is at its target already: it gives way, where eq. 4.9 is hit."""
    hands = Kinematics(robot).hand_positions(robot.initial)
    targets = {"left": tuple(hands[0] + np.array([-0.3, 0.0, 0.0])), "right": tuple(hands[1])}
    ball = Sphere(center=tuple(hands[1] + np.array([0.0, 0.0, 1.0])), radius=0.2, velocity=(0.0, 0.0, -0.25))
    scene = Scene(name="slow", targets=targets, obstacles=(ball,))
    settings: dict[str, Any] = {"dt": 0.02, "max_time": 4.0, "tolerance": 1e-3, "c_kappa": 0.0}
    hit, safe = plan(robot, scene, **settings), plan(robot, scene, "qp", **settings)
    assert safe.certified
    assert safe.status in (Status.TIME_LIMIT, Status.REACHED)
    if hit.duration > 3.5:
        assert not hit.certified
    moved = np.linalg.norm(safe.hands[:, 1] - hands[1], axis=1).max()
    if safe.duration > 3.5:
        assert moved > 0.05
    measured = [Kinematics(robot, (ball,)).measure(q, t=t).clearance.min() for q, t in zip(safe.q, safe.t, strict=True)]
    np.testing.assert_allclose(safe.clearance.min(axis=1), measured, atol=1e-9)
    assert min(measured) >= 0.009


class Still:
    """A robot that stands still from some moment on."""

    def __init__(self, t: float, q: np.ndarray) -> None:
        self.t, self.q = np.array([t, t + 0.01]), np.array([q, q])


def test_what_cannot_be_evaded_is_an_overrun(robot: Robot, plan: Plan) -> None:
    """Far faster than any joint: not even standing still helps, and the message says what and when."""
    balls = (
        Sphere(center=(2.0, 8.0, 4.0), radius=0.1),
        Sphere(center=(0.0, 9.0, 1.0), radius=1.0, velocity=(0.0, -15.0, 0.0)),
    )
    scene = Scene(name="fast", targets=FREE, obstacles=balls)
    trajectory = plan(robot, scene, "qp", dt=0.01)
    assert trajectory.status is Status.OVERRUN
    assert "obstacles[1] (sphere)" in trajectory.reason
    contact = verify(robot, scene, Still(trajectory.t[-1], trajectory.q[-1])).contact
    assert contact is not None
    assert str(contact) in trajectory.reason
    # What there is of the motion is free.
    assert trajectory.certified
    assert trajectory.t[-1] < (9.0 - 1.05) / 15.0 + 0.1


def test_a_moving_obstacle_may_be_waited_for(robot: Robot) -> None:
    """A board closes the way for a while; then it is gone, and the motion goes on."""
    board = Box(center=(-1.3, 1.4, 3.4), size=(0.05, 6.0, 3.0), velocity=(0.0, 0.9, 0.0))
    scene = Scene(name="gate", targets=FREE, obstacles=(board,))
    still = plan_natively(
        robot, scene.model_copy(update={"obstacles": (board.model_copy(update={"velocity": (0, 0, 0)}),)}), "qp"
    )
    assert still.status is Status.STALLED
    waited = plan_natively(robot, scene, "qp")
    assert waited.status is Status.REACHED
    assert waited.certified


def test_a_floor_that_rises(robot: Robot, plan: Plan) -> None:
    """A half-space on the move: the column cannot get out of its way."""
    floor = HalfSpace(normal=(0.0, 0.0, 1.0), offset=-0.25, velocity=(0.0, 0.0, 0.1))
    trajectory = plan(robot, Scene(name="flood", targets=FREE, obstacles=(floor,)), "qp", dt=0.02)
    assert trajectory.status is Status.OVERRUN
    assert "carriage touches obstacles[0] (halfspace)" in trajectory.reason
    assert trajectory.t[-1] == pytest.approx((0.25 - 0.05) / 0.1, abs=0.05)


def test_links_that_touch_at_the_start_are_refused(robot: Robot, plan: Plan, folded_q: np.ndarray) -> None:
    scene = Scene(name="folded", initial=tuple(folded_q), targets=FREE)
    with pytest.raises(InvalidInput, match=r"initial.*no links touch.* inside"):
        plan(robot, scene, "qp")


def test_arms_do_not_cross(plan: Plan) -> None:
    """Targets that make the arms reach through each other: they stop, and never touch."""
    robot = load_robot(link_radius=0.1)
    crossed = {"left": (-1.5, 3.4, 3.2), "right": (-1.5, -0.6, 3.2)}
    safe = plan(robot, Scene(name="crossed", targets=crossed), "qp", dt=0.05, max_time=8.0)
    assert safe.certified
    assert safe.min_clearance_self is not None
    assert safe.min_clearance_self >= 0.01 - 1e-8


def test_position_limits_hold_where_eq_4_9_exceeds_them(plan: Plan) -> None:
    robot = load_robot(rail_upper=1.0, elbow_upper=0.4)
    scene = Scene(name="limits", targets={"left": (-1.6, 1.6, 3.4), "right": (-1.6, 4.2, 3.4)})
    safe, plain = plan(robot, scene, "qp", dt=0.05, max_time=10.0), plan(robot, scene, dt=0.05)
    assert any(v.quantity == "position" for v in plain.violations)
    assert safe.limits_ok
    assert (safe.q <= robot.upper).all()
    assert (safe.q >= robot.lower).all()


def test_a_start_that_cannot_be_told_from_touching_is_refused(robot: Robot, plan: Plan) -> None:
    hand = Kinematics(robot).hand_positions(robot.initial)[1]
    for gap, works in ((1e-9, False), (1e-5, True)):
        ball = Sphere(center=tuple(hand + np.array([0.0, 0.05 + 0.1 + gap, 0.0])), radius=0.1)
        scene = Scene(name="touching", targets=FREE, obstacles=(ball,))
        if works:
            trajectory = plan(robot, scene, "qp", dt=0.05, max_time=0.2)
            assert trajectory.certified
            assert "safety distance of 0.01 m could not be kept" in trajectory.reason
        else:
            with pytest.raises(InvalidInput, match=r"too near to tell from touching, from obstacles\[0\] \(sphere\)"):
                plan(robot, scene, "qp")
            assert plan(robot, scene, dt=0.5).t[-1] > 0


@pytest.mark.parametrize("option", ["safety_distance", "damper_gain", "seed", "max_planning_time", "equalities"])
def test_an_option_that_a_method_has_not_is_bad_input(option: str) -> None:
    with pytest.raises(InvalidInput, match=f"{option} is 0.5"):
        GradientProjection(**{option: 0.5})
