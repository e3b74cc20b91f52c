"""Random motions of the robot among random obstacles, planned and not, many of them near to contact.

The seed and a motion's number determine the motion. What is clear of what is by plain geometry.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import count
from math import pi
from typing import Any

import numpy as np

from humanoid_rail import (
    Box,
    Capsule,
    Certificate,
    GradientProjection,
    HalfSpace,
    Robot,
    SafeVelocity,
    Scene,
    Sphere,
    load_robot,
    plan,
)
from humanoid_rail._arrays import Array, triple
from humanoid_rail.scene.obstacles import Obstacle
from validation.plain_geometry import (
    LINKS,
    PAIRS,
    RADIUS,
    Course,
    bones,
    clearance,
    configuration,
    follow,
    segment_segment,
)

QP, GRADIENT_PROJECTION = "qp", "eq. 4.9"
ELSEWHERE, NEAR = "elsewhere", "near miss"
KINDS = (QP, GRADIENT_PROJECTION, ELSEWHERE, NEAR)
"""The kinds of motions are those of two planning methods, motions that were not planned, and near misses."""
START = 1e-3
"""Starts are clear of obstacles by at least this, m."""
MISS = (1e-4, 5e-3)
"""Near misses are this near to contact, on either side, m."""
CLOSELY = 1e-5
"""A near miss is as near as it should be to within this, m."""
PROBE = 1e-6
"""An obstacle is moved by this to see where its clearance grows, m."""
ATTEMPTS = 10
"""A miss between samples is looked for this often, as there may be none."""
COARSE = 10
"""While a near miss is made, the motion is looked at this many times finer than its samples."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion that is linear in q between its samples, among obstacles."""

    kind: str
    t: Array
    """(N,), s."""
    q: Array
    """(N, 12), m and rad."""
    obstacles: tuple[Obstacle, ...]
    certificate: Certificate | None = None
    """The planner's, if it made the motion."""

    def follow(self, finer: int) -> Course:
        """Return where the bones are, so many times finer than the samples or finer still."""
        speed = max((float(np.linalg.norm(obstacle.velocity)) for obstacle in self.obstacles), default=0.0)
        return follow(self.t, self.q, finer, speed)


def make_motion(seed: int, index: int) -> Motion:
    """Return the motion of a number, its kind by turns."""
    rng = np.random.default_rng([seed, index])
    start = random_start(rng)
    obstacles = random_obstacles(rng, start)
    kind = KINDS[index % len(KINDS)]
    base = str(rng.choice(KINDS[:-1], p=[0.2, 0.2, 0.6])) if kind == NEAR else kind
    motion = elsewhere(rng, start, obstacles) if base == ELSEWHERE else planned(rng, base, start, obstacles)
    return near_miss(rng, motion) if kind == NEAR else motion


@cache
def robot() -> Robot:
    """Return the robot, with links of the thickness that plain geometry has."""
    return load_robot(link_radius=RADIUS)


def scene_of(obstacles: tuple[Obstacle, ...], **fields: object) -> Scene:
    """Return a scene with obstacles."""
    return Scene.model_validate({"name": "random", "targets": {}, "obstacles": obstacles, **fields})


def random_start(rng: np.random.Generator) -> Array:
    """Return a configuration (12,) within the limits in which links are clear of each other."""
    while True:
        q = rng.uniform(robot().lower, robot().upper)
        if links_are_apart(q):
            return q


def links_are_apart(q: Array) -> bool:
    """Whether links are clear of each other, by a little, in a configuration (12,)."""
    (one, other), ends = np.array(PAIRS).T, bones(q)
    return bool(segment_segment(ends[one], ends[other]).min() > 2.0 * (RADIUS + MISS[1]))


