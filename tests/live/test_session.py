"""What a user does to a world, and what comes of it: without a browser."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator

import numpy as np
import pinocchio as pin
import pytest
from conftest import AHEAD

from humanoid_rail import InvalidInput, Kinematics, Pose, Robot, Scene, Sphere, load_robot, paper_scene
from humanoid_rail.live.session import Mode, Session
from humanoid_rail.live.worker import Worker
from humanoid_rail.live.world import World, nearer, placed, target_rotation, turned_target
from humanoid_rail.scene.placing import placement_of

PATIENCE = 60.0
"""A busy machine is waited for this long, s."""
SCENE = Scene(targets=AHEAD, obstacles=(Sphere(center=(1.5, 2.0, 3.0), radius=0.2),))


def wait_until(is_so: Callable[[], bool], session: Session | None = None) -> None:
    end = time.monotonic() + PATIENCE
    while not is_so():
        assert time.monotonic() < end
        if session is not None:
            session.tick(0.01)
        time.sleep(0.01)


@pytest.fixture
def session(robot: Robot) -> Iterator[Session]:
    made = Session(World.of(robot, SCENE))
    yield made
    made.close()
    assert not [thread for thread in threading.enumerate() if "humanoid_rail live" in thread.name]


def hands(robot: Robot, q: np.ndarray) -> np.ndarray:
    return Kinematics(robot).hand_positions(q).reshape(-1, 3)


def test_a_change_is_planned_retimed_and_certified(session: Session, robot: Robot) -> None:
    wanted = (-1.6, 0.8, 3.2)
    session.change(lambda world: world.with_target(0, "left", wanted))
    assert session.is_planning
    wait_until(lambda: not session.is_planning)
    assert session.plan is not None
    assert session.plan.certified
    assert session.plan.motion is not None
    np.testing.assert_allclose(hands(robot, session.plan.motion.q[-1])[0], wanted, atol=0.011)
    assert "certified" in session.tick(0.0).status
    assert session.tick(0.0).q.shape == (robot.n,)


def test_only_the_latest_of_many_changes_is_planned_to_the_end(session: Session) -> None:
    for i in range(30):
        session.change(lambda world, y=0.6 + 0.01 * i: world.with_target(0, "left", (-1.6, y, 3.4)))
    wait_until(lambda: not session.is_planning)
    assert session.plan is not None
    assert session.plan.trajectory is not None
    assert session.plan.trajectory.hands[-1, 0, 1] == pytest.approx(0.89, abs=0.02)


def test_what_cannot_be_planned_is_said(session: Session, robot: Robot) -> None:
    hand = tuple(hands(robot, robot.initial)[0].tolist())
    session.change(lambda world: world.with_obstacle(0, Sphere(center=hand, radius=0.2)))
    wait_until(lambda: not session.is_planning)
    assert session.plan is not None
    assert not session.plan.certified
    assert "not planned" in session.tick(0.0).status
    session.set_mode(Mode.FOLLOW)
    assert session.mode is Mode.PLAN
    assert "not followed" in session.tick(0.0).status


def test_it_follows_and_goes_back_to_plans(session: Session, robot: Robot) -> None:
    session.set_mode(Mode.FOLLOW)
    wanted = np.array([-1.0, 0.9, 3.2])
    session.change(lambda world: world.with_target(0, "left", tuple(wanted.tolist())))
    wait_until(lambda: float(np.linalg.norm(hands(robot, session.tick(0.01).q)[0] - wanted)) < 0.05, session)
    assert "stop proven" in session.tick(0.01).status
    assert "cycle of 1 ms" in session.tick(0.01).status
    where = session.tick(0.0).q
    session.set_mode(Mode.PLAN)
    np.testing.assert_allclose(session.world.q, where, atol=0.2)
    wait_until(lambda: not session.is_planning)
    assert session.plan is not None
    assert session.plan.certified


def test_a_plan_is_followed_to_its_end(session: Session, robot: Robot) -> None:
    session.set_mode(Mode.DRIVE)
    there = np.array([AHEAD["left"], AHEAD["right"]])
    wait_until(lambda: float(abs(hands(robot, session.tick(0.02).q) - there).max()) < 0.03, session)
    session.change(lambda world: world.with_target(0, "left", (-1.2, 0.7, 3.2)))
    wait_until(lambda: float(abs(hands(robot, session.tick(0.02).q)[0] - (-1.2, 0.7, 3.2)).max()) < 0.03, session)


def test_obstacles_go_where_they_were_put_no_faster_than_they_may(session: Session) -> None:
    session.set_mode(Mode.FOLLOW)
    wanted = Sphere(center=(1.5, 2.5, 3.0), radius=0.2)
    session.change(lambda world: world.with_obstacle(0, wanted))
    before = session.tick(0.02).places[0].translation
    for _ in range(10):
        time.sleep(0.02)  # the follower has a clock of its own, and sees how fast they really are
        after = session.tick(0.02).places[0].translation
        assert 0.0 < np.linalg.norm(after - before) <= 0.2 * 0.02
        before = after
    time.sleep(0.02)
    assert "got farther" not in session.tick(0.02).status


def test_a_robot_of_other_sizes_is_planned_for(session: Session) -> None:
    wait_until(lambda: not session.is_planning)
    session.load_robot(lambda: load_robot(l_l3=0.8))
    wait_until(lambda: "l_l3" not in session.world.robot.name and session.world.robot.arm_reaches[0] < 1.95)
    wait_until(lambda: not session.is_planning)
    assert session.plan is not None
    assert session.plan.trajectory is not None


def test_a_failure_is_shown_and_the_worker_goes_on() -> None:
    errors: list[Exception] = []
    done = threading.Event()
    worker = Worker(errors.append)

    def fail() -> None:
        raise KeyError("something")

    worker.ask(fail)
    wait_until(lambda: bool(errors))
    worker.ask(done.set)
    assert done.wait(PATIENCE)
    worker.close()
    assert len(errors) == 1


def test_worlds_are_checked(robot: Robot) -> None:
    with pytest.raises(InvalidInput, match=r"targets\.third"):
        World.of(robot, Scene(targets={"left": None, "right": (0.0, 0.0, 0.0), "third": None}))
    moving = Scene(targets=AHEAD, obstacles=(Sphere(center=(1.5, 2.0, 3.0), radius=0.2, velocity=(1.0, 0.0, 0.0)),))
    assert World.of(robot, moving).scene.obstacles[0].velocity == (0.0, 0.0, 0.0)
    assert World.of(robot, paper_scene()).scene.obstacles == paper_scene().obstacles


def test_what_is_turned_by_hand_is_turned(rng: np.random.Generator) -> None:
    turn, point = pin.exp3(rng.normal(size=3)), np.array([1.0, 2.0, 3.0])
    pose = turned_target(Pose(position=(0.0, 0.0, 0.0), rpy=(0.0, 0.0, 0.0)), point, turn)
    np.testing.assert_allclose(target_rotation(pose), turn, atol=1e-12)
    pointing = turned_target(Pose(position=(0.0, 0.0, 0.0), approach=(0.0, 0.0, 1.0)), point, turn)
    assert isinstance(pointing, Pose)
    np.testing.assert_allclose(pointing.approach, turn[:, 0], atol=1e-12)
    assert turned_target((0.0, 0.0, 0.0), point, turn) == (1.0, 2.0, 3.0)
    for obstacle in paper_scene().obstacles:
        there = placement_of(placed(obstacle, point, turn))
        np.testing.assert_allclose(there.translation, point)


def test_what_comes_nearer_gets_no_farther_than_it_may(rng: np.random.Generator) -> None:
    for _ in range(50):
        a, b = pin.SE3.Random(), pin.SE3.Random()
        there = nearer(a, b, 0.5, 0.01)
        for corner in 0.5 * np.eye(3):
            assert np.linalg.norm(there.act(corner) - a.act(corner)) <= 0.01 + 1e-12
        assert nearer(a, b, 0.5, 100.0).isApprox(b, 1e-9)


def test_a_robot_that_waits_to_be_loaded_is_not_lost_to_other_changes(session: Session) -> None:
    wait_until(lambda: not session.is_planning)
    begun, go_on = threading.Event(), threading.Event()

    def slowly() -> Robot:
        begun.set()
        assert go_on.wait(PATIENCE)
        return load_robot(l_l3=0.9)

    wanted = load_robot(l_l3=0.8)
    session.load_robot(slowly)
    assert begun.wait(PATIENCE)
    session.load_robot(lambda: wanted)
    session.replan()
    go_on.set()
    wait_until(lambda: not session.is_planning)
    assert session.world.robot is wanted


def test_a_robot_that_is_loaded_late_is_the_one_that_follows(session: Session) -> None:
    wait_until(lambda: not session.is_planning)
    begun, go_on = threading.Event(), threading.Event()
    other = load_robot(l_l3=0.8)

    def slowly() -> Robot:
        begun.set()
        assert go_on.wait(PATIENCE)
        return other

    session.load_robot(slowly)
    assert begun.wait(PATIENCE)
    session.set_mode(Mode.FOLLOW)
    there = session.tick(0.0).q
    go_on.set()
    wait_until(lambda: session.world.robot is other and session._chase is not None)
    assert session.mode is Mode.FOLLOW
    assert session._chase is not None
    assert session._chase.follower.robot is other
    np.testing.assert_allclose(session.tick(0.0).q, there, atol=0.2)
    session.set_mode(Mode.PLAN)
    wait_until(lambda: not session.is_planning)
    assert session.plan is not None
    assert session.plan.certified
