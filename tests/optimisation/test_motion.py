"""Motions of least time: within limits, certified, at their targets, and never longer than retimed ones."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT
from drivable import EXCESS, assert_within_limits

from humanoid_rail import Robot, Scene, Sphere, Status, Trajectory, load_robot, load_scene, plan, retime, verify
from humanoid_rail.optimisation import motion as optimisation_motion
from humanoid_rail.paper import dh_table as dh
from humanoid_rail.planning.methods import Auto

SCENES = ("sparse-80003", "sparse-80015", "dense-240002", "dense-240011", "shelf-900000", "shelf-900005", "deep-500007")
QUICK = Auto(optimise=False)


def scene_of(name: str) -> Scene:
    return load_scene(Path(ROOT) / "scenes" / "dev" / f"{name}.json")


@pytest.mark.parametrize("name", SCENES)
def test_it_is_fast_and_safe(robot: Robot, name: str) -> None:
    scene = scene_of(name)
    found, before = plan(robot, scene), retime(plan(robot, scene, QUICK))
    assert found.status is Status.REACHED, found.reason
    assert found.certified
    assert found.certificate is not None
    assert found.certificate.kept_bound is None or found.certificate.kept_bound >= 0.009 - 1e-6
    assert found.limits_ok
    assert found.provenance.optimisation is not None
    assert found.provenance.optimisation.optimised == 1
    assert_within_limits(robot, found)
    assert np.ptp(np.diff(found.t)) < 1e-9
    assert np.diff(found.t).max() <= 0.01 + 1e-12
    assert found.least_duration is not None
    assert found.least_duration <= found.duration <= 0.97 * before.duration
    hands = np.asarray(dh.hands(found.q[-1]))
    for hand, at in zip(("left", "right"), hands, strict=True):
        target = scene.steps[0][hand]
        if target is not None:
            np.testing.assert_allclose(at, target, atol=1e-6)
    np.testing.assert_array_equal(found.q[0], before.q[0])
    proof = verify(robot, scene, found)
    assert proof.certified
    assert proof.clearance_bound == found.certificate.clearance_bound


def test_each_step_is_optimised_and_ends_at_rest() -> None:
    robot = load_robot("human-sized")
    scene = load_scene(Path(ROOT) / "scenes" / "picks.yaml")
    found, before = plan(robot, scene), retime(plan(robot, scene, QUICK))
    assert found.status is Status.REACHED
    assert found.certified
    assert_within_limits(robot, found)
    assert len(found.arrivals) == len(scene.steps)
    assert found.timing is not None
    for arrival in found.arrivals:
        i = int(np.argmin(abs(found.t - arrival)))
        assert found.t[i] == pytest.approx(arrival, abs=1e-9)
        assert not found.timing.velocity[i].any()
        assert not found.timing.acceleration[i].any()
    assert found.duration < before.duration
    assert found.least_duration is not None
    assert found.least_duration <= found.duration


def test_a_seed_gives_the_same_motion_in_eight_threads_at_once(robot: Robot) -> None:
    scenes = [scene_of(name) for name in ("dense-240002", "shelf-900000")]
    alone = [plan(robot, scene) for scene in scenes]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(lambda k: plan(robot, scenes[k % 2]), range(8)))
    for k, found in enumerate(together):
        assert found.q.tobytes() == alone[k % 2].q.tobytes()
        assert found.t.tobytes() == alone[k % 2].t.tobytes()


def test_a_budget_of_steps(robot: Robot) -> None:
    scene = scene_of("dense-240002")
    durations = []
    for steps in (0, 1, 4, 12):
        found = plan(robot, scene, Auto(max_optimisation_steps=steps))
        assert found.certified
        done = found.provenance.optimisation
        assert done is not None
        assert done.steps <= steps + optimisation_motion.REPAIRS * optimisation_motion.REPAIR_STEPS
        assert done.optimised == (steps > 0 and found.duration < durations[0])
        durations.append(found.duration)
        assert_within_limits(robot, found)
    assert durations[0] == retime(plan(robot, scene, QUICK)).duration
    assert durations[0] >= durations[1] >= durations[2] >= durations[3]


def test_where_it_cannot_be_certified_the_path_is_followed(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of("dense-240002")
    before = retime(plan(robot, scene, QUICK))
    real = optimisation_motion.certified_motion

    def uncertified(*arguments: object) -> object:
        motion = real(*arguments)  # type: ignore[arg-type]
        return motion._replace(certificate=replace(motion.certificate, certified=False, clearance_bound=-0.01))

    monkeypatch.setattr(optimisation_motion, "certified_motion", uncertified)
    found = plan(robot, scene)
    assert found.certified
    assert found.provenance.optimisation is not None
    assert found.provenance.optimisation.optimised == 0
    np.testing.assert_array_equal(found.q, before.q)


def test_what_would_take_longer_is_not_taken(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of("sparse-80003")
    before = retime(plan(robot, scene, QUICK))
    real = optimisation_motion.knots
    monkeypatch.setattr(optimisation_motion, "knots", lambda *a: (2.0 * real(*a)[0], 2 * real(*a)[1]))
    found = plan(robot, scene)
    np.testing.assert_array_equal(found.q, before.q)


def test_a_limit_of_jerk_is_kept(robot: Robot) -> None:
    scene = scene_of("dense-240002")
    smooth = replace(robot, jerk_limit=np.full(robot.n, 50.0))
    found, free = plan(smooth, scene), plan(robot, scene)
    assert found.certified
    assert found.timing is not None
    assert found.provenance.optimisation is not None
    assert found.provenance.optimisation.optimised == 1
    assert_within_limits(smooth, found)
    jerk = np.diff(found.timing.acceleration, axis=0) / np.diff(found.t)[:, None]
    assert abs(jerk).max() <= 50.0 * (1.0 + EXCESS)
    assert abs(jerk).max() >= 40.0
    assert found.duration > free.duration
    assert found.duration < retime(plan(smooth, scene, QUICK)).duration


def test_where_a_joint_has_no_limit_of_acceleration_nothing_is_optimised(robot: Robot) -> None:
    scene = scene_of("dense-240002")
    endless = replace(robot, acceleration_limit=np.where(np.arange(robot.n) == 4, np.inf, robot.acceleration_limit))
    found, quick = plan(endless, scene), plan(endless, scene, QUICK)
    assert found.timing is None
    np.testing.assert_array_equal(found.q, quick.q)
    assert found.provenance.optimisation is not None
    assert robot.joint_names[4] in found.provenance.optimisation.reason
    assert quick.provenance.optimisation is None


def test_among_moving_obstacles_nothing_is_optimised(robot: Robot, free: Scene) -> None:
    away = Sphere(center=(0.0, 9.0, 1.0), radius=0.1, velocity=(0.0, 0.1, 0.0))
    found = plan(robot, free.model_copy(update={"obstacles": (away,)}))
    assert found.timing is None
    assert found.provenance.optimisation is None


def test_a_motion_that_stays_has_a_timing_too(robot: Robot, free: Scene, planned: Trajectory) -> None:
    there = free.model_copy(update={"initial": tuple(planned.q[-1].tolist())})
    found = plan(robot, there)
    assert found.status is Status.REACHED
    assert found.duration == 0.0
    assert found.timing is not None
    assert found.timing.velocity.shape == (1, robot.n)


@pytest.mark.parametrize("dt", [0.004, 0.05, 1.0])
def test_samples_are_as_far_apart_as_they_may_be_and_not_farther(robot: Robot, dt: float) -> None:
    found = plan(robot, scene_of("dense-240002"), Auto(dt=dt))
    assert found.provenance.optimisation is not None
    assert found.provenance.optimisation.optimised == 1
    steps = np.diff(found.t)
    assert np.ptp(steps) < 1e-9
    most = min(dt, optimisation_motion.LONGEST_STEP)
    assert 0.5 * most <= steps[0] <= most + 1e-12
    assert_within_limits(robot, found)


def test_joints_without_a_speed_limit_are_as_fast_as_their_accelerations(robot: Robot) -> None:
    scene = scene_of("sparse-80003")
    endless = replace(robot, velocity_limit=np.full(robot.n, np.inf))
    found = plan(endless, scene)
    assert found.certified
    assert found.provenance.optimisation is not None
    assert found.provenance.optimisation.optimised == 1
    assert_within_limits(endless, found)
    assert found.duration <= plan(robot, scene).duration * 1.02


def test_one_that_takes_too_long_is_cut(robot: Robot) -> None:
    scene = scene_of("dense-240002")
    quick, found = plan(robot, scene, QUICK), plan(robot, scene)
    between = 0.5 * (quick.duration + found.duration)
    assert quick.duration < between < found.duration
    cut = plan(robot, scene, Auto(max_time=between))
    assert cut.status is Status.TIME_LIMIT
    assert "max_time" in cut.reason
    assert cut.duration <= between


def test_it_can_be_retimed(robot: Robot) -> None:
    scene = scene_of("dense-240002")
    found = plan(robot, scene)
    slower = retime(found, speed=0.5)
    assert slower.certified
    assert 1.9 * found.duration < slower.duration < 2.3 * found.duration
    np.testing.assert_allclose(slower.q[-1], found.q[-1], atol=1e-12)
