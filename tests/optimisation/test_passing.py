"""Targets that are passed without stopping: exactly, within limits, certified, and sooner than with stops."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from drivable import assert_within_limits
from scipy.interpolate import CubicHermiteSpline

from humanoid_rail import (
    Robot,
    Scene,
    Sphere,
    Status,
    Trajectory,
    load_robot,
    make_scene,
    plan,
    read_trajectory,
    retime,
    verify,
    write_trajectory,
)
from humanoid_rail.optimisation import passing
from humanoid_rail.optimisation.spline import weights
from humanoid_rail.optimisation.waypoints import APART, margin, smoothest, spread
from humanoid_rail.planning.methods import Auto
from humanoid_rail.planning.moves import moves_of

SHELF = [
    {"type": "sphere", "center": [-1.0, 2.0, 2.6], "radius": 0.25},
    {"type": "box", "center": [-1.9, 1.4, 2.9], "size": [0.4, 3.0, 0.04]},
]
ONE_HAND = [
    {"left": [-1.6, 0.6, 3.4], "right": [-1.6, 2.2, 3.4]},
    {"left": [-1.6, 1.6, 3.3], "right": None},
    {"left": None, "right": [-1.2, 3.4, 3.0]},
]
SWEEP = [{"left": [-1.6, 0.6 + 0.4 * k, 3.2], "right": [-1.6, 2.2 + 0.4 * k, 3.2]} for k in range(4)]
FR3 = [
    {"left": [0.4, 0.45, 0.5], "right": [0.4, -0.45, 0.5]},
    {"left": [0.5, 0.3, 0.6], "right": [0.5, -0.3, 0.6]},
    {"left": [0.4, 0.2, 0.4], "right": None},
]
CASES = {"one hand": ("humanoid_rail", ONE_HAND), "sweep": ("humanoid_rail", SWEEP), "dual_fr3": ("dual_fr3", FR3)}


def scene_of(steps: list[dict], stops: list[bool], obstacles: object = SHELF) -> Scene:  # type: ignore[type-arg]
    targets = [{**step, "stop": stop} for step, stop in zip(steps, stops, strict=True)]
    return make_scene({"name": "passing", "targets": targets, "obstacles": obstacles})


@cache
def robot_of(name: str) -> Robot:
    return load_robot() if name == "humanoid_rail" else load_robot(name)


@cache
def planned_case(case: str) -> tuple[Robot, Scene, Trajectory, Trajectory]:
    """Return a robot, a scene whose targets are passed, and the motions that pass them and that stop at them."""
    name, steps = CASES[case]
    robot, obstacles = robot_of(name), SHELF if name == "humanoid_rail" else []
    asked = scene_of(steps, [False] * len(steps), obstacles)
    return robot, asked, plan(robot, asked), plan(robot, scene_of(steps, [True] * len(steps), obstacles))


def hand_at(robot: Robot, q: np.ndarray, hand: str) -> np.ndarray:
    """Return where a hand is, by Pinocchio."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.full_configuration(q))
    frame = next(one.frame for one in robot.hands if one.name == hand)
    return np.array(data.oMf[robot.model.getFrameId(frame)].translation)


def off_target(robot: Robot, scene: Scene, motion: Trajectory) -> list[float]:
    """Return how far each step's hands are from their targets when they arrive, by SciPy's spline, m."""
    assert motion.timing is not None
    spline = CubicHermiteSpline(motion.t, motion.q, motion.timing.velocity)
    return [
        max(
            float(np.linalg.norm(hand_at(robot, spline(t), hand) - target))
            for hand, target in step.items()
            if target is not None
        )
        for step, t in zip(scene.steps, motion.arrivals, strict=True)
    ]


def speeds(motion: Trajectory) -> np.ndarray:
    """Return the largest speed of a joint at each arrival."""
    assert motion.timing is not None
    spline = CubicHermiteSpline(motion.t, motion.q, motion.timing.velocity)
    return np.array([abs(spline(t, 1)).max() for t in motion.arrivals])


@pytest.mark.parametrize("case", CASES)
def test_targets_are_passed_exactly_and_sooner(case: str) -> None:
    robot, asked, motion, stopping = planned_case(case)
    assert motion.status is Status.REACHED, motion.reason
    assert motion.certified
    assert motion.limits_ok
    done = motion.provenance.optimisation
    assert done is not None
    assert (done.passed, done.optimised, done.stopped) == (len(asked.steps) - 1, len(asked.steps), "")
    assert max(off_target(robot, asked, motion)) <= 1e-6
    assert (speeds(motion)[:-1] > 0.1).all()
    assert_within_limits(robot, motion)
    assert motion.duration < 0.9 * stopping.duration
    assert all(abs(motion.t - t).min() < 1e-12 for t in motion.arrivals)
    proof = verify(robot, asked, motion)
    assert proof.certified
    assert motion.certificate is not None
    assert proof.clearance_bound == motion.certificate.clearance_bound
    assert proof.kept_bound is None or proof.kept_bound >= 0.009 - 1e-6


