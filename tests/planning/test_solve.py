"""Tasks of one's own, by every method."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from conftest import AHEAD

from humanoid_rail import (
    Auto,
    Box,
    ConfigurationTask,
    DirectionTask,
    GradientProjection,
    InvalidInput,
    Kinematics,
    PointTask,
    Problem,
    RelativeTask,
    Robot,
    SafeVelocity,
    Scene,
    Sphere,
    State,
    Status,
    Task,
    plan,
    solve,
    verify,
)
from humanoid_rail.kinematics.task_stack import stack_error
from humanoid_rail.paper import dh_table as dh
from humanoid_rail.planning.target_tasks import tasks_of

EMPTY = Scene(name="empty", targets={"left": None, "right": None})
METHODS = [
    Auto(),
    SafeVelocity(dt=0.02),
    GradientProjection(dt=0.02),
    GradientProjection(dt=0.05, engine="python"),
]
IDS = ["auto", "qp", "gradient-projection", "in Python"]


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


TASKS: dict[str, tuple[Task, ...]] = {
    "relation": (RelativeTask("left", "right", (0.2, 4.0, -0.1)),),
    "relation and point": (RelativeTask("left", "right", (0.1, 4.2, 0.2)), PointTask("left", (-1.0, -0.5, 3.0))),
    "configuration": (ConfigurationTask(("rail", "left_elbow_pitch", "waist_yaw"), (1.0, -0.4, 0.2)),),
    "all joints": (),  # filled in by `tasks`
    "configuration and point": (ConfigurationTask(("rail",), (0.7,)), PointTask("right", (-1.0, 2.6, 3.0))),
}


def tasks(robot: Robot, name: str) -> tuple[Task, ...]:
    if name == "all joints":
        return (ConfigurationTask(robot.joint_names, tuple((robot.initial + 0.2 * np.sign(robot.upper)).tolist())),)
    return TASKS[name]


@pytest.mark.parametrize("name", TASKS)
@pytest.mark.parametrize("method", METHODS, ids=IDS)
def test_tasks_are_done(robot: Robot, method: Any, name: str) -> None:
    """To the tolerance, as the DH table has it."""
    wanted = tasks(robot, name)
    trajectory = solve(Problem(robot, EMPTY, wanted, robot.initial), method)
    assert trajectory.status is Status.REACHED, trajectory.reason
    end, (left, right) = trajectory.q[-1], dh.hands(trajectory.q[-1])
    errors: list[float] = []
    for task in wanted:
        match task:
            case RelativeTask():
                errors += (right - left - task.difference).tolist()
            case PointTask():
                errors += ({"left": left, "right": right}[task.hand] - task.target).tolist()
            case ConfigurationTask():
                errors += (end[[robot.joint_names.index(joint) for joint in task.joints]] - task.target).tolist()
    assert np.linalg.norm(errors) <= 0.01 + 1e-6
    np.testing.assert_array_equal(trajectory.q[0], robot.initial)
    if method.name != "gradient-projection":
        assert trajectory.limits_ok
        assert trajectory.certified
        assert trajectory.certificate == verify(robot, EMPTY, trajectory)


@pytest.mark.parametrize("name", TASKS)
@pytest.mark.parametrize("method", METHODS[:3], ids=IDS[:3])
def test_a_task_written_in_python_gives_the_same_motion(robot: Robot, method: Any, name: str) -> None:
    built_in = tasks(robot, name)
    one, two = (
        solve(Problem(robot, EMPTY, wanted, robot.initial), method) for wanted in (built_in, [*map(Own, built_in)])
    )
    assert one.status is two.status
    np.testing.assert_allclose(one.t, two.t, atol=1e-6)
    np.testing.assert_allclose(one.q, two.q, atol=1e-6)


@pytest.mark.parametrize("method", METHODS, ids=IDS)
def test_the_tasks_of_a_scene_are_what_plan_does(robot: Robot, free: Scene, method: Any) -> None:
    (step,) = free.steps
    by_tasks = solve(Problem(robot, free, tasks_of(robot, step), robot.initial), method)
    planned = plan(robot, free, method)
    np.testing.assert_array_equal(by_tasks.t, planned.t)
    np.testing.assert_array_equal(by_tasks.q, planned.q)
    assert by_tasks.reason == planned.reason
    assert by_tasks.provenance.scene == "free"


@pytest.mark.parametrize("own", [False, True])
def test_auto_points_a_hand_in_a_direction(robot: Robot, own: bool) -> None:
    """A task of one's own that turns a hand has dependent rows too, which inverse kinematics does not mind."""
    wanted: list[Task] = [PointTask("right", AHEAD["right"]), DirectionTask("right", (-1.0, 0.0, -0.5))]
    trajectory = solve(Problem(robot, EMPTY, [wanted[0], Own(wanted[1])] if own else wanted, robot.initial))
    assert trajectory.status is Status.REACHED, trajectory.reason
    assert np.linalg.norm(stack_error(Kinematics(robot).state(trajectory.q[-1]), wanted)) <= 0.01
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.full_configuration(trajectory.q[-1]))
    pointing = data.oMf[robot.model.getFrameId("right_hand")].rotation[:, 0]
    # An error of 0.01 m at a lever of 0.3 m.
    assert np.linalg.norm(pointing - np.array([-1.0, 0.0, -0.5]) / 1.25**0.5) <= (0.034 if own else 1e-6)


