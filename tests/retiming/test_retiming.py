"""Retimed motions: within limits at all times, at rest at both ends, on the path, certified."""

from __future__ import annotations

from pathlib import Path

import conftest
import numpy as np
import pytest
from conftest import ROOT, changed
from motions import EXCESS, distance_from, rates, sampled, straight

from humanoid_rail import (
    HalfSpace,
    Robot,
    Scene,
    Sphere,
    Status,
    Trajectory,
    load_scene,
    make_scene,
    plan_case,
    retime,
    verify,
)
from humanoid_rail.io.plan_folder import read_plan, write_plan
from humanoid_rail.paper import dh_table as dh
from humanoid_rail.search.smoothing import speed_units
from humanoid_rail.viewer.playback import playback_html

SCENES = sorted((ROOT / "scenes" / "dev").glob("*.json"))


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_every_planning_scene_is_retimed(robot: Robot, path: Path) -> None:
    scene = load_scene(path)
    plan = conftest.plan(robot, scene, optimise=False)
    motion = retime(plan, robot, scene)
    assert motion.status is Status.REACHED
    assert (rates(motion, 1) <= robot.velocity_limit * EXCESS).all()
    assert (rates(motion, 2) <= robot.acceleration_limit * EXCESS).all()
    assert motion.limits_ok
    assert motion.timing is not None
    assert not motion.timing.velocity[[0, -1]].any()
    assert not motion.timing.acceleration[[0, -1]].any()
    np.testing.assert_array_equal(motion.q[[0, -1]], plan.q[[0, -1]])
    assert motion.certified
    assert motion.certificate == verify(robot, scene, motion)
    assert motion.clearance_bound is not None
    assert plan.clearance_bound is not None
    assert motion.clearance_bound >= min(plan.clearance_bound, 0.01) - 1e-3
    units = speed_units(robot)
    assert distance_from(plan.q / units, motion.q / units).max() < 0.01


@pytest.mark.parametrize("path", SCENES[::6], ids=lambda path: path.stem)
@pytest.mark.parametrize("limit", [50.0, 300.0])
def test_jerk_is_limited_where_that_is_asked_for(robot: Robot, path: Path, limit: float) -> None:
    scene = load_scene(path)
    plan = conftest.plan(robot, scene, optimise=False)
    motion = retime(plan, robot, scene, jerk_limit=limit)
    assert motion.certified
    assert (rates(motion, 3) <= limit * EXCESS).all()
    assert (rates(motion, 2) <= robot.acceleration_limit * EXCESS).all()
    assert (rates(motion, 1) <= robot.velocity_limit * EXCESS).all()
    assert retime(plan, robot, scene).duration <= motion.duration < 6.0


@pytest.mark.parametrize("path", SCENES[::15], ids=lambda path: path.stem)
def test_a_limit_of_jerk_that_does_not_bind_costs_nothing(robot: Robot, path: Path) -> None:
    scene = load_scene(path)
    plan = conftest.plan(robot, scene, optimise=False)
    free = retime(plan, robot, scene)
    assert free.timing is not None
    limit = 1.01 * max(peak.jerk for peak in free.timing.peaks)
    assert retime(plan, robot, scene, jerk_limit=limit).duration == free.duration


@pytest.mark.parametrize("dt", [0.002, 0.05, 0.2])
def test_coarse_samples_do_not_leave_the_path(robot: Robot, dt: float) -> None:
    """What they cannot follow is slowed down; between the samples it is near the path too."""
    scene = load_scene(ROOT / "scenes" / "dev" / "deep-500004.json")
    plan = conftest.plan(robot, scene, optimise=False)
    motion = retime(plan, robot, scene, dt=dt)
    assert motion.certified
    units = speed_units(robot)
    assert distance_from(plan.q / units, sampled(motion, 0.01) / units).max() < 0.015
    assert ("could not be kept" in motion.reason) == (motion.clearance_bound < 0.01 - 1e-3 - 2e-6)  # type: ignore[operator]


@pytest.mark.parametrize(
    ("way", "seconds"), [(0.25, 2 * (0.25 / 4.0) ** 0.5), (1.0, 1.0 / 2.0 + 2.0 / 4.0), (3.0, 3.0 / 2.0 + 2.0 / 4.0)]
)
def test_one_joint_is_as_fast_as_can_be(
    robot: Robot, planned: Trajectory, free: Scene, way: float, seconds: float
) -> None:
    """The rail with its limits of 2 m/s and 4 m/s^2, in closed form; accelerations set in over a sample."""
    motion = retime(straight(planned, robot, "rail", way), robot, free, dt=1e-3)
    assert seconds <= motion.duration <= seconds * 1.002 + 3e-3