def test_the_same_seed_gives_the_same_motion() -> None:
    robot, asked, motion, _ = planned_case("one hand")
    again = plan(robot, asked)
    assert again.t.tobytes() == motion.t.tobytes()
    assert again.q.tobytes() == motion.q.tobytes()


def test_it_rests_where_steps_do_not_say_otherwise(robot: Robot) -> None:
    asked = scene_of(SWEEP, [False, True, False, False])
    motion = plan(robot, asked)
    assert motion.certified
    assert motion.provenance.optimisation is not None
    assert motion.provenance.optimisation.passed == 2
    np.testing.assert_array_equal(speeds(motion) > 1e-9, [True, False, True, False])
    assert max(off_target(robot, asked, motion)) <= 1e-6
    assert_within_limits(robot, motion)


def rest_to_rest(way: float, velocity: float, acceleration: float) -> float:
    """Return the least time for a way by bisection on a bang-bang motion, apart from the package's formula, s."""
    low, high = 0.0, 100.0
    for _ in range(200):
        time = (low + high) / 2.0
        peak = min(acceleration * time / 2.0, velocity)
        low, high = (low, time) if peak * (time - peak / acceleration) >= way else (time, high)
    return high


@pytest.mark.parametrize("case", CASES)
def test_the_lower_bound_does_not_rest_where_the_motion_does_not(case: str) -> None:
    robot, _, motion, stopping = planned_case(case)
    assert motion.least_duration is not None
    assert stopping.least_duration is not None
    assert motion.least_duration <= motion.duration
    assert motion.least_duration < stopping.least_duration
    points = motion.q[[0, *(int(abs(motion.t - t).argmin()) for t in motion.arrivals)]]
    least = 0.0
    for j, column in enumerate(points.T):
        if not np.ptp(column):
            continue
        # From one turn to the next.
        turns, going = [column[0]], 0.0
        for here, there in pairwise(column):
            if going * (there - here) < 0.0:
                turns.append(here)
            going = there - here or going
        turns.append(column[-1])
        ways = abs(np.diff(turns))
        least = max(least, sum(rest_to_rest(way, robot.velocity_limit[j], robot.acceleration_limit[j]) for way in ways))
    full_speed = (abs(np.diff(points, axis=0)) / robot.velocity_limit).max(axis=1).sum()
    assert motion.least_duration == pytest.approx(max(least, full_speed), rel=1e-9)


def test_without_optimisation_it_stops_and_says_so(robot: Robot) -> None:
    motion = plan(robot, scene_of(ONE_HAND, [False] * 3), Auto(max_optimisation_steps=0))
    assert motion.status is Status.REACHED
    assert "it rests at targets that were to be passed: no step of optimisation is allowed" in motion.reason
    assert speeds(motion) == pytest.approx(0.0, abs=1e-12)


def stopping_plan(robot: Robot) -> Trajectory:
    return plan(robot, scene_of(ONE_HAND, [True] * 3))


