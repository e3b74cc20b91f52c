"""Splines in time: what is proven of them, and how fast they are between their samples."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from conftest import changed
from scipy.interpolate import CubicHermiteSpline

from humanoid_rail import Certificate, InvalidInput, Robot, Scene, Sphere, Timing, Trajectory, retime, verify
from humanoid_rail.collision.certifier import certify
from humanoid_rail.collision.spline_certifier import SAGITTA, certify_spline, deviation_from_chords
from humanoid_rail.kinematics.joint_limits import JointMotion as Motion
from humanoid_rail.kinematics.joint_limits import limit_violations
from humanoid_rail.paper import dh_table as dh
from humanoid_rail.retiming.bspline import fastest_in_between


def test_a_faster_limit_than_the_robots_is_seen_between_the_samples_too(
    robot: Robot, planned: Trajectory, free: Scene
) -> None:
    fast = retime(planned, robot, free, dt=0.1, velocity_limit=50.0)
    assert fast.timing is not None
    peaks, at_samples = [peak.velocity for peak in fast.timing.peaks], abs(fast.timing.velocity).max(axis=0)
    joint = int(np.argmax(peaks - at_samples))
    limit = 0.5 * (at_samples[joint] + peaks[joint])
    assert at_samples[joint] < limit - 1e-5
    slow = replace(robot, velocity_limit=np.where(np.arange(robot.n) == joint, limit, 50.0))
    fastest = fastest_in_between(fast.timing.velocity, fast.timing.acceleration, 0.1)
    (violation,) = limit_violations(slow, Motion(fast.t, fast.q, fastest))
    assert (violation.joint, violation.quantity) == (robot.joint_names[joint], "velocity")
    assert abs(violation.value) == pytest.approx(peaks[joint], rel=1e-12)
    assert fast.violations == limit_violations(robot, Motion(fast.t, fast.q, fastest, fast.timing.acceleration))


def test_a_long_rest_is_one_piece(
    robot: Robot, free: Scene, planned: Trajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A pause of an hour without samples costs the certificate nothing."""
    motion = retime(planned, robot, free)
    assert motion.timing is not None
    longer = changed(
        motion,
        t=np.append(motion.t, motion.duration + 3600.0),
        q=np.vstack([motion.q, motion.q[-1:]]),
        timing=Timing(*(np.vstack([x, x[-1:]]) for x in (motion.timing.velocity, motion.timing.acceleration)), ()),
    )
    pieces: list[int] = []

    def counting(*arguments: Any) -> Any:
        pieces.append(len(arguments[2]))
        return certify(*arguments)

    monkeypatch.setattr("humanoid_rail.collision.spline_certifier.certify", counting)

    for each in (motion, longer):
        assert certify_spline(robot, (), each.t, each.q, each.timing.velocity).certified  # type: ignore[union-attr]
    assert pieces[1] == pieces[0] + 1


def test_a_velocity_that_jumps_in_its_change_is_bounded_from_both_sides(
    robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second derivative of a spline of another tool jumps at its samples: just before one it is the largest."""
    dt, q = 0.2, np.tile(robot.initial, (3, 1))
    yaw = robot.joint_names.index("waist_yaw")
    q[1:, yaw] += 0.1
    velocity = np.zeros_like(q)
    velocity[1, yaw] = 0.8
    t = np.array([0.0, dt, 2 * dt])
    spline = CubicHermiteSpline(t, q, velocity)
    bounds: list[np.ndarray] = []

    def looking(_robot: Any, _obstacles: Any, fine: np.ndarray, places: np.ndarray) -> Certificate:
        looks = np.linspace(0.0, 1.0, 9)
        for a, b, begin, end in zip(fine[:-1], fine[1:], places[:-1], places[1:], strict=True):
            chord = begin + looks[:, None] * (end - begin)
            bounds.append(abs(spline(a + looks * (b - a)) - chord).max(axis=0))
        return Certificate(
            certified=True, min_clearance_obstacles=None, min_clearance_self=1.0, clearance_bound=1.0, contact=None
        )

    monkeypatch.setattr("humanoid_rail.collision.spline_certifier.certify", looking)
    found = certify_spline(robot, (), t, q, velocity)
    assert found.clearance_bound is not None
    # Everything that turns with the waist is at most 3 m from its axis.
    away = max(bound[yaw] for bound in bounds)
    assert away <= SAGITTA * 1.001
    assert 1.0 - found.clearance_bound >= 2.0 * away


def test_a_spline_is_not_the_chords_between_its_samples(robot: Robot, planned: Trajectory, free: Scene) -> None:
    """At rest at both samples, but for a large velocity that swings an arm out in between."""
    q = np.tile(robot.initial, (2, 1))
    velocity = np.zeros_like(q)
    velocity[:, robot.joint_names.index("waist_yaw")] = [3.0, -3.0]
    bulge = q[0].copy()
    bulge[robot.joint_names.index("waist_yaw")] += 0.75
    place = tuple(dh.hands(bulge)[1].tolist())
    scene = free.model_copy(update={"obstacles": (Sphere(center=place, radius=0.1),)})
    motion = changed(planned, t=np.array([0.0, 1.0]), q=q)
    assert verify(robot, scene, motion).certified
    timing = Timing(velocity, np.zeros_like(q), ())
    assert not verify(robot, scene, changed(motion, timing=timing)).certified


def test_how_far_a_spline_strays_from_its_chords(robot: Robot, rng: np.random.Generator) -> None:
    """The hands, by the DH table, never stray farther than the bound says, and some nearly as far as a half of it."""
    dt, shares = 0.05, []
    for _ in range(50):
        q0, v0, v1 = rng.uniform(robot.lower, robot.upper), *rng.uniform(-1.0, 1.0, (2, robot.n))
        q1 = q0 + 0.5 * dt * (v0 + v1) + rng.uniform(-1e-3, 1e-3, robot.n)
        spline = CubicHermiteSpline([0.0, dt], [q0, q1], [v0, v1])
        change = abs(spline([0.0, dt], 2)).max(axis=0, keepdims=True)
        bound = deviation_from_chords(robot, np.array([0.0, dt]), np.array([q0, q1]), change)
        for share in np.linspace(0.0, 1.0, 11):
            chord = (1.0 - share) * q0 + share * q1
            away = np.linalg.norm(dh.hands(spline(share * dt)) - dh.hands(chord), axis=1).max()
            assert away <= bound
            shares.append(away / bound)
    assert max(shares) > 0.2


def test_velocities_of_a_trajectory_have_its_shape(robot: Robot, planned: Trajectory, free: Scene) -> None:
    timing = Timing(np.zeros((2, robot.n)), np.zeros((2, robot.n)), ())
    with pytest.raises(InvalidInput, match=r"timing\.velocity"):
        verify(robot, free, changed(planned, timing=timing))


def test_a_timing_is_shown_in_a_line(robot: Robot, planned: Trajectory, free: Scene) -> None:
    """Not by its arrays, nor by its peaks."""
    timing = retime(planned, robot, free, speed=0.5).timing
    assert timing is not None
    share = max(peak.velocity / (0.5 * limit) for peak, limit in zip(timing.peaks, robot.velocity_limit, strict=True))
    shown = f"up to {share:.0%} of the velocity limits"
    assert repr(timing) == f"Timing({len(timing.velocity)} samples, 12 joints, {shown})"
    assert repr(Timing(np.zeros((3, 2)), np.zeros((3, 2)), ())) == "Timing(3 samples, 2 joints)"