def test_auto_turns_no_hand_among_obstacles_that_move(robot: Robot) -> None:
    """There it follows qp, which would leave the direction out."""
    ball = Sphere(center=(3.0, 0.0, 6.0), radius=0.1, velocity=(0.0, 0.0, 0.1))
    scene = EMPTY.model_copy(update={"obstacles": (ball,)})
    wanted = [PointTask("right", AHEAD["right"]), DirectionTask("right", (-1.0, 0.0, -0.5))]
    with pytest.raises(InvalidInput, match=r"tasks.*DirectionTask.*at rest"):
        solve(Problem(robot, scene, wanted, robot.initial))
    assert solve(Problem(robot, scene, wanted[:1], robot.initial)).status is Status.REACHED


@pytest.mark.parametrize("gain", [1.5, (1.0, 2.0, 1.5, 1.0, 1.0, 1.0)])
def test_auto_takes_a_gain_for_each_row_of_tasks_that_turn_hands(robot: Robot, gain: Any) -> None:
    """The velocity follows the other tasks, by their own gains."""
    wanted = [PointTask("right", AHEAD["right"]), DirectionTask("right", (-1.0, 0.0, -0.5))]
    assert solve(Problem(robot, EMPTY, wanted, robot.initial), Auto(gain=gain)).status is Status.REACHED
    with pytest.raises(InvalidInput, match="1 or 6 numbers"):
        solve(Problem(robot, EMPTY, wanted, robot.initial), Auto(gain=(1.0, 2.0, 3.0)))


class Higher(PointTask):
    """A point 0.3 m above the target."""

    def error(self, state: State) -> np.ndarray:
        return super().error(state) - np.array([0.0, 0.0, 0.3])


@pytest.mark.parametrize("method", METHODS, ids=IDS)
def test_a_class_derived_from_a_task_is_the_users_own(robot: Robot, method: Any) -> None:
    trajectory = solve(Problem(robot, EMPTY, [Higher("right", AHEAD["right"])], robot.initial), method)
    assert trajectory.status is Status.REACHED, trajectory.reason
    np.testing.assert_allclose(dh.hands(trajectory.q[-1])[1], np.add(AHEAD["right"], [0.0, 0.0, 0.3]), atol=0.0101)


@pytest.mark.parametrize("method", METHODS, ids=IDS)
def test_a_start_in_an_obstacle_is_the_start_of_the_problem(robot: Robot, method: Any) -> None:
    inside = Sphere(center=tuple(dh.hands(robot.initial)[1]), radius=0.2)
    scene = EMPTY.model_copy(update={"obstacles": (inside,)})
    with pytest.raises(InvalidInput) as caught:
        solve(Problem(robot, scene, [PointTask("right", AHEAD["right"])], robot.initial), method)
    assert caught.value.field == "start"


