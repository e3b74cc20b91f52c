"""Tasks with a tolerance: their errors and derivatives, in both engines."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from conftest import assert_gradient, random_q

from humanoid_rail import AxisTask, InvalidInput, OrientationTask, PointTask, Robot, Task, WithinTask
from humanoid_rail import Kinematics as PythonKinematics
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.kinematics.within_task import nominal

TURNED = tuple(tuple(row) for row in pin.rpy.rpyToMatrix(0.3, -0.5, 0.8).tolist())


def made(robot: Robot, rng: np.random.Generator, kind: str, share: float) -> tuple[np.ndarray, WithinTask]:
    """Return a configuration, and a task whose tolerance is a share of its error there."""
    q = random_q(robot, rng)
    inner = {
        "point": PointTask("left", (0.5, 1.0, 2.0)),
        "axis": AxisTask("left", (1.0, 0.0, 0.0), (0.6, 0.0, 0.8)),
        "orientation": OrientationTask("left", TURNED),
    }[kind]
    d = inner.error(PythonKinematics(robot).state(q))
    if kind == "point":
        return q, WithinTask(inner, tuple((share * abs(np.array(TURNED) @ d)).tolist()), TURNED)
    return q, WithinTask(inner, share * float(np.linalg.norm(d)))


@pytest.mark.parametrize("share", [0.0, 0.3, 0.99])
@pytest.mark.parametrize("kind", ["point", "axis", "orientation"])
def test_jacobians_are_those_of_the_errors_beyond_the_tolerance(
    robot: Robot, rng: np.random.Generator, kind: str, share: float
) -> None:
    q, task = made(robot, rng, kind, share)
    kinematics = PythonKinematics(robot)
    assert np.linalg.norm(task.error(kinematics.state(q))) > 0.0
    for i in range(task.rows):
        jacobian = task.jacobian(kinematics.state(q))[i]
        assert_gradient(lambda x, i=i: task.error(kinematics.state(x))[i : i + 1], jacobian[None], q, rtol=2e-6)


@pytest.mark.parametrize("kind", ["point", "axis", "orientation"])
def test_within_the_tolerance_there_is_no_error_and_no_slope(robot: Robot, rng: np.random.Generator, kind: str) -> None:
    q, task = made(robot, rng, kind, 1.01)
    state = PythonKinematics(robot).state(q)
    np.testing.assert_array_equal(task.error(state), 0.0)
    np.testing.assert_array_equal(task.jacobian(state), 0.0)


@pytest.mark.parametrize("kind", ["axis", "orientation"])
def test_beyond_the_tolerance_the_error_is_what_is_too_much(robot: Robot, rng: np.random.Generator, kind: str) -> None:
    q, task = made(robot, rng, kind, 0.4)
    state = PythonKinematics(robot).state(q)
    left = np.linalg.norm(task.error(state))
    assert left == pytest.approx(0.6 * np.linalg.norm(task.task.error(state)), rel=1e-12)


def test_along_one_axis_a_point_may_be_off_and_along_others_not(robot: Robot, rng: np.random.Generator) -> None:
    q = random_q(robot, rng)
    hand = PythonKinematics(robot).hand_positions(q)[0]
    away = np.array(TURNED).T @ np.array([0.04, -0.02, 0.03])
    task = WithinTask(PointTask("left", tuple(hand - away)), (0.05, 0.0, 0.01), TURNED)
    np.testing.assert_allclose(task.error(PythonKinematics(robot).state(q)), [0.0, -0.02, 0.02], atol=1e-12)


@pytest.mark.parametrize("share", [0.0, 0.3, 0.99, 1.01])
@pytest.mark.parametrize("kind", ["point", "axis", "orientation"])
def test_the_engine_agrees(robot: Robot, rng: np.random.Generator, kind: str, share: float) -> None:
    q, task = made(robot, rng, kind, share)
    error, jacobian = InverseKinematics(robot, ()).evaluate(q, [task])
    state = PythonKinematics(robot).state(q)
    np.testing.assert_allclose(error, task.error(state), atol=1e-12)
    np.testing.assert_allclose(jacobian, task.jacobian(state), atol=1e-12)


@pytest.mark.parametrize("share", [0.0, 0.3])
@pytest.mark.parametrize("kind", ["point", "axis", "orientation"])
def test_drift_is_what_the_jacobian_changes_by(robot: Robot, rng: np.random.Generator, kind: str, share: float) -> None:
    q, task = made(robot, rng, kind, share)
    kinematics, v, h = PythonKinematics(robot), rng.normal(size=robot.n), 1e-6
    rate = (task.jacobian(kinematics.state(q + h * v)) - task.jacobian(kinematics.state(q - h * v))) / (2 * h)
    drift = task.drift(kinematics.state(q), v)
    np.testing.assert_allclose(drift, rate @ v, atol=1e-5 * max(1.0, np.linalg.norm(drift)))


def test_nominal_tasks_have_no_tolerance() -> None:
    inner = PointTask("left", (0.5, 1.0, 2.0))
    tasks: tuple[Task, ...] = (WithinTask(inner, (0.1, 0.1, 0.1)), PointTask("right", (0.0, 0.0, 0.0)))
    assert nominal(tasks) == (inner, tasks[1])


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ((PointTask("left", (0, 0, 0)), 0.1), "tolerance"),
        ((PointTask("left", (0, 0, 0)), (0.1, -0.1, 0.1)), "tolerance"),
        ((OrientationTask("left", TURNED), -0.1), "tolerance"),
        (("left", 0.1), "task"),
        ((PointTask("left", (0, 0, 0)), (0.1, 0.1, 0.1), ((1, 0, 0), (1, 0, 0), (0, 0, 1))), "axes"),
    ],
)
def test_what_is_no_tolerance_is_refused(arguments: tuple[object, ...], field: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        WithinTask(*arguments)
    assert caught.value.field == field
