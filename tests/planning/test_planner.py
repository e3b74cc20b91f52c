"""Planning: samples, statuses, what is said beside them, and bad input."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import Plan

from humanoid_rail import Box, InvalidInput, Kinematics, Robot, Scene, Sphere, Status
from humanoid_rail.paper import dh_table as dh


def with_targets(scene: Scene, left: list[float], right: list[float]) -> Scene:
    return scene.model_copy(update={"targets": {"left": tuple(left), "right": tuple(right)}})


def near(robot: Robot, by: float, **extra: object) -> Scene:
    """Return a scene whose targets are a little above the start."""
    left, right = dh.hands(robot.initial) + np.array([0.0, 0.0, by])
    return Scene(name="near", targets={"left": left, "right": right}, **extra)


def test_samples_are_evenly_spaced_and_end_at_the_end(robot: Robot, scene: Scene, plan: Plan) -> None:
    trajectory = plan(robot, scene, dt=0.01)
    np.testing.assert_allclose(trajectory.t[:-1], 0.01 * np.arange(len(trajectory.t) - 1), atol=1e-12)
    assert 0 < trajectory.t[-1] - trajectory.t[-2] <= 0.01 + 1e-12
    n = len(trajectory.t)
    shapes = [
        array.shape for array in (trajectory.q, trajectory.hands, trajectory.clearance, trajectory.manipulability)
    ]
    assert shapes == [(n, 12), (n, 2, 3), (n, 2), (n,)]
    for array in (trajectory.t, trajectory.q, trajectory.hands, trajectory.clearance, trajectory.manipulability):
        assert not array.flags.writeable


def test_samples_say_what_is_true_of_them(robot: Robot, scene: Scene, plan: Plan) -> None:
    trajectory = plan(robot, scene, dt=0.2, far_clearances=True)
    for q, hands, clearance in zip(trajectory.q, trajectory.hands, trajectory.clearance, strict=True):
        np.testing.assert_allclose(hands, dh.hands(q), atol=1e-12)
        np.testing.assert_allclose(clearance, Kinematics(robot, scene.obstacles).measure(q).clearance.min(axis=0))


@pytest.mark.parametrize("tolerance", [0.1, 0.01, 1e-4])
@pytest.mark.parametrize("gain", [1.0, 4.0])
def test_it_stops_where_the_error_falls_to_the_tolerance(
    robot: Robot, scene: Scene, tolerance: float, gain: float, plan: Plan
) -> None:
    trajectory = plan(robot, scene, tolerance=tolerance, gain=gain, dt=0.05)
    targets = np.array([scene.targets["left"], scene.targets["right"]])
    errors = np.linalg.norm((trajectory.hands - targets).reshape(len(trajectory.t), -1), axis=1)
    assert trajectory.status is Status.REACHED
    assert errors[-1] <= tolerance + 1e-6
    assert (errors[:-1] > tolerance).all()
    assert trajectory.duration == pytest.approx(np.log(errors[0] / tolerance) / gain, abs=1e-3)


def test_a_diagonal_gain_moves_each_coordinate_at_its_own_rate(robot: Robot, plan: Plan) -> None:
    K = np.array([1.0, 2.0, 3.0, 1.5, 0.5, 2.5])
    trajectory = plan(robot, near(robot, 0.3), gain=tuple(K), dt=0.05)
    e = (trajectory.hands - dh.hands(robot.initial) - [0.0, 0.0, 0.3]).reshape(-1, 6)
    np.testing.assert_allclose(e, e[0] * np.exp(-np.outer(trajectory.t, K)), atol=1e-4)


def test_the_integrators_tolerance_is_kept(robot: Robot, scene: Scene, plan: Plan) -> None:
    loose, tight = plan(robot, scene), plan(robot, scene, rtol=1e-10, atol=1e-10)
    assert tight.evaluations > loose.evaluations
    np.testing.assert_allclose(loose.q[:600], tight.q[:600], atol=1e-3)


def test_start_and_end_are_always_sampled(robot: Robot, scene: Scene, plan: Plan) -> None:
    for settings in ({"dt": 1e10}, {"dt": 1.0, "max_time": 1e-10}):
        trajectory = plan(robot, scene, **settings)
        assert len(trajectory.t) == 2
        assert trajectory.t[0] == 0.0
        np.testing.assert_array_equal(trajectory.q[0], robot.initial)


def test_robot_and_scene_are_checked(robot: Robot, scene: Scene, plan: Plan) -> None:
    for arguments in ((scene, robot), (robot, "scenes/paper.yaml"), (None, scene)):
        with pytest.raises(InvalidInput, match=r"robot|scene"):
            plan(*arguments)  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match=r"targets\.left"):
        Scene(name="changed", targets={"left": (float("nan"), 0.0, 0.0), "right": (0, 1, 3)})
    with pytest.raises(TypeError):
        scene.targets["left"] = (0.0, 0.0, 0.0)  # type: ignore[index]


def test_targets_already_reached(robot: Robot, plan: Plan) -> None:
    trajectory = plan(robot, near(robot, 0.001))
    assert (trajectory.status, trajectory.duration, len(trajectory.t)) == (Status.REACHED, 0.0, 1)
    np.testing.assert_array_equal(trajectory.q, [robot.initial])
    assert trajectory.limits_ok


def test_time_limit_keeps_the_motion_so_far(robot: Robot, scene: Scene, plan: Plan) -> None:
    trajectory = plan(robot, scene, max_time=2.0)
    assert trajectory.status is Status.TIME_LIMIT
    assert trajectory.duration == 2.0
    assert "2 s" in trajectory.reason


def test_out_of_reach_is_singular(robot: Robot, scene: Scene, plan: Plan) -> None:
    trajectory = plan(robot, with_targets(scene, [-2.0, 2.0, 9.0], [-2.0, 4.0, 4.0]), dt=0.05)
    assert trajectory.status is Status.SINGULAR
    assert "out of reach" in trajectory.reason
    assert trajectory.duration > 0
    e = np.linalg.norm(trajectory.hands - [[-2.0, 2.0, 9.0], [-2.0, 4.0, 4.0]], axis=(1, 2))
    assert e[-1] < e[0]
    assert np.isfinite(trajectory.q).all()


def test_passing_close_to_a_singularity_is_not_being_stuck_there(robot: Robot, plan: Plan) -> None:
    """The left arm starts stretched out; the way back in is free."""
    q = robot.initial.copy()
    q[5:8] = [0.0, 0.0, 1e-3]
    q[4:8] = [0.0, -np.pi / 2, 0.0, 1e-3]
    left, right = dh.hands(q)
    shoulder = dh.bones(q)["left_upper_arm"][0]
    inward = left + 0.4 * (shoulder - left)
    trajectory = plan(robot, Scene(name="in", initial=q, targets={"left": inward, "right": right}), dt=0.05)
    assert trajectory.status is Status.REACHED


def test_stalled_when_velocity_jumps_back_and_forth(
    robot: Robot, scene: Scene, monkeypatch: pytest.MonkeyPatch, plan: Plan
) -> None:
    monkeypatch.setattr("humanoid_rail.resolution.integrate.MAX_EVALUATIONS", 50)
    trajectory = plan(robot, scene)
    assert trajectory.status is Status.STALLED
    assert 0 < trajectory.duration < 6


def test_no_obstacles(robot: Robot, plan: Plan) -> None:
    trajectory = plan(robot, near(robot, 0.2), dt=0.1)
    assert trajectory.clearance.shape == (len(trajectory.t), 0)
    assert trajectory.collision_free
    assert trajectory.min_clearance is None


def test_violations_name_joint_value_limit_and_time(robot: Robot, scene: Scene, plan: Plan) -> None:
    trajectory = plan(robot, scene)
    assert trajectory.status is Status.REACHED
    assert not trajectory.limits_ok
    rail = next(v for v in trajectory.violations if v.joint == "rail")
    assert (rail.quantity, rail.limit, rail.t) == ("velocity", 2.0, 0.0)
    speed = np.diff(trajectory.q[:2, 0])[0] / 0.01
    assert rail.value == pytest.approx(speed, rel=0.02)
    slow = plan(robot, scene, gain=0.25, c_mu=0.1, c_kappa=0.1, dt=0.1)
    assert slow.limits_ok


@pytest.mark.parametrize(("by", "position", "speed"), [(12.0, 9.0, 2.0), (-6.0, -1.0, -2.0)])
def test_limits_are_seen_on_both_sides(robot: Robot, by: float, position: float, speed: float, plan: Plan) -> None:
    left, right = dh.hands(robot.initial) + np.array([0.0, by, 0.0])
    trajectory = plan(robot, Scene(name="far", targets={"left": left, "right": right}), dt=0.1, c_mu=0.0)
    seen = {v.quantity: v for v in trajectory.violations if v.joint == "rail"}
    rail = trajectory.q[:, 0]
    farthest = rail.max() if by > 0 else rail.min()
    assert (seen["position"].limit, seen["velocity"].limit) == (position, speed)
    assert seen["position"].value == pytest.approx(farthest, abs=1e-3)
    assert seen["position"].t == pytest.approx(trajectory.t[abs(rail - farthest).argmin()], abs=0.5)
    assert abs(seen["velocity"].value) > 2
    assert seen["velocity"].value * speed > 0


@pytest.mark.parametrize("dt", [0.001, 0.5, 7.0])
def test_speeds_do_not_hide_between_samples(robot: Robot, scene: Scene, dt: float, plan: Plan) -> None:
    """The paper's cases start too fast, however coarsely they are sampled."""
    fine, coarse = plan(robot, scene), plan(robot, scene, dt=dt, max_time=7.0)
    assert {v.joint for v in coarse.violations} == {v.joint for v in fine.violations}
    for a, b in zip(fine.violations, coarse.violations, strict=True):
        assert (a.value, a.t) == pytest.approx((b.value, b.t))


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"method": "magic"}, "method"),
        ({"method": ["gradient-projection"]}, "method"),
        ({"dt": "0.01"}, "dt"),
        ({"tolerance": None}, "tolerance"),
        ({"max_time": True}, "max_time"),
        ({"c_mu": "1"}, "c_mu"),
        ({"c_kappa": 1e155}, "c_kappa"),
        ({"epsilon": 1e200}, "epsilon"),
        ({"gain": 1e300}, "gain"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"dt": -0.01}, "dt"),
        ({"dt": 1e-9}, "dt"),
        ({"dt": float("nan")}, "dt"),
        ({"max_time": float("inf")}, "max_time"),
        ({"rtol": 0.0}, "rtol"),
        ({"atol": -1.0}, "atol"),
        ({"gain": -1.0}, "gain"),
        ({"gain": (1.0, 1.0)}, "gain"),
        ({"c_mu": float("nan")}, "c_mu"),
        ({"epsilon": -1.0}, "epsilon"),
    ],
)
def test_bad_arguments_are_named(
    robot: Robot, scene: Scene, arguments: dict[str, object], field: str, plan: Plan
) -> None:
    with pytest.raises(InvalidInput) as caught:
        plan(robot, scene, **arguments)
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"targets": {"left": (0.0, 0.0, 3.0)}}, "targets.right"),
        ({"targets": {"left": (0, 0, 3), "right": (0, 1, 3), "third": (0, 0, 0)}}, "targets.third"),
        ({"initial": (0.0,) * 11}, "initial"),
        ({"initial": (20.0,) + (0.0,) * 11}, "initial[0] (rail)"),
        ({"initial": (0.0,) * 7 + (1.4,) + (0.0,) * 4}, "initial[7] (left_elbow_pitch)"),
        ({"obstacles": (Sphere(center=(0, 0, 1), radius=0.2),)}, "initial"),
        ({"obstacles": (Box(center=(0, 0, 0), size=(9, 9, 9)),)}, "initial"),
    ],
)
def test_scenes_that_are_not_for_this_robot(
    robot: Robot, scene: Scene, change: dict[str, object], field: str, plan: Plan
) -> None:
    with pytest.raises(InvalidInput) as caught:
        plan(robot, scene.model_copy(update=change))
    assert caught.value.field == field


def test_the_robots_own_start_has_to_be_within_the_limits_too(scene: Scene, plan: Plan) -> None:
    from humanoid_rail import load_robot

    with pytest.raises(InvalidInput, match=r"initial\[2\] \(waist_pitch\)"):
        plan(load_robot(waist_pitch_upper=0.5), scene.model_copy(update={"initial": None}))


def test_penetration_at_the_start_names_link_and_obstacle(robot: Robot, scene: Scene, plan: Plan) -> None:
    bad = scene.model_copy(update={"obstacles": (*scene.obstacles, Sphere(center=(0, 0, 1), radius=0.2))})
    with pytest.raises(InvalidInput, match=r"carriage is 0\.25 m inside obstacles\[2\]"):
        plan(robot, bad)