def test_both_hands_carry_something_around_an_obstacle(robot: Robot) -> None:
    """Certified among obstacles, the hands as far from each other at the end as they have to be."""
    pillar = Box(center=(-1.0, 0.0, 2.4), size=(0.2, 0.2, 1.2))
    scene = EMPTY.model_copy(update={"obstacles": (pillar, Sphere(center=(-1.2, 3.6, 3.4), radius=0.2))})
    wanted = (PointTask("left", (-1.4, 0.6, 3.4)), RelativeTask("left", "right", (0.0, 1.6, 0.0)))
    for method in (Auto(), SafeVelocity()):
        trajectory = solve(Problem(robot, scene, wanted, robot.initial), method)
        assert trajectory.status is Status.REACHED, trajectory.reason
        assert trajectory.certified
        assert verify(robot, scene, trajectory).certified
        left, right = dh.hands(trajectory.q[-1])
        np.testing.assert_allclose(right - left, [0.0, 1.6, 0.0], atol=0.01)


def test_a_gain_for_each_row(robot: Robot) -> None:
    """The errors of the first task decay at its own rates."""
    K, wanted = (1.0, 2.0, 3.0, 0.5), (PointTask("left", (-1.0, -0.5, 3.0)), ConfigurationTask(("rail",), (0.7,)))
    trajectory = solve(Problem(robot, EMPTY, wanted, robot.initial), GradientProjection(gain=K, dt=0.05))
    e = np.column_stack([trajectory.hands[:, 0] - wanted[0].target, trajectory.q[:, 0] - 0.7])
    np.testing.assert_allclose(e, e[0] * np.exp(-np.outer(trajectory.t, K)), atol=1e-4)
    with pytest.raises(InvalidInput, match="1 or 4 numbers"):
        solve(Problem(robot, EMPTY, wanted, robot.initial), GradientProjection(gain=(1.0,) * 6))


def test_what_is_out_of_reach_is_said(robot: Robot) -> None:
    for task, what in (
        (PointTask("left", (0.0, 0.0, 9.0)), "the target of the left hand is"),
        (RelativeTask("left", "right", (0.0, 30.0, 0.0)), "RelativeTask"),
        (ConfigurationTask(("rail",), (40.0,)), "ConfigurationTask"),
    ):
        trajectory = solve(Problem(robot, EMPTY, [task], robot.initial))
        assert trajectory.status is Status.TARGET_OUT_OF_REACH, trajectory.reason
        assert what in trajectory.reason
        assert "out of reach" in trajectory.reason
        assert trajectory.certified


@pytest.mark.parametrize("method", METHODS, ids=IDS)
def test_errors_of_a_task_come_out_as_they_are(robot: Robot, method: Any) -> None:
    error = ZeroDivisionError("of the task")

    class Broken(Own):
        def jacobian(self, state: State) -> np.ndarray:
            raise error

    with pytest.raises(ZeroDivisionError) as caught:
        solve(Problem(robot, EMPTY, [Broken(PointTask("left", AHEAD["left"]))], robot.initial), method)
    assert caught.value is error
    error.__traceback__ = None  # it would keep what called back alive, and that keeps the task


def test_parts_of_a_problem_are_checked(robot: Robot, folded_q: np.ndarray) -> None:
    task = PointTask("left", AHEAD["left"])
    for arguments, field in (
        ((None, EMPTY, [task], robot.initial), "robot"),
        ((robot, None, [task], robot.initial), "scene"),
        ((robot, EMPTY, [], robot.initial), "tasks"),
        ((robot, EMPTY, [task, 3], robot.initial), "tasks[1]"),
        ((robot, EMPTY, [task], np.full(robot.n, np.nan)), "start"),
        ((robot, EMPTY, [task], "there"), "start"),
        ((robot, EMPTY, [task], robot.upper + 1.0), "start[0] (rail)"),
    ):
        with pytest.raises(InvalidInput) as caught:
            Problem(*arguments)
        assert caught.value.field == field
    with pytest.raises(InvalidInput, match="problem"):
        solve(None)  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match="no links touch"):
        solve(Problem(robot, EMPTY, [task], folded_q))


def test_a_problem_is_frozen(robot: Robot) -> None:
    start, wanted = robot.initial.copy(), [PointTask("left", AHEAD["left"])]
    problem = Problem(robot, EMPTY, wanted, start)
    start[0] = 3.0
    wanted.clear()
    np.testing.assert_array_equal(problem.q, robot.initial)
    assert len(problem.tasks) == 1
    with pytest.raises(ValueError, match="read-only"):
        problem.q[0] = 3.0