def test_one_joint_with_limited_jerk_is_as_fast_as_can_be(robot: Robot, planned: Trajectory, free: Scene) -> None:
    motion = retime(straight(planned, robot, "rail", 3.0), robot, free, dt=1e-3, jerk_limit=20.0)
    seconds = 3.0 / 2.0 + 2.0 / 4.0 + 4.0 / 20.0
    assert seconds <= motion.duration <= seconds * 1.002 + 3e-3


def test_the_creep_of_the_exponential_is_gone(robot: Robot, scene: Scene) -> None:
    plan = plan_case(robot, 3)
    motion = retime(plan, robot, scene)
    assert motion.certified
    assert motion.duration < 0.4 * plan.duration
    assert (rates(motion, 1) <= robot.velocity_limit * EXCESS).all()
    assert (rates(motion, 2) <= robot.acceleration_limit * EXCESS).all()
    np.testing.assert_array_equal(motion.hands[-1], plan.hands[-1])
    np.testing.assert_array_equal(motion.q[-1], plan.q[-1])


def test_peaks_are_those_of_the_motion(robot: Robot, scene: Scene) -> None:
    motion = retime(plan_case(robot, 2), robot, scene, jerk_limit=100.0)
    assert motion.timing is not None
    fine = 1e-4
    for order, quantity in enumerate(("velocity", "acceleration", "jerk"), start=1):
        peaks = np.array([getattr(peak, quantity) for peak in motion.timing.peaks])
        found = rates(motion, order, fine)
        rounding = 1e-14 / fine**order
        assert (peaks >= found * (1.0 - 1e-9) - rounding).all()
        np.testing.assert_allclose(peaks, found, rtol=0.02, atol=rounding)
    assert [peak.jerk_limit for peak in motion.timing.peaks] == [100.0] * robot.n
    assert [peak.joint for peak in motion.timing.peaks] == list(robot.joint_names)


def test_samples_are_equally_far_apart(robot: Robot, scene: Scene) -> None:
    plan = plan_case(robot, 3)
    for dt in (0.004, 0.02):
        motion = retime(plan, robot, scene, dt=dt)
        np.testing.assert_allclose(np.diff(motion.t), dt, rtol=1e-9)
        assert motion.provenance.retiming is not None
        assert motion.provenance.retiming.dt == dt


def test_limits_can_be_given(robot: Robot, planned: Trajectory, free: Scene) -> None:
    slow = retime(planned, robot, free, velocity_limit=0.4, acceleration_limit=robot.acceleration_limit / 4)
    assert (rates(slow, 1) <= 0.4 * EXCESS).all()
    assert (rates(slow, 2) <= robot.acceleration_limit / 4 * EXCESS).all()
    fast = retime(planned, robot, free, velocity_limit=10.0, acceleration_limit=100.0)
    assert fast.duration < retime(planned, robot, free).duration < slow.duration
    assert {violation.quantity for violation in fast.violations} == {"velocity", "acceleration"}
    assert not fast.limits_ok


def test_it_rests_at_every_target(robot: Robot) -> None:
    steps = [{"left": [0.6, -1.8, 2.6], "right": [0.6, 1.8, 2.6]}, {"left": None, "right": [-0.6, 1.8, 2.9]}]
    scene = make_scene({"name": "two", "targets": steps})
    plan = conftest.plan(robot, scene, optimise=False)
    motion = retime(plan, robot, scene, dwell=0.25)
    assert motion.certified
    assert motion.timing is not None
    assert len(motion.arrivals) == 2
    first, last = (int(np.argmin(abs(motion.t - arrival))) for arrival in motion.arrivals)
    assert last == len(motion.t) - 1
    rests = slice(first, first + 26)
    np.testing.assert_array_equal(motion.q[rests], np.tile(motion.q[first], (26, 1)))
    assert not motion.timing.velocity[rests].any()
    assert motion.timing.velocity[first + 27].any()
    np.testing.assert_allclose(motion.hands[first], [steps[0]["left"], steps[0]["right"]], atol=1e-6)
    np.testing.assert_allclose(motion.hands[last][1], steps[1]["right"], atol=1e-6)
    assert motion.duration - retime(plan, robot, scene).duration == pytest.approx(0.25, abs=1e-9)


