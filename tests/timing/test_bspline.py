"""Splines in time: what is proven of them, and how fast they are between their samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import changed
from scipy.interpolate import CubicHermiteSpline

from humanoid_rail import HalfSpace, InvalidInput, Robot, Scene, Sphere, Timing, Trajectory, retime, verify
from humanoid_rail.collision.certifier import certify
from humanoid_rail.kinematics.joint_limits import JointMotion as Motion
from humanoid_rail.kinematics.joint_limits import limit_violations
from humanoid_rail.paper import dh_table as dh
from humanoid_rail.timing.bspline import fastest_in_between

A_FEW = 5_000
"""So many checks prove that the links of a retimed motion keep apart."""


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


def test_a_long_rest_costs_nothing(robot: Robot, free: Scene, planned: Trajectory) -> None:
    """A pause of an hour without samples costs the certificate nothing."""
    motion = retime(planned, robot, free)
    assert motion.timing is not None
    longer = changed(
        motion,
        t=np.append(motion.t, motion.duration + 3600.0),
        q=np.vstack([motion.q, motion.q[-1:]]),
        timing=Timing(*(np.vstack([x, x[-1:]]) for x in (motion.timing.velocity, motion.timing.acceleration)), ()),
    )
    for each in (motion, longer):
        velocity = None if each.timing is None else each.timing.velocity
        assert certify(robot, (), each.t, each.q, velocity, max_checks=A_FEW).certified


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


def test_the_bound_of_a_spline_holds(robot: Robot, rng: np.random.Generator) -> None:
    """Also of one of another tool, whose accelerations jump at its samples. The hands are those of the DH table."""
    t, shares = np.array([0.0, 0.4, 0.5]), []
    for _ in range(10):
        q = robot.initial + rng.normal(0.0, 0.1, (3, robot.n))
        velocity = rng.normal(0.0, 2.0, q.shape)
        hands = dh.hands(CubicHermiteSpline(t, q, velocity)(np.linspace(0.0, 0.5, 501)))
        wall = HalfSpace(normal=(1.0, 0.0, 0.0), offset=float(hands[..., 0].min()) - 0.3)
        certificate = certify(robot, (wall,), t, q, velocity)
        assert certificate.clearance_bound is not None
        assert certificate.clearance_bound <= 0.3 - 0.05
        shares.append(certificate.clearance_bound)
    assert max(shares) > 0.15


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
