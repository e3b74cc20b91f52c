"""A follower keeps all limits, touches nothing while it moves, and has a stop that is what it says."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from conftest import AHEAD
from hulls import hulled

from humanoid_rail import (
    Box,
    Capsule,
    ConfigurationTask,
    Follower,
    FollowerState,
    FollowerStatus,
    Gains,
    HalfSpace,
    InvalidInput,
    Kinematics,
    PointTask,
    Robot,
    Safety,
    Scene,
    Sphere,
    State,
)
from humanoid_rail.scene.obstacles import Obstacle

DT = 0.01
SPEED = 0.4
"""No point of an obstacle is faster, m/s."""
ROBOTS = {"capsules": lambda robot: robot, "hulls": hulled}


@pytest.fixture(scope="module", params=ROBOTS)
def some_robot(request: pytest.FixtureRequest, robot: Robot) -> Robot:
    found: Robot = ROBOTS[request.param](robot)
    return found


def around(robot: Robot, rng: np.random.Generator) -> tuple[Obstacle, ...]:
    """Return obstacles around a robot's start, some 10 cm and more away from it."""
    kept: list[Obstacle] = []
    while len(kept) < 5:
        x, y, z = np.array([0.0, 2.0, 2.8]) + rng.uniform(-1.6, 1.6, 3)
        obstacle: Obstacle = Sphere(center=(x, y, z), radius=rng.uniform(0.1, 0.3))
        if len(kept) % 3 == 1:
            obstacle = Box(center=(x, y, z), size=(0.3, 0.1, 0.5))
        elif len(kept) % 3 == 2:
            obstacle = Capsule(center=(x, y, z), radius=0.1, length=0.5)
        if Kinematics(robot, (obstacle,)).measure(robot.initial).clearance.min() > 0.1:
            kept.append(obstacle)
    return (*kept, HalfSpace(normal=(0.0, 0.0, 1.0), offset=-0.5))


class Movers:
    """Obstacles that wander and turn, no point of them faster than they may be."""

    def __init__(self, obstacles: tuple[Obstacle, ...], rng: np.random.Generator) -> None:
        self.obstacles, self.rng = obstacles, rng
        self.moving = [i for i, obstacle in enumerate(obstacles) if not isinstance(obstacle, HalfSpace)]
        self.rates = {i: np.zeros(6) for i in self.moving}

    def move(self, dt: float) -> tuple[Obstacle, ...]:
        """Return where they are dt later, and have them turn elsewhere now and then."""
        after = list(self.obstacles)
        for i in self.moving:
            if self.rng.random() < 0.05 or not self.rates[i].any():
                # Points are within 0.4 m of the origin of an obstacle.
                linear, angular = (self.rng.normal(size=3) for _ in range(2))
                share = self.rng.uniform(0.3, 0.7)
                linear *= share * SPEED / np.linalg.norm(linear)
                angular *= (0.99 - share) * SPEED / 0.4 / np.linalg.norm(angular)
                self.rates[i] = np.concatenate([linear, angular])
            after[i] = turned(self.obstacles[i], *(dt * self.rates[i].reshape(2, 3)))
        self.obstacles = tuple(after)
        return self.obstacles


def turned(obstacle: Obstacle, by: np.ndarray, about: np.ndarray) -> Obstacle:
    """Return an obstacle elsewhere."""
    assert not isinstance(obstacle, HalfSpace)
    new: dict[str, object] = {"center": tuple(np.add(obstacle.center, by).tolist())}
    if not isinstance(obstacle, Sphere):
        rotation = pin.exp3(about) @ pin.rpy.rpyToMatrix(*obstacle.rpy)
        new["rpy"] = tuple(pin.rpy.matrixToRpy(rotation).tolist())
    return obstacle.model_copy(update=new)


def tell(follower: Follower, obstacles: tuple[Obstacle, ...]) -> None:
    for i, obstacle in enumerate(obstacles):
        if not isinstance(obstacle, HalfSpace):
            follower.move_obstacle(i, obstacle.center, getattr(obstacle, "rpy", None))


def wandering(
    robot: Robot, seed: int, cycles: int, dt: float = DT
) -> Iterator[tuple[Follower, FollowerState, tuple[Obstacle, ...]]]:
    """Reach into obstacles that wander, without shying; yield each state and where the obstacles were meanwhile."""
    rng = np.random.default_rng(seed)
    movers = Movers(around(robot, rng), rng)
    scene = Scene(name="some", targets=AHEAD, obstacles=movers.obstacles)
    hasty, close = Gains(2.0, c_kappa=0.0), Safety(damper_gain=10.0)
    follower = Follower(robot, scene, dt=dt, gains=hasty, safety=close, obstacle_speed=SPEED)
    for cycle in range(cycles):
        if cycle % 60 == 0:
            inside = [movers.obstacles[i] for i in rng.choice(movers.moving, len(robot.hand_names))]
            follower.set_targets({hand: o.center for hand, o in zip(robot.hand_names, inside, strict=True)})
        there = movers.obstacles
        tell(follower, there)
        yield follower, follower.step(), there
        movers.move(dt)


