"""How fast paths are followed: toppra's profiles, averaged, and ruckig's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import BSpline

from humanoid_rail import Robot, Scene, Trajectory, retime
from humanoid_rail.timing.jerk_limited import with_bounded_jerk
from humanoid_rail.timing.smooth_path import smooth_path
from humanoid_rail.timing.time_optimal import Limits, averaged, fastest_profile, rise_time


@pytest.fixture(scope="module")
def path(robot: Robot, planned: Trajectory) -> BSpline:
    return smooth_path(robot, planned.q, 0.05)


def limits(robot: Robot, jerk: float = np.inf) -> Limits:
    return Limits(robot.velocity_limit, robot.acceleration_limit, np.full(robot.n, jerk))


@pytest.mark.parametrize("window", [1e-3, 0.1, 10.0])
def test_the_average_is_the_mean_over_its_window(robot: Robot, path: BSpline, window: float) -> None:
    """Against SciPy's quadrature of the profile itself, before the start and after the end at rest."""
    profile = fastest_profile(path, limits(robot))
    itself, mean = averaged(profile, 0.0), averaged(profile, window)
    assert mean.duration == itself.duration + window
    for t in np.linspace(-0.1, mean.duration + 0.1, 9):
        area, _ = quad(lambda x: float(itself.position(np.array([x]))[0]), t - window, t, limit=500, epsabs=1e-10)
        assert mean.position(np.array([t]))[0] == pytest.approx(area / window, abs=1e-7)


def test_an_average_sets_in_from_rest_to_rest(robot: Robot, path: BSpline) -> None:
    profile, jerk, h = fastest_profile(path, limits(robot)), 50.0, 1e-3
    rise = rise_time(path, profile, limits(robot, jerk))
    mean = averaged(profile, rise)
    s = mean.position(np.arange(-5.0, mean.duration / h + 5.0) * h)
    assert (np.diff(s) >= -1e-12).all()
    assert (s[:5] == s[0]).all()
    np.testing.assert_allclose(s[-5:], profile.grid[-1], atol=1e-12)
    # Within the window s_ddot changes by no more than it does in all.
    change = 2.0 * abs(profile.rate).max() / rise
    assert abs(np.diff(s, 3)).max() / h**3 <= 1.01 * change


def test_joints_come_to_their_accelerations_in_the_time_that_their_jerk_takes(robot: Robot, path: BSpline) -> None:
    """Against differences of the joints along the profile."""
    profile, h = fastest_profile(path, limits(robot)), 1e-4
    progress = averaged(profile, 0.0)
    q = path(progress.position(np.arange(0.0, progress.duration, h)))
    found = abs(np.diff(q, 2, axis=0)).max() / h**2 / 50.0
    assert rise_time(path, profile, limits(robot, 50.0)) == pytest.approx(found, rel=0.02)


def test_where_ruckig_has_no_answer_there_is_still_toppra(robot: Robot, planned: Trajectory, free: Scene) -> None:
    path = smooth_path(robot, planned.q, 0.05)
    limits = Limits(robot.velocity_limit, robot.acceleration_limit, np.full(robot.n, 1e300))
    with pytest.raises(RuntimeError, match="ruckig"), np.errstate(over="ignore"):
        with_bounded_jerk(path, fastest_profile(path, limits), limits)
    assert retime(planned, robot, free, jerk_limit=1e9).duration == retime(planned, robot, free).duration
