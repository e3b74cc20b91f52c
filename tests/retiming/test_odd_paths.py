"""Motions and limits out of all proportion: they are retimed within limits, or refused with a reason."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import changed

from humanoid_rail import InvalidInput, Robot, Scene, Trajectory, retime
from humanoid_rail.timing import rest_to_rest
from humanoid_rail.timing.cautious_profile import cautious_speed
from humanoid_rail.timing.smooth_path import smooth_path
from humanoid_rail.timing.time_optimal import Limits, fastest_profile


def odd_path(robot: Robot, rng: np.random.Generator, kind: int) -> np.ndarray:
    """Return points that mostly stand still, are nearly nowhere, repeat, or turn back."""
    steps = 0.1 * rng.normal(size=(int(rng.integers(2, 12)), robot.n))
    if kind == 0:
        steps *= 10 ** rng.uniform(-7, 0)
    elif kind == 1:
        steps[rng.random(steps.shape) < 0.8] = 0.0
        steps[0, 1] = 0.1
    elif kind == 2:
        steps *= 10 ** rng.uniform(-7, 0, (len(steps), 1))
    else:
        steps = np.repeat(steps, 2, axis=0) * np.tile([[1.0], [-1.0]], (len(steps), 1))
    return robot.initial + np.cumsum(np.vstack([np.zeros((1, robot.n)), steps]), axis=0)


def moved(trajectory: Trajectory, q: np.ndarray) -> Trajectory:
    t = 0.00026 * np.arange(len(q))
    hands, mu = np.repeat(trajectory.hands[:1], len(q), axis=0), np.ones(len(q))
    clearance = np.full((len(q), trajectory.clearance.shape[1]), np.inf)
    return changed(trajectory, t=t, q=q, hands=hands, clearance=clearance, manipulability=mu, arrivals=(float(t[-1]),))


@pytest.mark.parametrize("kind", [0, 1, 3])
def test_odd_motions_are_retimed_within_limits_or_refused(
    robot: Robot, planned: Trajectory, free: Scene, kind: int
) -> None:
    rng, timed, refused = np.random.default_rng(kind), 0, set()
    for k in range(3):
        motion = moved(planned, odd_path(robot, rng, kind))
        velocity = 10 ** rng.uniform(*((-1.2, 1.1) if k % 2 else (-2, 3)), robot.n)
        acceleration = 10 ** rng.uniform(*((0, 1) if k % 3 else (-2, 3)), robot.n)
        try:
            retimed = retime(motion, robot, free, dt=0.05, velocity_limit=velocity, acceleration_limit=acceleration)
        except InvalidInput as error:
            refused.add(error.field)
            continue
        timed += 1
        assert (abs(retimed.timing.velocity) <= velocity * (1 + 1e-9)).all()
        assert (abs(retimed.timing.acceleration) <= acceleration * (1 + 1e-9)).all()
        np.testing.assert_allclose(retimed.q[[0, -1]], motion.q[[0, -1]], atol=1e-12)
    assert timed
    assert refused <= {"duration"}


def test_the_cautious_profile_is_within_limits_and_not_much_slower(robot: Robot) -> None:
    rng = np.random.default_rng(5)
    for kind in range(4):
        path = smooth_path(robot, odd_path(robot, rng, kind), 0.025)
        limits = Limits(np.full(robot.n, 1.0), np.full(robot.n, 5.0), np.full(robot.n, np.inf))
        fastest = fastest_profile(path, limits)
        speed = cautious_speed(path, fastest.grid, *limits)
        rate = np.diff(speed**2) / (2.0 * np.diff(fastest.grid))
        assert (speed[1:-1] > 0).all()
        assert (speed[0], speed[-1]) == (0.0, 0.0)
        slope, bend = path(fastest.grid, 1), path(fastest.grid, 2)
        assert (abs(slope) * speed[:, None] <= limits.velocity * (1 + 1e-9)).all()
        for end in (slice(None, -1), slice(1, None)):
            asked = slope[end] * rate[:, None] + bend[end] * speed[end, None] ** 2
            assert (abs(asked) <= limits.acceleration * (1 + 1e-9)).all()
        duration = (2.0 * np.diff(fastest.grid) / (speed[1:] + speed[:-1])).sum()
        assert duration <= 1.6 * fastest.arrival[-1]


def test_without_an_answer_of_toppra_there_is_still_a_motion(
    robot: Robot, planned: Trajectory, free: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = retime(planned, robot, free).duration
    monkeypatch.setattr("humanoid_rail.timing.time_optimal._speed", lambda *_: None)
    retimed = retime(planned, robot, free)
    assert (retimed.status, retimed.limits_ok, retimed.certified) == ("reached", True, True)
    assert retimed.duration <= 1.5 * expected


def test_a_motion_that_cannot_be_brought_within_limits_is_refused(
    robot: Robot, planned: Trajectory, free: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rest_to_rest, "SLOWDOWNS", 0)
    with pytest.raises(InvalidInput, match="duration"):
        retime(planned, robot, free)
