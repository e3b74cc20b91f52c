"""What is true at samples is computed when it is first asked for, and once."""

from __future__ import annotations

import copy
import pickle
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from humanoid_rail import (
    GradientProjection,
    NativeKinematics,
    Robot,
    Scene,
    Trajectory,
    paper_scene,
    plan,
    plan_many,
    read_trajectory,
    retime,
    write_trajectory,
)
from humanoid_rail.kinematics.state import Course
from humanoid_rail.samples import Samples

NAMES = ("hands", "clearance", "manipulability")
MAKERS: dict[str, Callable[[Robot, Scene], Trajectory]] = {
    "plan": lambda robot, scene: plan(robot, scene),
    "far": lambda robot, scene: plan(robot, scene, GradientProjection(far_clearances=True)),
    "python": lambda robot, scene: plan(robot, scene, GradientProjection(engine="python", dt=0.2)),
    "retime": lambda robot, scene: retime(plan(robot, scene)),
    "resample": lambda robot, scene: plan(robot, scene, "qp").resample(0.001),
}


def counted(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return a list to which the number of samples is added whenever some are computed."""
    seen, along = list[int](), NativeKinematics.along

    def counting(self: NativeKinematics, q: np.ndarray, *arguments: object) -> Course:
        seen.append(len(q))
        return along(self, q, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(NativeKinematics, "along", counting)
    return seen


@pytest.mark.parametrize("made", MAKERS)
def test_they_are_those_of_the_motion(made: str, robot: Robot) -> None:
    scene = paper_scene()
    trajectory = MAKERS[made](robot, scene)
    horizon = np.inf if trajectory.method.far_clearances else trajectory.method.epsilon
    course = NativeKinematics(robot, scene.obstacles).along(trajectory.q, horizon, trajectory.t)
    for name in NAMES:
        values = getattr(trajectory, name)
        np.testing.assert_allclose(values, getattr(course, name), atol=1e-9)
        assert not values.flags.writeable
        assert getattr(trajectory, name) is values
    assert trajectory.min_clearance == pytest.approx(course.clearance.min(), abs=1e-9)


@pytest.mark.parametrize("made", ["plan", "retime", "resample"])
def test_nothing_is_computed_before_it_is_asked_for(made: str, robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    seen = counted(monkeypatch)
    trajectory = MAKERS[made](robot, paper_scene())
    assert trajectory.certified
    assert trajectory.hand_names == robot.hand_names
    assert not seen
    assert len(trajectory.hands) == len(trajectory.clearance) == len(trajectory.manipulability) == len(trajectory.t)
    # Of a motion that was resampled those that it had, and those in between.
    assert sum(seen) == len(trajectory.t)


def test_threads_that_ask_at_once_get_the_same() -> None:
    calls, got = list[int](), list[Course]()

    def compute() -> Course:
        calls.append(1)
        time.sleep(0.05)
        return Course(np.zeros((1, 1, 3)), np.zeros(1), np.zeros((1, 0)))

    samples = Samples(("hand",), compute)
    threads = [threading.Thread(target=lambda: got.append(samples.course)) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(calls) == 1
    assert len(got) == 8
    assert all(course is got[0] for course in got)


def test_what_fails_is_tried_again() -> None:
    fails = [True]

    def compute() -> Course:
        if fails.pop():
            fails.append(False)
            raise KeyboardInterrupt
        return Course(np.zeros((1, 1, 3)), np.zeros(1), np.zeros((1, 0)))

    samples = Samples(("hand",), compute)
    with pytest.raises(KeyboardInterrupt):
        _ = samples.hands
    assert samples.manipulability.shape == (1,)


@pytest.mark.parametrize("carried", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_they_are_computed_before_they_are_carried_elsewhere(
    carried: Callable[[Samples], Samples], robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    samples = plan(robot, paper_scene()).resample(0.001).samples
    there = carried(samples)
    seen = counted(monkeypatch)
    for name in NAMES:
        np.testing.assert_array_equal(getattr(there, name), getattr(samples, name))
        assert not getattr(there, name).flags.writeable
    assert there.hand_names == robot.hand_names
    assert not seen


def test_files_hold_them(robot: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    trajectory = plan(robot, paper_scene())
    write_trajectory(trajectory, tmp_path)
    seen = counted(monkeypatch)
    read = read_trajectory(tmp_path)
    for name in NAMES:
        np.testing.assert_array_equal(getattr(read, name), getattr(trajectory, name))
    assert not seen


def test_workers_compute_those_of_the_plans_that_they_make(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = paper_scene()
    expected = plan(robot, scene).clearance
    seen = counted(monkeypatch)
    planned = plan_many(robot, [scene, scene], n_jobs=2)
    for trajectory in planned:
        assert isinstance(trajectory, Trajectory)
        np.testing.assert_array_equal(trajectory.clearance, expected)
    assert not seen
