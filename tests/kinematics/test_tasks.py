"""Tasks: their derivatives, in both engines, and motions that do them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from conftest import assert_gradient, random_q

from humanoid_rail import (
    Auto,
    AxisTask,
    ConfigurationTask,
    DirectionTask,
    DistanceTask,
    Gains,
    GradientProjection,
    InvalidInput,
    LineTask,
    NativeKinematics,
    OrientationTask,
    PointTask,
    Problem,
    RelativeTask,
    Robot,
    SafeVelocity,
    Scene,
    State,
    Status,
    Task,
    make_scene,
    solve,
)
from humanoid_rail import Kinematics as PythonKinematics
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.kinematics.task import LEVER
from humanoid_rail.kinematics.task_stack import stack_error
from humanoid_rail.planning.target_tasks import tasks_of
from humanoid_rail.resolution.native_velocity import projected_velocity
from humanoid_rail.resolution.velocity import gradient_projection

KINDS = ("point", "approach", "rpy")


def pose_of(robot: Robot, q: np.ndarray, kind: str, hand: str) -> Any:
    """Return what a target has to be for a hand to be at it, by Pinocchio."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.full_configuration(q))
    at = data.oMf[robot.model.getFrameId(f"{hand}_hand")]
    position, turned = at.translation.tolist(), at.rotation
    if kind == "point":
        return position
    how = (turned[:, 0] * 2.0).tolist() if kind == "approach" else pin.rpy.matrixToRpy(turned).tolist()
    return {"position": position, kind: how}


def tasks(robot: Robot, q: np.ndarray, left: str, right: str) -> tuple[Task, ...]:
    targets = {"left": pose_of(robot, q, left, "left"), "right": pose_of(robot, q, right, "right")}
    (step,) = make_scene({"name": "poses", "targets": targets}).steps
    return tasks_of(robot, step)


@pytest.mark.parametrize("right", KINDS)
@pytest.mark.parametrize("left", KINDS)
def test_where_hands_are_turned_as_they_have_to_be_their_points_are_there(
    robot: Robot, Kinematics: type, rng: np.random.Generator, left: str, right: str
) -> None:
    q = random_q(robot, rng)
    found = tasks(robot, q, left, right)
    count = {"point": 1, "approach": 2, "rpy": 3}
    np.testing.assert_allclose(stack_error(Kinematics(robot).state(q), found), 0.0, atol=1e-9)
    for hand, kind in (("left", left), ("right", right)):
        own = [task for task in found if isinstance(task, PointTask) and task.hand == hand]
        lengths = np.linalg.norm(np.subtract([task.target for task in own], own[0].target), axis=1)
        np.testing.assert_allclose(lengths[1:], LEVER, atol=1e-12)
        assert len(own) == count[kind]


TURN = tuple(map(tuple, pin.rpy.rpyToMatrix(0.4, -0.9, 1.3).tolist()))
TASKS: dict[str, Task] = {
    "point": PointTask("left", (-1.0, 2.0, 3.0)),
    "point with an offset": PointTask("right", (-1.0, 2.0, 3.0), (0.1, -0.2, 0.3)),
    "direction": DirectionTask("left", (0.3, -1.0, 0.5)),
    "another direction": DirectionTask("right", (0.0, 0.0, 2.0), (0.0, 1.0, 1.0), 0.7),
    "relation": RelativeTask("left", "right", (0.0, 2.0, 0.1)),
    "relation in the first hand's frame": RelativeTask("left", "right", (0.3, 2.0, 0.1), in_first=True),
    "line": LineTask("left", (-1.0, 2.0, 3.0), (0.3, -1.0, 0.5)),
    "line with an offset": LineTask("right", (-1.0, 2.0, 3.0), (1.0, 0.0, 0.0), (0.1, -0.2, 0.3)),
    "distance": DistanceTask("left", "right", 2.0),
    "axis": AxisTask("left", (0.0, 0.0, 1.0)),
    "another axis": AxisTask("right", (1.0, 2.0, 0.0), (0.3, -1.0, 0.5), 0.7),
    "orientation": OrientationTask("left", TURN),
    "orientation in the first hand's frame": OrientationTask("right", TURN, "left", 0.7),
    "configuration": ConfigurationTask(("rail", "left_elbow_pitch"), (1.0, -0.2)),
}


@pytest.mark.parametrize("name", TASKS)
def test_the_jacobian_of_a_task_is_its_derivative(
    robot: Robot, Kinematics: type, rng: np.random.Generator, name: str
) -> None:
    """Every row and every column, by central differences."""
    task, kinematics = TASKS[name], Kinematics(robot)
    for _ in range(5):
        q = random_q(robot, rng)
        J = task.jacobian(kinematics.state(q))
        assert J.shape == (task.rows, robot.n)
        assert_gradient(lambda q: task.error(kinematics.state(q)), J, q, rtol=1e-6)


