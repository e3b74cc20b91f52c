"""What is plotted of a motion, against the trajectory and by central differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import changed, plan

from humanoid_rail import Kinematics, Robot, Scene, Sphere, Trajectory, plan_case, retime
from humanoid_rail.viewer.series import MOST, RATE, Series, moments, series


@pytest.fixture(scope="module")
def retimed(robot: Robot, scene: Scene) -> Trajectory:
    return retime(plan(robot, scene), robot, scene)


def at_samples(found: Series, trajectory: Trajectory) -> tuple[np.ndarray, np.ndarray]:
    """Return the moments that are samples, and which samples these are, by number."""
    k = np.flatnonzero(np.isin(found.t, trajectory.t))
    return k, np.searchsorted(trajectory.t, found.t[k])


@pytest.mark.parametrize("is_retimed", [True, False])
def test_series_have_the_values_of_the_trajectory(
    is_retimed: bool, robot: Robot, scene: Scene, retimed: Trajectory
) -> None:
    trajectory = retimed if is_retimed else plan_case(robot, 3)
    found = series(robot, scene, trajectory)
    k, i = at_samples(found, trajectory)
    assert len(k) > 50
    assert {0, len(trajectory.t) - 1, trajectory.clearance.min(axis=1).argmin()} <= set(i)
    np.testing.assert_allclose(found.clearance[k], trajectory.clearance[i].min(axis=1), atol=1e-12)
    np.testing.assert_allclose(found.manipulability[k], trajectory.manipulability[i], atol=1e-12)
    np.testing.assert_allclose(found.q[k], trajectory.q[i], atol=1e-12)
    assert np.diff(found.t).max() < 2.0 / RATE
    if is_retimed:
        timing = trajectory.timing
        np.testing.assert_allclose(found.speed[k], abs(timing.velocity[i]) / robot.velocity_limit, atol=1e-9)
        bounded = np.isfinite(robot.acceleration_limit)
        shares = abs(timing.acceleration[i])[:, bounded] / robot.acceleration_limit[bounded]
        np.testing.assert_allclose(found.acceleration[k][:, bounded], shares, atol=1e-9)
        assert found.acceleration.max() == pytest.approx(
            (abs(timing.acceleration)[:, bounded] / robot.acceleration_limit[bounded]).max()
        )
    else:
        i = i[i < len(trajectory.t) - 1]
        rate = (trajectory.q[i + 1] - trajectory.q[i]) / (trajectory.t[i + 1] - trajectory.t[i])[:, None]
        np.testing.assert_allclose(found.speed[k][: len(i)], abs(rate) / robot.velocity_limit, atol=1e-9)
        assert found.acceleration is None


def test_speeds_of_hands_are_those_of_their_positions(robot: Robot, scene: Scene, retimed: Trajectory) -> None:
    found, kinematics, h = series(robot, scene, retimed), Kinematics(robot), 1e-6
    k, i = at_samples(found, retimed)
    for moment, sample in zip(k[1:-1:5], i[1:-1:5], strict=True):
        q, v = retimed.q[sample], retimed.timing.velocity[sample]
        rate = (kinematics.hand_positions(q + h * v) - kinematics.hand_positions(q - h * v)) / (2 * h)
        np.testing.assert_allclose(found.hand_speed[moment], np.linalg.norm(rate, axis=-1), atol=1e-6)


def test_between_far_samples_clearances_are_measured_not_drawn_through(robot: Robot, scene: Scene) -> None:
    between = tuple(plan_case(robot, 3).hands[:, 0].mean(axis=0).tolist())
    scene = scene.model_copy(update={"obstacles": (Sphere(center=between, radius=0.1),)})
    trajectory = plan(robot, scene, "gradient-projection", c_kappa=0.0, dt=2.0)
    found, kinematics = series(robot, scene, trajectory), Kinematics(robot, scene.obstacles)
    assert len(found.t) > 10 * len(trajectory.t)
    for t, clearance, pair in zip(found.t[::7], found.clearance[::7], found.pairs.obstacles[::7], strict=True):
        measured = kinematics.measure(trajectory.configuration(t)).clearance.min()
        assert clearance == pytest.approx(measured, abs=2e-5)
        assert pair.distance == pytest.approx(clearance, abs=2e-5)


def test_there_are_not_too_many_moments(retimed: Trajectory) -> None:
    slow = replace(retimed, motion=replace(retimed.motion, t=1000 * retimed.t))
    assert len(moments(slow)) < 1.2 * MOST
    assert (np.diff(moments(slow)) > 0).all()


def test_without_engine_obstacles_or_motion_there_is_less(
    robot: Robot, scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    empty = scene.model_copy(update={"obstacles": ()})
    assert series(robot, empty, plan(robot, empty)).clearance is None
    targets = dict(zip(robot.hand_names, Kinematics(robot).hand_positions(robot.initial).tolist(), strict=True))
    there = scene.model_copy(update={"targets": targets})
    rest = series(robot, there, plan(robot, there))
    assert len(rest.t) == 1
    assert not rest.hand_speed.any()
    trajectory: Trajectory = changed(plan_case(robot, 1, dt=0.5), certificate=None)
    assert trajectory.clearance.size  # samples are computed by the engine, where they are asked for
    monkeypatch.setattr("humanoid_rail._native.why_no_engine", lambda: "not built")
    found = series(robot, scene, trajectory)
    assert not any(found.pairs)
    np.testing.assert_allclose(found.clearance, np.interp(found.t, trajectory.t, trajectory.clearance.min(axis=1)))