def test_a_motion_that_got_stuck_is_retimed_as_far_as_it_got(robot: Robot) -> None:
    scene = load_scene(next((ROOT / "scenes" / "unsolvable").glob("target_out_of_reach*")))
    plan = conftest.plan(robot, scene, max_edge_checks=500)
    motion = retime(plan, robot, scene)
    assert motion.status is Status.TARGET_OUT_OF_REACH
    assert motion.arrivals == ()
    np.testing.assert_array_equal(motion.q[-1], plan.q[-1])


def test_without_a_way_there_is_nothing_to_time(robot: Robot, planned: Trajectory, free: Scene) -> None:
    still = retime(changed(planned, t=np.zeros(1), q=robot.initial[None, :], arrivals=(0.0,)), robot, free)
    assert still.certified
    assert (still.q == robot.initial).all()
    assert still.arrivals == (0.0,)


def test_hands_that_are_there_already_can_be_shown_and_kept(robot: Robot, tmp_path: Path) -> None:
    targets = {name: list(hand) for name, hand in zip(robot.hand_names, dh.hands(robot.initial), strict=True)}
    scene = make_scene({"name": "there", "targets": targets})
    motion = retime(conftest.plan(robot, scene, optimise=False), robot, scene)
    assert motion.status is Status.REACHED
    np.testing.assert_array_equal(motion.configuration(0.0), robot.initial)
    write_plan(motion, robot, scene, tmp_path, [("playback.html", playback_html(robot, scene, motion))])
    np.testing.assert_array_equal(read_plan(tmp_path).trajectory.q, motion.q)


def test_a_motion_may_not_take_longer_than_it_may(robot: Robot, planned: Trajectory, free: Scene) -> None:
    whole = retime(planned, robot, free)
    cut = retime(planned, robot, free, max_time=0.9 * whole.duration)
    assert cut.status is Status.TIME_LIMIT
    assert f"longer than max_time = {0.9 * whole.duration:g} s" in cut.reason
    np.testing.assert_array_equal(cut.q, whole.q)
    assert retime(cut, robot, free, max_time=whole.duration).status is Status.REACHED


def test_a_retimed_motion_can_be_retimed(robot: Robot) -> None:
    """What is retimed again is the spline and not the chords between its samples, however far apart these are."""
    scene = load_scene(ROOT / "scenes" / "dev" / "shelf-900000.json")
    first = retime(conftest.plan(robot, scene, optimise=False), robot, scene, dt=0.03)
    second = retime(first, robot, scene)
    assert second.certified
    assert second.t[1] == first.t[1] == 0.03  # the time between samples is kept
    assert second.duration == pytest.approx(first.duration, abs=0.1)
    np.testing.assert_array_equal(second.q[[0, -1]], first.q[[0, -1]])
    units = speed_units(robot)
    assert distance_from(sampled(first, 1e-3) / units, sampled(second, 0.01) / units).max() < 0.015


def test_reasons_are_about_the_motion_they_are_of(robot: Robot) -> None:
    """Times are those of the new timing, and nothing is said twice, however often it is retimed."""
    floor = HalfSpace(normal=(0.0, 0.0, 1.0), offset=-0.053)  # 3 mm under the carriage
    steps = [{"left": [0.6, -1.8, 2.6], "right": [0.6, 1.8, 2.6]}, {"left": None, "right": [-0.6, 1.8, 2.9]}]
    scene = make_scene({"name": "near", "targets": steps}).model_copy(update={"obstacles": (floor,)})
    motion = conftest.plan(robot, scene, optimise=False)
    assert motion.reason.count("could not be kept") == 1
    for dwell in (0.5, 0.0):
        motion = retime(motion, robot, scene, dwell=dwell)
        times = ", ".join(f"{arrival:.4g}" for arrival in motion.arrivals)
        assert motion.reason.startswith(f"at the targets at t = {times} s;")
        assert motion.reason.count("could not be kept") == 1


def test_a_motion_that_cannot_be_certified_any_more_says_so(robot: Robot, planned: Trajectory, free: Scene) -> None:
    middle = planned.hands[len(planned.t) // 2][1]
    blocked = free.model_copy(update={"obstacles": (Sphere(center=tuple(middle.tolist()), radius=0.1),)})
    motion = retime(planned, robot, blocked)
    assert not motion.certified
    assert motion.status is Status.UNCERTIFIED
    assert "right_forearm touches obstacles[0]" in motion.reason


def test_a_motion_by_eq_49_keeps_its_status_and_its_faults(robot: Robot, scene: Scene) -> None:
    plan = plan_case(robot, 1)
    motion = retime(plan, robot, scene)
    assert motion.status is Status.REACHED
    assert not motion.certified
    assert motion.certificate.contact is not None