@pytest.mark.parametrize("seed", [0, 1])
def test_limits_hold_and_nothing_touches_while_it_moves(some_robot: Robot, seed: int) -> None:
    """In every cycle; contact is looked for by the Python kinematics, at three moments of it."""
    robot, seen = some_robot, set[FollowerStatus]()
    q, v, moved = robot.initial, np.zeros(robot.n), 0.0
    for follower, state, there in wandering(robot, seed, 250):
        seen.add(state.status)
        assert state.jumped is None
        assert state.proven
        np.testing.assert_allclose(state.q, q + DT * state.velocity, atol=1e-12)
        assert (abs(state.velocity) <= robot.velocity_limit * (1 + 1e-9)).all()
        assert (abs(state.velocity - v) <= follower.acceleration_limit * DT * (1 + 1e-6) + 1e-12).all()
        assert (state.q >= robot.lower).all()
        assert (state.q <= robot.upper).all()
        assert (state.stop >= robot.lower - 1e-9).all()
        assert (state.stop <= robot.upper + 1e-9).all()
        if state.velocity.any():
            for share in (0.0, 0.5, 1.0):
                clear = Kinematics(robot, there).measure(q + share * DT * state.velocity)
                assert clear.clearance.min() > share * DT * SPEED  # obstacles get so far in that time
                assert clear.self_clearance.min() > 0.0
        moved += float(abs(state.q - q).max())
        q, v = state.q, state.velocity
    assert moved > 1.0
    assert seen >= {FollowerStatus.FOLLOWING, FollowerStatus.BRAKING}


def test_a_stop_is_what_it_says(some_robot: Robot) -> None:
    """Wherever it is told to, a robot brakes along the line that was proven, to where it was said, in the time said."""
    robot, tried = some_robot, 0
    for cycles in range(20, 200, 30):
        *_, (follower, state, there) = wandering(robot, cycles, cycles)
        if state.time_to_rest < 3 * DT:
            continue
        tried += 1
        promised, v, first = state, state.velocity, state
        for _ in range(round(promised.time_to_rest / DT)):
            assert state.velocity.any()
            tell(follower, there)
            q = state.q
            state = follower.step(brake=True)
            assert (abs(state.velocity - v) <= follower.acceleration_limit * DT * (1 + 1e-6) + 1e-12).all()
            left, whole = promised.stop - state.q, promised.stop - first.q
            np.testing.assert_allclose(left, (left @ whole) / (whole @ whole) * whole, atol=1e-9)
            np.testing.assert_allclose(state.stop, promised.stop, atol=1e-9)
            assert Kinematics(robot, there).measure(0.5 * (q + state.q)).clearance.min() > 0.0
            v = state.velocity
        assert not state.velocity.any()
        assert state.status is FollowerStatus.STOPPED or state.error <= 0.01
        np.testing.assert_allclose(state.q, promised.stop, atol=1e-9)
    assert tried >= 2


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


def test_the_safety_distance_is_kept_from_what_rests(robot: Robot, rng: np.random.Generator) -> None:
    for _ in range(3):
        obstacles = around(robot, rng)
        follower = Follower(robot, Scene(targets=AHEAD, obstacles=obstacles), dt=DT, safety=Safety(0.05))
        for _ in range(250):
            state = follower.step()
            assert Kinematics(robot, obstacles).measure(state.q).clearance.min() > 0.05 - 1e-6


def test_a_joint_speeds_up_as_its_limit_allows(robot: Robot) -> None:
    """Analytically: a dt more in each cycle until K e is less, then exponentially to the target."""
    follower = Follower(robot, Scene(targets=AHEAD), dt=DT, gains=Gains(c_mu=0.0), tolerance=1e-3)
    target = float(robot.initial[0]) + 0.3
    others = [name for name in robot.joint_names if name != "rail"]
    rest = [float(x) for name, x in zip(robot.joint_names, robot.initial, strict=True) if name != "rail"]
    follower.set_tasks([ConfigurationTask(("rail",), (target,)), ConfigurationTask(tuple(others), tuple(rest))])
    rail, expected, q = robot.joint_names.index("rail"), 0.0, float(robot.initial[0])
    assert rail == 0
    for _ in range(700):
        state = follower.step()
        expected = min(expected + DT * float(follower.acceleration_limit[0]), target - q, robot.velocity_limit[0])
        assert state.velocity[0] == pytest.approx(expected, abs=2e-6)
        q = float(state.q[0])
        expected = float(state.velocity[0])
        assert q < target
    assert state.status is FollowerStatus.REACHED
    assert "|e| is" in state.reason


def test_two_runs_are_the_same(some_robot: Robot) -> None:
    one, other = ([state for _, state, _ in wandering(some_robot, 5, 80)] for _ in range(2))
    for a, b in zip(one, other, strict=True):
        assert a.q.tobytes() == b.q.tobytes()
        assert a.velocity.tobytes() == b.velocity.tobytes()
        assert a.reason == b.reason


