"""What a follower does about obstacles that are moved, that move on, and that get farther than their speed allows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from conftest import AHEAD
from wandering import DT, around, turned

from humanoid_rail import (
    Box,
    Follower,
    FollowerStatus,
    HalfSpace,
    InvalidInput,
    Kinematics,
    PointCloud,
    Robot,
    Scene,
    Sphere,
)
from humanoid_rail.scene.obstacles import Obstacle


def test_it_is_at_rest_before_what_comes_at_it(robot: Robot) -> None:
    """A sphere that flies at its full speed at a hand from anywhere meets a robot that stands still."""
    rng, met = np.random.default_rng(4), 0
    for _ in range(12):
        side = rng.normal(size=3)
        place = Kinematics(robot).hand_positions(robot.initial).reshape(-1, 3)[0] + 2.0 * side / np.linalg.norm(side)
        ball: Obstacle = Sphere(center=tuple(place.tolist()), radius=0.15)
        if Kinematics(robot, (ball,)).measure(robot.initial).clearance.min() < 0.2:
            continue
        follower = Follower(robot, Scene(targets=AHEAD, obstacles=(ball,)), dt=DT, obstacle_speed=4.0)
        q, fastest = robot.initial, 0.0
        for _ in range(150):
            state = follower.step()
            clear = Kinematics(robot, (ball,)).measure(q).clearance.min()
            if clear < 0.0:
                met += fastest > 0.1
                assert not state.velocity.any()
                assert state.status is FollowerStatus.STOPPED or state.error <= 0.01
                assert state.closest is not None
                assert state.closest.other == "obstacles[0] (sphere)"
                break
            hand = Kinematics(robot).hand_positions(state.q).reshape(-1, 3)[0]
            towards = hand - np.array(ball.center)
            ball = turned(ball, 3.99 * DT * towards / np.linalg.norm(towards), np.zeros(3))
            follower.move_obstacle(0, ball.center)
            q, fastest = state.q, max(fastest, float(abs(state.velocity).max()))
    assert met >= 3


def test_a_jump_is_reported_and_ends_in_a_stop(robot: Robot) -> None:
    ball = Sphere(center=(3.0, 8.0, 3.0), radius=0.2)
    follower = Follower(robot, Scene(targets=AHEAD, obstacles=(ball,)), dt=DT, obstacle_speed=0.1)
    for _ in range(30):
        assert follower.step().jumped is None
    assert follower.state.velocity.any()
    hand = Kinematics(robot).hand_positions(follower.state.q).reshape(-1, 3)[0]
    follower.move_obstacle(0, hand)
    state = follower.step()
    assert state.jumped == "obstacles[0] (sphere)"
    assert not state.proven
    assert "got farther than its speed allows" in state.reason
    assert "no stop is proven" in state.reason
    for _ in range(200):
        before, state = state, follower.step()
        assert (abs(state.velocity - before.velocity) <= follower.acceleration_limit * DT * (1 + 1e-6)).all()
    assert not state.velocity.any()
    assert state.proven  # at rest there is nothing to prove
    # A jump to where nothing is touched is one, too, and proven again at once.
    follower.move_obstacle(0, (3.0, 8.0, 3.0))
    assert follower.step().jumped == "obstacles[0] (sphere)"
    state = follower.step()
    assert state.jumped is None
    assert state.proven


def test_a_turned_obstacle_at_rest_is_no_jump(robot: Robot, rng: np.random.Generator) -> None:
    for _ in range(20):
        box = Box(center=(3.0, 8.0, 3.0), size=(1.0, 0.5, 0.3), rpy=tuple(rng.uniform(-3.0, 3.0, 3).tolist()))
        follower = Follower(robot, Scene(targets=AHEAD, obstacles=(box,)), dt=DT)
        for _ in range(3):
            state = follower.step()
            assert state.jumped is None
            assert state.proven


@pytest.mark.parametrize(("share", "jumps"), [(0.99, False), (1.01, True)])
def test_how_far_a_turn_takes_an_obstacle(robot: Robot, share: float, jumps: bool) -> None:
    """The corners of a box, 0.5 m from its centre, go 2 sin(angle / 2) 0.5 m."""
    speed, rpy = 0.4, np.array([0.5, -0.7, 1.1])
    angle = 2.0 * np.arcsin(share * speed * DT)
    after = pin.rpy.matrixToRpy(pin.exp3(angle * np.array([0.6, 0.0, 0.8])) @ pin.rpy.rpyToMatrix(*rpy))
    box = Box(center=(3.0, 8.0, 3.0), size=(0.48, 0.64, 0.6), rpy=tuple(rpy.tolist()))
    follower = Follower(robot, Scene(targets=AHEAD, obstacles=(box,)), dt=DT, obstacle_speed=speed)
    follower.step()
    follower.move_obstacle(0, box.center, after)
    assert (follower.step().jumped is not None) is jumps


def test_a_floor_that_sinks_lets_the_robot_move(robot: Robot) -> None:
    states = []
    for velocity in ((0.0, 0.0, 0.0), (0.0, 0.0, -0.1)):
        floor = HalfSpace(normal=(0.0, 0.0, 1.0), offset=-5.0, velocity=velocity)
        follower = Follower(robot, Scene(targets=AHEAD, obstacles=(floor,)), dt=DT)
        for _ in range(50):
            state = follower.step()
            assert state.proven
            assert state.jumped is None
        states.append(state)
    resting, sinking = states
    assert resting.velocity.any()
    np.testing.assert_array_equal(sinking.q, resting.q)


def test_a_floor_that_rises_is_kept_clear_of(robot: Robot) -> None:
    """The robot moves until the floor comes, and is at rest when it touches."""
    lowest, speed = float(Kinematics(robot, (level(0.0),)).measure(robot.initial).clearance.min()), 0.5
    follower = Follower(robot, Scene(targets=AHEAD, obstacles=(level(lowest - 0.5, speed),)), dt=DT)
    fastest, q = 0.0, robot.initial
    for cycle in range(130):
        state = follower.step()
        clear = Kinematics(robot, (level(lowest - 0.5 + speed * DT * cycle),)).measure(q).clearance.min()
        assert clear > 0.0 or not state.velocity.any()
        fastest, q = max(fastest, float(abs(state.velocity).max())), state.q
    assert clear < 0.0
    assert fastest > 0.1


def level(height: float, speed: float = 0.0) -> HalfSpace:
    return HalfSpace(normal=(0.0, 0.0, 1.0), offset=height, velocity=(0.0, 0.0, speed))


def test_late_reports_are_allowed_for(robot: Robot) -> None:
    """What is reported every tenth cycle is no jump where that was said, and one where it was not."""
    for latency, jumps in ((9 * DT, False), (0.0, True)):
        ball = Sphere(center=(3.0, 6.0, 3.0), radius=0.2)
        scene = Scene(targets=AHEAD, obstacles=(ball,))
        follower = Follower(robot, scene, dt=DT, obstacle_speed=0.5, obstacle_latency=latency)
        jumped = False
        for cycle in range(60):
            if cycle % 10 == 0:
                follower.move_obstacle(0, (3.0, 6.0 - 0.49 * cycle * DT, 3.0))
            jumped |= follower.step().jumped is not None
        assert jumped is jumps


def test_obstacles_move_on_by_their_velocity(robot: Robot) -> None:
    ball = Sphere(center=(-1.0, 2.0, 6.0), radius=0.2, velocity=(0.0, 0.0, -0.5))
    follower = Follower(robot, Scene(targets={"left": None, "right": AHEAD["right"]}, obstacles=(ball,)), dt=DT)
    before = robot.initial
    for cycle in range(300):
        state = follower.step()
        assert state.jumped is None
        there = Sphere(center=(-1.0, 2.0, 6.0 - 0.5 * DT * cycle), radius=0.2)
        if state.closest is not None and state.closest.other.startswith("obstacles"):
            expected = Kinematics(robot, (there,)).measure(before).clearance.min()
            assert state.closest.distance == pytest.approx(expected, abs=1e-9)
        before = state.q


def test_an_obstacle_is_moved_by_its_name(robot: Robot) -> None:
    balls = [Sphere(name=name, center=(3.0, 8.0 + i, 3.0), radius=0.2) for i, name in enumerate(("a", "b", "b"))]
    follower = Follower(robot, Scene(targets=AHEAD, obstacles=tuple(balls)))
    follower.step()
    follower.move_obstacle("a", (3.0, 8.0, 5.0))
    assert follower.step().jumped == "obstacles[0] (a)"
    with pytest.raises(InvalidInput, match="a name that one obstacle has"):
        follower.move_obstacle("b", (3.0, 8.0, 5.0))


def test_a_moved_obstacle_counts_as_one_that_was_there_from_the_start(robot: Robot, rng: np.random.Generator) -> None:
    """With its place, its turn and its velocity: the velocities are the same."""
    braked = 0
    for _ in range(4):
        *near, floor = around(robot, rng)
        near = [turned(o, np.zeros(3), rng.uniform(-0.15, 0.15, 3)) for o in near]  # by less than they are away
        drifts = [tuple(rng.uniform(-0.2, 0.2, 3).tolist()) for _ in near]
        there = [o.model_copy(update={"velocity": v}) for o, v in zip(near, drifts, strict=True)]
        away = [turned(o, np.array([0.0, 9.0, 0.0]), rng.normal(size=3)) for o in near]
        told, knew = (
            Follower(robot, Scene(targets=AHEAD, obstacles=(*some, floor)), dt=DT, obstacle_speed=0.5)
            for some in (away, there)
        )
        free = Follower(robot, Scene(targets=AHEAD, obstacles=(floor,)), dt=DT)
        for i, obstacle in enumerate(near):
            told.move_obstacle(i, obstacle.center, getattr(obstacle, "rpy", None), drifts[i])
        for _ in range(80):
            state, expected = told.step(), knew.step()
            np.testing.assert_allclose(state.velocity, expected.velocity, atol=1e-6)
            assert state.proven
        braked += not np.allclose(free_run(free, 80), state.q, atol=1e-3)
    assert braked > 1


def free_run(follower: Follower, cycles: int) -> np.ndarray:
    return [follower.step() for _ in range(cycles)][-1].q


def test_all_spheres_of_a_cloud_are_moved(robot: Robot, tmp_path: Path) -> None:
    """Distances after a move are those of the same cloud that was there from the start."""
    np.savez(tmp_path / "cloud.npz", points=np.random.default_rng(0).uniform(-0.5, 0.5, (40, 3)))
    hand = Kinematics(robot).hand_positions(robot.initial).reshape(-1, 3)[0]
    turn, there = (0.3, -0.2, 1.0), hand + np.array([-0.8, 0.0, 0.0])
    cloud = PointCloud(file=str(tmp_path / "cloud.npz"), radius=0.05, center=(-3.0, 8.0, 3.0))
    moved = cloud.model_copy(update={"center": tuple(there.tolist()), "rpy": turn})
    follower = Follower(robot, Scene(targets=AHEAD, obstacles=(cloud,)), dt=DT, obstacle_speed=1e4)
    follower.move_obstacle(0, there, turn)
    q = follower.state.q
    state = follower.step()
    assert state.closest is not None
    exact = float(Kinematics(robot, (moved,)).measure(q).clearance.min())
    assert 0.0 < exact < 0.3
    assert state.closest.distance == pytest.approx(exact, abs=1e-9)