def random_obstacles(rng: np.random.Generator, start: Array) -> tuple[Obstacle, ...]:
    """Return 2 to 12 obstacles where the links could get from a start (12,) that is clear of them all."""
    obstacles: list[Obstacle] = []
    number = rng.integers(2, 13)
    while len(obstacles) < number:
        place = rng.choice(bones(start + rng.normal(0.0, 0.5, start.size)).reshape(-1, 3))
        obstacle = random_obstacle(rng, place + rng.normal(0.0, 0.3, 3), bones(start).mean(axis=(0, 1)))
        if clearance(obstacle, np.zeros(1), bones(start)).min() > START:
            obstacles.append(obstacle)
    return tuple(obstacles)


def random_obstacle(rng: np.random.Generator, place: Array, middle: Array) -> Obstacle:
    """Return an obstacle at a place (3,); a half-space has the middle (3,) of the robot outside. Three in ten move."""
    velocity = triple(rng.uniform(-0.3, 0.3, 3) * (rng.random() < 0.3))
    center, rpy = triple(place), triple(rng.uniform(-pi, pi, 3))
    match rng.choice(4, p=[0.3, 0.3, 0.25, 0.15]):
        case 0:
            return Sphere(center=center, radius=rng.uniform(0.03, 0.4), velocity=velocity)
        case 1:
            return Box(center=center, size=triple(np.exp(rng.uniform(-4.0, 0.3, 3))), rpy=rpy, velocity=velocity)
        case 2:
            radius, length = rng.uniform(0.02, 0.2), rng.uniform(0.05, 1.5)
            return Capsule(center=center, radius=radius, length=length, rpy=rpy, velocity=velocity)
        case _:
            # A floor, or a wall of any slope; its normal not of length 1.
            normal = np.array([0.0, 0.0, 1.0]) if rng.random() < 0.3 else middle - place
            return HalfSpace(normal=triple(normal), offset=float(normal @ place), velocity=velocity)


def planned(rng: np.random.Generator, kind: str, start: Array, obstacles: tuple[Obstacle, ...]) -> Motion:
    """Return a motion of the planner that takes the hands to where they are in another configuration."""
    ends = bones(np.clip(start + rng.normal(0.0, 0.6, start.size), robot().lower, robot().upper))
    targets = {side: ends[LINKS.index(f"{side}_forearm"), 1] for side in ("left", "right")}
    c_kappa, distance = float(rng.choice([0.0, 1.0])), float(rng.choice([0.0, 1e-3, 1e-2, 5e-2]))
    trajectory = plan(
        robot(),
        scene_of(obstacles, initial=start, targets=targets),
        method_of(kind, c_kappa, distance),
    )
    return Motion(kind, trajectory.t, trajectory.q, obstacles, trajectory.certificate)


def method_of(kind: str, c_kappa: float, safety_distance: float) -> SafeVelocity | GradientProjection:
    """Return the method that makes motions of a kind; gradient projection keeps no distance."""
    common: dict[str, Any] = {"gain": 3.0, "c_kappa": c_kappa, "epsilon": 0.5, "dt": 0.02, "max_time": 3.0}
    if kind == QP:
        return SafeVelocity(safety_distance=safety_distance, **common)
    assert kind == GRADIENT_PROJECTION, kind
    return GradientProjection(**common)


def elsewhere(rng: np.random.Generator, start: Array, obstacles: tuple[Obstacle, ...]) -> Motion:
    """Return a motion of few steps, small ones or so large that much happens within each.

    At its samples links are clear of each other.
    """
    steps = rng.integers(2, 6)
    size = np.exp(rng.uniform(np.log(0.03), np.log(1.5)))
    q = [start]
    while len(q) <= steps:
        to = q[-1] + rng.normal(0.0, size, start.size)
        if links_are_apart(to):
            q.append(to)
    return Motion(ELSEWHERE, np.cumsum([0.0, *rng.uniform(0.2, 1.5, steps)]), np.array(q), obstacles)


