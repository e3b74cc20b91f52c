"""Measures the cycles of a follower while its targets and obstacles move at random."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from humanoid_rail._arrays import Array, triple
from humanoid_rail.following.follower import Follower
from humanoid_rail.following.state import CycleTimes, FollowerStatus
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.model.library import load_robot
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import Box, Capsule, Sphere
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.targets import Target

REPORTS = 30.0
"""Obstacles are moved this often, 1/s, as a hand in a browser or a camera would."""
SPEED = 0.3
"""How fast they are at most, m/s."""
COUNT = 6
"""There are so many."""
NEW_TARGETS = 6.0
"""The targets move this often, s."""
LOW, HIGH = np.array([-2.0, 0.0, 1.5]), np.array([2.0, 4.0, 4.5])
"""Obstacles and targets are between these points, m."""


@dataclass(frozen=True)
class Following:
    """What a follower did, and how long its cycles took."""

    what: str
    """The robot and the obstacles."""
    seconds: float
    """How long it followed, s."""
    times: CycleTimes
    """Of its thread."""
    moved: float
    """How far the joints moved, the sum of |q_dot| dt over the states that were looked at, m and rad."""
    reached: int
    """In how many of the states that were looked at the targets were reached."""
    unproven: int
    """In how many no stop was proven."""
    touching: int
    """In how many a moving robot touched something."""
    looked: int
    """At how many states was looked."""


def measure_following(seconds: float) -> Iterator[Following]:
    """Follow for so long with the paper's robot, s, among obstacles that move at random."""
    yield follow_for(load_robot(), f"the paper's robot, {COUNT} obstacles", seconds, np.random.default_rng(0))


def follow_for(robot: Robot, what: str, seconds: float, random: np.random.Generator) -> Following:
    """Follow random targets for so long, s."""
    obstacles = _around(robot, random)
    scene = Scene(name="following", targets=_targets(robot, random), obstacles=obstacles)
    follower = Follower(robot, scene, obstacle_speed=SPEED, obstacle_latency=4.0 / REPORTS)
    centers = np.array([obstacle.center for obstacle in obstacles])
    velocities = _velocities(random)
    moved, reached, unproven, touching, looked = 0.0, 0, 0, 0, 0
    with follower:
        began = last = time.perf_counter()
        changed = began
        while (now := time.perf_counter()) - began < seconds:
            centers += velocities * min(now - last, 2.0 / REPORTS)
            last = now
            outside = (centers < LOW) | (centers > HIGH)
            velocities[outside] = abs(velocities[outside]) * np.sign((LOW + HIGH) / 2 - centers)[outside]
            if now - changed > NEW_TARGETS:
                changed, velocities = now, _velocities(random)
                follower.set_targets(_targets(robot, random))
            for i, center in enumerate(centers):
                follower.move_obstacle(i, center)
            state = follower.state
            looked += 1
            reached += state.status is FollowerStatus.REACHED
            unproven += not state.proven
            touching += bool(state.velocity.any()) and state.closest is not None and state.closest.distance < 0.0
            moved += float(abs(state.velocity).sum()) / REPORTS
            time.sleep(max(0.0, 1.0 / REPORTS - (time.perf_counter() - now)))
    return Following(what, seconds, follower.cycle_times, moved, reached, unproven, touching, looked)


def _targets(robot: Robot, random: np.random.Generator) -> dict[str, Target]:
    return {hand: triple(random.uniform(LOW, HIGH)) for hand in robot.hand_names}


def _velocities(random: np.random.Generator) -> Array:
    directions = random.normal(size=(COUNT, 3))
    scale: Array = 0.95 * SPEED * random.uniform(0.2, 1.0, (COUNT, 1))
    velocities: Array = scale * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return velocities


def _around(robot: Robot, random: np.random.Generator) -> tuple[Sphere | Box | Capsule, ...]:
    """Return obstacles that do not touch the robot at its start."""
    kept: list[Sphere | Box | Capsule] = []
    while len(kept) < COUNT:
        x, y, z = random.uniform(LOW, HIGH).tolist()
        kinds: tuple[Sphere | Box | Capsule, ...] = (
            Sphere(center=(x, y, z), radius=0.2),
            Box(center=(x, y, z), size=(0.3, 0.2, 0.5)),
            Capsule(center=(x, y, z), radius=0.1, length=0.6),
        )
        obstacle = kinds[len(kept) % len(kinds)]
        if Kinematics(robot, (obstacle,)).measure(robot.initial).clearance.min() > 0.2:
            kept.append(obstacle)
    return tuple(kept)