def test_what_is_not_certified_is_not_passed(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    before = stopping_plan(robot)
    real = passing.repaired

    def lost(*arguments: object) -> object:
        return real(*arguments)._replace(motion=None)  # type: ignore[arg-type]

    monkeypatch.setattr(passing, "repaired", lost)
    motion = plan(robot, scene_of(ONE_HAND, [False] * 3))
    assert "could be certified" in motion.reason
    np.testing.assert_array_equal(motion.q, before.q)


def test_what_takes_longer_is_not_taken(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    before = stopping_plan(robot)
    real = passing.repaired

    def slow(*arguments: object) -> object:
        found = real(*arguments)  # type: ignore[arg-type]
        return found._replace(motion=found.motion and found.motion._replace(t=5.0 * found.motion.t))

    monkeypatch.setattr(passing, "repaired", slow)
    motion = plan(robot, scene_of(ONE_HAND, [False] * 3))
    assert motion.reason.endswith("to be passed: a motion that passes them takes no less time")
    np.testing.assert_array_equal(motion.q, before.q)


def test_it_rests_where_a_hand_moves_straight(robot: Robot) -> None:
    straight = {"position": [-1.6, 1.6, 3.3], "approach": {"direction": [-1, 0, 0], "distance": 0.1}}
    steps = [{"left": straight, "right": None}, ONE_HAND[0]]
    moves = moves_of(scene_of(steps, [False, True]))
    assert [move.passes for move in moves] == [False, False, False]
    assert [move.has_to_rest for move in moves] == [False, True, False]
    before = moves_of(scene_of([ONE_HAND[0], *steps], [False, False, False]))
    assert [move.passes for move in before] == [True, False, False, False]


def test_untimed_motions_are_as_they_were(robot: Robot) -> None:
    endless = replace(robot, acceleration_limit=np.where(np.arange(robot.n) == 4, np.inf, robot.acceleration_limit))
    moving = Sphere(center=(0.0, 9.0, 1.0), radius=0.1, velocity=(0.0, 0.1, 0.0))
    for able, method, obstacles in (
        (robot, Auto(optimise=False), SHELF),
        (endless, Auto(), SHELF),
        (robot, Auto(), [moving]),
    ):
        found, before = (plan(able, scene_of(ONE_HAND[:2], [stop] * 2, obstacles), method) for stop in (False, True))
        assert found.timing is None
        np.testing.assert_array_equal(found.q, before.q)
        assert found.reason == before.reason


def test_a_limit_of_jerk_is_kept(robot: Robot) -> None:
    smooth = replace(robot, jerk_limit=np.full(robot.n, 60.0))
    asked = scene_of(ONE_HAND, [False] * 3)
    motion = plan(smooth, asked)
    assert motion.provenance.optimisation is not None
    assert motion.provenance.optimisation.passed == 2
    assert motion.certified
    assert max(off_target(smooth, asked, motion)) <= 1e-6
    assert motion.timing is not None
    assert max(peak.jerk for peak in motion.timing.peaks) <= 60.0 * (1.0 + 1e-4)
    assert_within_limits(smooth, motion)


def test_it_can_be_retimed() -> None:
    robot, asked, motion, stopping = planned_case("one hand")
    slower = retime(motion, robot, asked, speed=0.5)
    assert slower.certified
    assert (speeds(slower)[:-1] > 0.05).all()
    assert max(off_target(robot, asked, slower)) <= 0.01
    assert 1.9 * motion.duration < slower.duration < 2.4 * motion.duration
    assert slower.least_duration is not None
    assert slower.least_duration <= slower.duration
    assert "to be passed" not in slower.reason
    assert slower.duration < retime(stopping, speed=0.5).duration
    assert retime(motion, dwell=0.5).duration == retime(motion).duration


def test_a_retimed_motion_rests_where_it_would_miss(robot: Robot) -> None:
    asked = scene_of(ONE_HAND, [False] * 3)
    quick = plan(robot, asked, Auto(optimise=False, tolerance=1e-6))
    retimed = retime(quick, dwell=0.2)
    assert "it rests at targets that were to be passed: it would pass them" in retimed.reason
    assert speeds(retimed) == pytest.approx(0.0)
    stopping = retime(plan(robot, scene_of(ONE_HAND, [True] * 3), Auto(optimise=False)), dwell=0.2)
    np.testing.assert_array_equal(retimed.q, stopping.q)


def test_moments_are_spread() -> None:
    """In order, apart from each other and from both ends, and where they were if that is so already."""
    for degree in (2, 3):
        np.testing.assert_array_equal(spread(np.array([4.0, 6.5]), degree, 12), [4.0, 6.5])
        for given in ([0.0, 0.0, 0.0], [12.0, 12.0, 12.0], [5.0, 4.0, 4.5], [6.0, 6.2, 11.9]):
            moments = spread(np.array(given), degree, 12)
            assert moments is not None
            assert (np.diff(moments) >= APART - 1e-12).all()
            assert moments[0] >= margin(degree)
            assert moments[-1] <= 12 - margin(degree)
        assert spread(np.zeros(12), degree, 12) is None


@pytest.mark.parametrize("degree", [2, 3])
def test_the_smoothest_change(degree: int, rng: np.random.Generator) -> None:
    """It is 1 at one moment and 0 at the others and the ends, and no other such change bends less."""
    rows = weights(degree, 12, np.array([3.3, 4.4, 7.0]))
    changes = smoothest(rows, degree)
    np.testing.assert_allclose(rows @ changes, np.eye(3), atol=1e-12)
    assert not changes[:degree].any()
    assert not changes[-degree:].any()
    free = np.zeros((len(changes) - 2 * degree, len(changes)))
    free[:, degree:-degree] = np.eye(len(free))
    still = np.linalg.svd(rows @ free.T)[2][3:] @ free
    for other in rng.normal(size=(20, len(still))) @ still:
        np.testing.assert_allclose(rows @ other, 0.0, atol=1e-10)
        for change in changes.T:
            assert np.diff(change, 2) @ np.diff(other, 2) == pytest.approx(0.0, abs=1e-9)


def test_what_is_said_of_it_is_written_and_read(tmp_path: Path) -> None:
    _, _, motion, _ = planned_case("one hand")
    write_trajectory(motion, tmp_path)
    again = read_trajectory(tmp_path)
    assert again.provenance.optimisation == motion.provenance.optimisation
    assert again.arrivals == motion.arrivals


def test_a_target_twice_in_a_row(robot: Robot) -> None:
    """There is room for both: at one place, one after the other."""
    asked = scene_of([ONE_HAND[0], ONE_HAND[0], ONE_HAND[1]], [False, False, True])
    motion = plan(robot, asked)
    assert motion.certified
    assert (np.diff([0.0, *motion.arrivals]) >= 0.0).all()
    assert max(off_target(robot, asked, motion)) <= 1e-6
    assert motion.duration <= plan(robot, scene_of([ONE_HAND[0], ONE_HAND[1]], [True, True])).duration
