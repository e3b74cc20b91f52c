"""Resampled motions: the same motion, against interpolators of SciPy, and proven once more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from humanoid_rail import InvalidInput, NativeKinematics, Robot, Scene, Sphere, Trajectory, plan, retime, verify
from humanoid_rail.resampling import is_evenly_spaced, resampled

MOVING = Scene(
    name="moving",
    targets={"left": (0.6, -1.8, 2.6), "right": (0.6, 1.8, 2.6)},
    obstacles=(Sphere(center=(1.5, 1.0, 3.0), radius=0.2, velocity=(0.0, 0.1, 0.0)),),
)


@pytest.fixture(scope="module", params=["linear", "cubic"])
def motion(request: pytest.FixtureRequest, robot: Robot) -> Trajectory:
    trajectory = plan(robot, MOVING, "qp")
    assert trajectory.certified
    return trajectory if request.param == "linear" else retime(trajectory)


@pytest.mark.parametrize("dt", [0.001, 0.0037, 0.5])
def test_it_is_the_same_motion(motion: Trajectory, robot: Robot, dt: float) -> None:
    fine = motion.resample(dt)
    own = np.isin(fine.t, motion.t)
    assert own.sum() == len(motion.t)
    for name in ("q", "hands", "clearance", "manipulability"):
        np.testing.assert_array_equal(getattr(fine, name)[own], getattr(motion, name))
    if motion.timing is None:
        expected = np.array([np.interp(fine.t, motion.t, column) for column in motion.q.T]).T
        np.testing.assert_allclose(fine.q, expected, atol=1e-13)
    else:
        spline = CubicHermiteSpline(motion.t, motion.q, motion.timing.velocity)
        np.testing.assert_allclose(fine.q, spline(fine.t), atol=1e-13)
        np.testing.assert_allclose(fine.timing.velocity, spline(fine.t, 1), atol=1e-11)
        np.testing.assert_allclose(fine.timing.acceleration, spline(fine.t, 2), atol=1e-8)
        again = CubicHermiteSpline(fine.t, fine.q, fine.timing.velocity)
        between = np.linspace(fine.t[0], fine.t[-1], 3001)
        np.testing.assert_allclose(again(between), spline(between), atol=1e-12)
    # Every dt there is a sample.
    wanted = np.arange(0.0, fine.t[-1], dt)
    assert abs(fine.t[:, None] - wanted[None]).min(axis=0).max() <= 1.001e-6 * dt
    course = NativeKinematics(robot, MOVING.obstacles).along(fine.q, np.inf, fine.t)
    np.testing.assert_allclose(fine.hands, course.hands, atol=1e-12)
    near = np.isfinite(fine.clearance)
    np.testing.assert_allclose(fine.clearance[near], course.clearance[near], atol=1e-9)


def test_what_is_certified_stays_certified(motion: Trajectory, robot: Robot) -> None:
    fine = motion.resample(0.002)
    assert fine.certificate is motion.certificate
    assert (fine.status, fine.reason, fine.arrivals) == (motion.status, motion.reason, motion.arrivals)
    proven = verify(robot, MOVING, fine)
    assert proven.certified
    assert proven.clearance_bound == pytest.approx(motion.clearance_bound, abs=2e-3)


def test_rates_that_are_multiples_give_evenly_spaced_samples(robot: Robot) -> None:
    motion = retime(plan(robot, MOVING, "qp"))
    assert is_evenly_spaced(motion.resample(0.001).t)
    assert is_evenly_spaced(motion.resample(1 / 300).t)
    assert not is_evenly_spaced(motion.resample(0.004).t)


def test_a_motion_of_one_sample_stays(planned: Trajectory) -> None:
    one, own = resampled(replace(planned.motion, t=planned.t[:1], q=planned.q[:1]), 0.1)
    assert (len(one.t), own.tolist()) == (1, [True])


@pytest.mark.parametrize("dt", [0.0, -1.0, float("nan"), 1e-9, "fast"])
def test_what_is_no_time_between_samples_is_refused(dt: object, planned: Trajectory) -> None:
    with pytest.raises(InvalidInput, match="dt is"):
        planned.resample(dt)