def test_out_of_reach_it_comes_to_rest(robot: Robot) -> None:
    """Stretched out, where small moves of the hands take large ones of the joints."""
    scene = Scene(targets={"left": (0.0, 2.0, 9.0), "right": (0.0, 2.2, 9.0)})
    follower = Follower(robot, scene, dt=0.002, gains=Gains(c_mu=0.0))
    speeds = []
    for _ in range(4000):
        state = follower.step()
        assert state.proven
        speeds.append(float((abs(state.velocity) / robot.velocity_limit).max()))
    assert max(speeds) > 0.3
    assert max(speeds[-100:]) < 0.05
    assert state.error > 1.0


def test_a_jump_is_reported_and_ends_in_a_stop(robot: Robot) -> None:
    hand = Kinematics(robot).hand_positions(robot.initial).reshape(-1, 3)[0]
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


def test_a_start_in_contact_is_refused(robot: Robot, folded_q: np.ndarray) -> None:
    hand = tuple(Kinematics(robot).hand_positions(robot.initial).reshape(-1, 3)[0].tolist())
    with pytest.raises(InvalidInput, match=r"start is .* nothing touches: .* is inside obstacles\[0\] \(sphere\)"):
        Follower(robot, Scene(targets=AHEAD, obstacles=(Sphere(center=hand, radius=0.1),)))
    with pytest.raises(InvalidInput, match=r"start is .* nothing touches"):
        Follower(robot, Scene(targets=AHEAD), start=folded_q)


def objective(state: State) -> np.ndarray:
    return np.zeros(state.q.size)


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"dt": 0.0}, "dt"),
        ({"dt": 1.0}, "dt"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"start": [0.0]}, "start"),
        ({"start": np.full(12, 100.0)}, "start[0] (rail)"),
        ({"acceleration_limit": -1.0}, "acceleration_limit (rail)"),
        ({"acceleration_limit": [1.0, 2.0]}, "acceleration_limit"),
        ({"obstacle_speed": -1.0}, "obstacle_speed"),
        ({"obstacle_speed": 0.1}, "obstacle_speed"),
        ({"obstacle_speed": [1.0, 1.0]}, "obstacle_speed"),
        ({"obstacle_latency": -1.0}, "obstacle_latency"),
        ({"gains": Gains(objectives=[objective])}, "gains.objectives"),
        ({"safety": Safety(equalities=[lambda state: (state.jacobian, np.zeros(6))])}, "safety.equalities"),
    ],
)
def test_what_cannot_be_used_is_named(robot: Robot, arguments: dict[str, object], field: str) -> None:
    ball = Sphere(center=(3.0, 8.0, 3.0), radius=0.2, velocity=(0.2, 0.0, 0.0))
    with pytest.raises(InvalidInput) as raised:
        Follower(robot, Scene(targets=AHEAD, obstacles=(ball,)), **arguments)  # type: ignore[arg-type]
    assert raised.value.field == field


def test_what_cannot_be_followed_is_named(robot: Robot) -> None:
    class Own(PointTask):
        pass

    floor = HalfSpace(normal=(0.0, 0.0, 1.0), offset=-0.5)
    follower = Follower(robot, Scene(targets=AHEAD, obstacles=(floor,)))
    for call, field in (
        (lambda: follower.set_targets({"left": (1.0, 2.0, 3.0)}), "targets.right"),
        (lambda: follower.set_targets({"left": None, "right": None}), "targets"),
        (lambda: follower.set_tasks([]), "tasks"),
        (lambda: follower.set_tasks([Own("left", (1.0, 2.0, 3.0))]), "tasks[0]"),
        (lambda: follower.move_obstacle(1, (0.0, 0.0, 0.0)), "obstacle"),
        (lambda: follower.move_obstacle(0, (0.0, 0.0, 0.0)), "obstacle"),
        (lambda: follower.move_obstacle("ball", (0.0, 0.0, 0.0)), "obstacle"),
    ):
        with pytest.raises(InvalidInput) as raised:
            call()
        assert raised.value.field == field


def test_limits_that_are_missing_are_named(robot: Robot) -> None:
    without = replace(robot, acceleration_limit=np.full(robot.n, np.inf))
    with pytest.raises(InvalidInput, match=r"acceleration_limit \(rail\) is inf"):
        Follower(without, Scene(targets=AHEAD))
    assert Follower(without, Scene(targets=AHEAD), acceleration_limit=2.0).step().proven


def test_an_obstacle_is_moved_by_its_name(robot: Robot) -> None:
    balls = [Sphere(name=name, center=(3.0, 8.0 + i, 3.0), radius=0.2) for i, name in enumerate(("a", "b", "b"))]
    follower = Follower(robot, Scene(targets=AHEAD, obstacles=tuple(balls)))
    follower.step()
    follower.move_obstacle("a", (3.0, 8.0, 5.0))
    assert follower.step().jumped == "obstacles[0] (a)"
    with pytest.raises(InvalidInput, match="a name that one obstacle has"):
        follower.move_obstacle("b", (3.0, 8.0, 5.0))
