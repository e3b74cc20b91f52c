"""Obstacles that wander around a robot, no point of them faster than said, and a follower among them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pinocchio as pin
from conftest import AHEAD

from humanoid_rail import (
    Box,
    Capsule,
    Follower,
    FollowerState,
    Gains,
    HalfSpace,
    Kinematics,
    Robot,
    Safety,
    Scene,
    Sphere,
)
from humanoid_rail.scene.obstacles import Obstacle

DT = 0.01
SPEED = 0.4
"""No point of an obstacle is faster, m/s."""


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