def near_miss(rng: np.random.Generator, motion: Motion) -> Motion:
    """Return a motion that misses something by next to nothing, or does not quite miss it.

    An obstacle is moved up to the given motion, and those that it touches are left out. Where its links touch each
    other it is replaced by one in which they hardly do.
    """
    miss = float(np.exp(rng.uniform(*np.log(MISS))) * rng.choice([-1.0, 1.0]))
    of_links = motion.follow(COARSE).between_links(MISS[1]).min() <= MISS[1]
    if of_links:
        t, q = links_passing(rng, miss)
        motion = replace(motion, t=t, q=q)
    course = motion.follow(COARSE)
    free = tuple(o for o in motion.obstacles if course.from_obstacle(o, MISS[1]).min() > MISS[1])
    obstacles = free if of_links else (*free, moved_up(rng, course, miss, motion.t))
    return replace(motion, kind=NEAR, obstacles=obstacles, certificate=None)


def links_passing(rng: np.random.Generator, miss: float) -> tuple[Array, Array]:
    """Return times (2,), s, and configurations (2, 12) of a step in which links miss each other by about `miss`, m.

    If possible they do so between its ends.
    """
    t = np.array([0.0, rng.uniform(0.2, 1.5)])
    for attempt in count():
        middle = random_start(rng)
        step = rng.normal(0.0, np.exp(rng.uniform(np.log(0.03), np.log(0.5))), middle.size)
        for _ in range(20):
            q = np.array([middle - step, middle + step])
            course = follow(t, q, COARSE)
            apart = course.between_links(-np.inf)
            k, pair = np.unravel_index(apart.argmin(), apart.shape)
            if abs(apart[k, pair] - miss) < CLOSELY and (attempt > ATTEMPTS or course.t[k] not in t):
                return t, q
            # Shifted to where they are as near as they should be, and turned so that they get no nearer.
            direction = links_direction(configuration(t, q, course.t[k]), PAIRS[pair])
            middle = middle + direction * (miss - apart[k, pair])
            step = step - direction * (step @ direction) / max(float(direction @ direction), PROBE)
    raise AssertionError


def links_direction(q: Array, pair: tuple[int, int]) -> Array:
    """Return the change (12,) of a configuration, m and rad, by which two links get apart by 1 m, to first order."""
    ends = bones(q + PROBE * np.vstack([np.eye(q.size), -np.eye(q.size)]))
    ahead, behind = segment_segment(ends[:, pair[0]], ends[:, pair[1]]).reshape(2, -1)
    gradient = (ahead - behind) / (2.0 * PROBE)
    direction: Array = gradient / max(float(gradient @ gradient), PROBE)
    return direction


def moved_up(rng: np.random.Generator, course: Course, miss: float, samples: Array) -> Obstacle:
    """Return an obstacle whose least clearance on a course is about `miss`, m; if possible between the samples."""
    for attempt in count():
        place = rng.choice(course.bones[rng.integers(len(course.t))].reshape(-1, 3))
        obstacle = random_obstacle(rng, place + rng.normal(0.0, 0.4, 3), course.bones[0].mean(axis=(0, 1)))
        for _ in range(12):
            apart = course.from_obstacle(obstacle, -np.inf)
            k, link = np.unravel_index(apart.argmin(), apart.shape)
            if abs(apart[k, link] - miss) < CLOSELY and (attempt > ATTEMPTS or course.t[k] not in samples):
                return obstacle
            # Towards or away from the bone that is nearest.
            at = partial(clearance, t=course.t[k], segment=course.bones[k, link])
            ahead = [at(moved(obstacle, step)) - at(moved(obstacle, -step)) for step in PROBE * np.eye(3)]
            obstacle = moved(obstacle, np.array(ahead) / (2.0 * PROBE) * (miss - apart[k, link]))
    raise AssertionError


def moved(obstacle: Obstacle, by: Array) -> Obstacle:
    """Return an obstacle that has been moved (3,), m."""
    if isinstance(obstacle, HalfSpace):
        return obstacle.model_copy(update={"offset": obstacle.offset + float(np.dot(obstacle.normal, by))})
    return obstacle.model_copy(update={"center": triple(np.array(obstacle.center) + by)})