@pytest.mark.parametrize("name", TASKS)
def test_the_drift_of_a_task_is_the_change_of_its_jacobian(
    robot: Robot, Kinematics: type, rng: np.random.Generator, name: str
) -> None:
    task, kinematics, h = TASKS[name], Kinematics(robot), 1e-6
    for _ in range(5):
        q, velocity = random_q(robot, rng), rng.normal(size=robot.n)
        ahead, behind = (task.jacobian(kinematics.state(q + sign * h * velocity)) for sign in (1, -1))
        expected = (ahead - behind) @ velocity / (2 * h)
        np.testing.assert_allclose(task.drift(kinematics.state(q), velocity), expected, atol=1e-6)


class Own:
    """A task of the user's, which does what another does."""

    def __init__(self, task: Task) -> None:
        self._task = task
        self.rows = task.rows

    def error(self, state: State) -> np.ndarray:
        return self._task.error(state)

    def jacobian(self, state: State) -> np.ndarray:
        return self._task.jacobian(state)

    def drift(self, state: State, velocity: np.ndarray) -> np.ndarray:
        return self._task.drift(state, velocity)


@pytest.mark.parametrize("name", TASKS)
def test_the_native_engine_has_the_same_tasks(robot: Robot, rng: np.random.Generator, name: str) -> None:
    """As eq. 4.9 by Python has it, and as the same task called back."""
    task, gains, native = TASKS[name], Gains(c_mu=0.3), NativeKinematics(robot)
    for _ in range(5):
        q = random_q(robot, rng)
        expected = gradient_projection(PythonKinematics(robot).state(q), [task], gains)
        for one in (task, Own(task)):
            np.testing.assert_allclose(projected_velocity(native, [one], gains)(q), expected, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("method", [Auto(), SafeVelocity(dt=0.02), GradientProjection(dt=0.02)])
def test_tasks_of_ones_own_are_done(robot: Robot, method: Any) -> None:
    """Hands that keep a relation to each other, one of them at a point."""
    hands = PythonKinematics(robot).hand_positions(robot.initial)
    x, y, z = (hands[0] + [-0.3, 0.2, 0.1]).tolist()
    wanted = (PointTask("left", (x, y, z)), RelativeTask("left", "right", (0.1, 4.2, 0.2)))
    free = Scene(name="free", targets={"left": None, "right": None})
    for tasks in (wanted, tuple(map(Own, wanted))):
        trajectory = solve(Problem(robot, free, tasks, robot.initial), method)
        assert trajectory.status is Status.REACHED, trajectory.reason
        np.testing.assert_allclose(trajectory.hands[-1, 0], (x, y, z), atol=0.011)
        difference = trajectory.hands[-1, 1] - trajectory.hands[-1, 0]
        np.testing.assert_allclose(difference, (0.1, 4.2, 0.2), atol=0.011)
        assert trajectory.certified


def test_what_is_no_task_is_named(robot: Robot) -> None:
    free = Scene(name="free", targets={"left": None, "right": None})
    for tasks, field in (((), "tasks"), (("left",), r"tasks\[0\]"), (3, "tasks")):
        with pytest.raises(InvalidInput, match=field):
            Problem(robot, free, tasks, robot.initial)
    for task in (PointTask("middle", (0.0, 0.0, 0.0)), ConfigurationTask(("knee",), (0.0,))):
        with pytest.raises(InvalidInput, match=r"middle|knee"):
            solve(Problem(robot, free, [task], robot.initial), "qp")
    with pytest.raises(InvalidInput, match="start"):
        Problem(robot, free, [TASKS["point"]], np.zeros(3))


def test_a_free_hand_has_no_task(robot: Robot) -> None:
    (step,) = make_scene({"name": "one", "targets": {"left": None, "right": [0.0, 2.0, 3.0]}}).steps
    assert tasks_of(robot, step) == (PointTask("right", (0.0, 2.0, 3.0)),)


@pytest.mark.parametrize("name", TASKS)
def test_the_engine_has_the_rows_of_a_task(robot: Robot, rng: np.random.Generator, name: str) -> None:
    task, kinematics, solver = TASKS[name], PythonKinematics(robot), InverseKinematics(robot, ())
    for _ in range(5):
        q = random_q(robot, rng)
        error, jacobian = solver.evaluate(q, (task,))
        np.testing.assert_allclose(error, task.error(kinematics.state(q)), atol=1e-10)
        np.testing.assert_allclose(jacobian, task.jacobian(kinematics.state(q)), atol=1e-10)
        np.testing.assert_allclose(solver.errors(q[None, :], (task,))[0], error, atol=1e-12)


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: AxisTask("left", (0.0, 0.0, 0.0)), "axis"),
        (lambda: AxisTask("left", (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)), "direction"),
        (lambda: LineTask("left", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), "direction"),
        (lambda: LineTask("left", (0.0, 0.0), (0.0, 0.0, 1.0)), "point"),
        (lambda: DistanceTask("left", "right", -1.0), "distance"),
        (lambda: OrientationTask("left", ((1.0, 0.0, 0.0),) * 3), "rotation"),
        (lambda: RelativeTask("left", "right", (0.0, 0.0, 0.0), "yes"), "in_first"),
    ],
)
def test_a_task_that_makes_no_sense_is_refused(make: Any, field: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        make()
    assert caught.value.field == field
