"""Random motions on which hands grasp, carry and release random objects among random obstacles, many near to contact.

The seed and a motion's number determine the motion. Hands may grasp from any distance: certificates believe that.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from functools import cache
from math import pi
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull

from humanoid_rail import Box, Capsule, Mesh, Sphere, Timing
from humanoid_rail._arrays import Array, triple
from humanoid_rail.events import Event
from humanoid_rail.paper import dh_table as dh
from humanoid_rail.scene.obstacles import HalfSpace, Obstacle, is_moving, name_of
from validation.held_course import HANDS, HeldMotion, hand_frame, parts
from validation.held_geometry import Body, clearances, distance, obstacle_body
from validation.plain_geometry import LINKS, RADIUS, clearance
from validation.random_motions import MISS, PROBE, START, links_are_apart, random_obstacle, random_start

LINEAR, CUBIC, TWO, NEAR = "linear", "cubic", "two hands", "near miss"
KINDS = (LINEAR, CUBIC, TWO, NEAR)
"""The kinds of motions: one object on straight or cubic motions, one in each hand or in both, and near misses."""
SHAPES = 12
"""So many meshes there are."""
COARSE = 10
"""While a near miss is made, the motion is looked at this many times finer than its samples."""


def make_motion(seed: int, index: int) -> HeldMotion:
    """Return the motion of a number, its kind by turns."""
    rng = np.random.default_rng([seed, index])
    kind = KINDS[index % len(KINDS)]
    motion = _samples(rng, kind)
    motion = _with_objects(rng, motion)
    start = dh_bones(motion.q[0])
    number, obstacles = rng.integers(1, 5), list[Obstacle]()
    while len(obstacles) < number:
        place = rng.choice(start.reshape(-1, 3)) + rng.normal(0.0, 0.6, 3)
        obstacle = random_obstacle(rng, place, start.mean(axis=(0, 1)))
        if clearance(obstacle, np.zeros(1), start).min() > START:
            obstacles.append(obstacle)
    motion = replace(motion, obstacles=tuple(obstacles))
    if kind == NEAR:
        motion = _near_miss(rng, motion)
    return replace(motion, events=_with_contacts(rng, motion))


def dh_bones(q: Array) -> Array:
    """Return the end points (9, 2, 3) of the bones at a configuration (12,), m."""
    return np.stack(list(dh.bones(q).values()), axis=-3)


def _samples(rng: np.random.Generator, kind: str) -> HeldMotion:
    steps, size, q = rng.integers(2, 6), np.exp(rng.uniform(np.log(0.03), np.log(0.6))), [random_start(rng)]
    while len(q) <= steps:
        to = q[-1] + rng.normal(0.0, size, 12)
        if links_are_apart(to):
            q.append(to)
    t = np.cumsum([0.0, *rng.uniform(0.2, 1.5, steps)])
    timing = None
    if kind == CUBIC or (kind != LINEAR and rng.random() < 0.5):
        velocity = rng.normal(0.0, size, (steps + 1, 12))
        velocity[[0, -1]] = 0.0
        timing = Timing(velocity, np.zeros_like(velocity), ())
    return HeldMotion(kind, t, np.array(q), timing, (), (), ())


def _with_objects(rng: np.random.Generator, motion: HeldMotion) -> HeldMotion:
    """Return a motion with what hands grasp, carry and release, and sometimes what only stands there."""
    grips: list[tuple[str, ...]] = [(str(rng.choice(list(HANDS))),)]
    if motion.kind == TWO:
        grips = [("left",), ("right",)] if rng.random() < 0.8 else [("left", "right")]
    objects, events = list[Obstacle](), list[Event]()
    for number, hands in enumerate(grips):
        name, times = f"part {number}", _times(rng, motion)
        _, tip = hand_frame(motion.configuration(times[1:2]), hands[0])
        outwards = dh_bones(motion.configuration(times[1:2])[0])[LINKS.index(HANDS[hands[0]][0])]
        along = (outwards[1] - outwards[0]) / np.linalg.norm(outwards[1] - outwards[0])
        objects.append(_object(rng, name, tip[0], along))
        near = hands if rng.random() < 0.9 else ()
        events += [
            _event(times[0], "approach", name, hands, near),
            _event(times[1], "grasp", name, hands, ()),
            _event(times[2], "approach", name, hands, ()),
            _event(times[3], "release", name, hands, near),
            _event(times[4], "clear", name, hands, ()),
        ][: rng.choice([2, 3, 5, 5, 5])]
    if rng.random() < 0.3:
        far = motion.q[0] + rng.normal(0.0, 0.5, 12)
        objects.append(_object(rng, "standing", rng.choice(dh_bones(far).reshape(-1, 3)), rng.normal(size=3)))
    return replace(motion, objects=tuple(objects), events=tuple(sorted(events, key=lambda event: event.t)))


def _times(rng: np.random.Generator, motion: HeldMotion) -> Array:
    """Return the times of events (5,), s: at samples as often as not, some at once, some at the ends."""
    times = np.sort(rng.uniform(motion.t[0], motion.t[-1], 5))
    at_samples = np.sort(rng.choice(motion.t, 5))
    times = np.sort(np.where(rng.random(5) < 0.5, at_samples, times))
    if rng.random() < 0.5:
        times[0] = motion.t[0]
    if times[1] == times[3]:  # what is grasped is released later
        times[3:] = motion.t[-1]
    return times


def _event(t: float, kind: str, name: str, hands: tuple[str, ...], contacts: tuple[str, ...]) -> Event:
    """Return an event. Where the object is then is not believed: it is said wrongly."""
    return Event(float(t), kind, name, hands, (9.0, 9.0, 9.0), (1.0, 0.0, 0.0, 0.0), contacts)


def _object(rng: np.random.Generator, name: str, tip: Array, along: Array) -> Obstacle:
    """Return an object ahead of a hand with its point (3,), which points along a unit vector (3,)."""
    rpy, size = triple(rng.uniform(-pi, pi, 3)), np.exp(rng.uniform(-3.5, -1.2))
    center = triple(tip + along * (RADIUS + size) * rng.uniform(0.5, 1.6) + rng.normal(0.0, 0.02, 3))
    match rng.choice(4):
        case 0:
            return Sphere(name=name, center=center, radius=0.5 * size)
        case 1:
            return Capsule(name=name, center=center, radius=0.3 * size, length=size * rng.uniform(0.5, 3.0), rpy=rpy)
        case 2:
            return Box(name=name, center=center, size=triple(size * rng.uniform(0.2, 1.6, 3)), rpy=rpy)
    file = mesh_file(int(rng.integers(SHAPES)))
    return Mesh(name=name, file=file, center=center, rpy=rpy, scale=triple(size * rng.uniform(0.4, 1.0, 3)))


@cache
def mesh_file(number: int) -> str:
    """Return the file of a convex mesh whose corners are about 1 from its origin."""
    rng = np.random.default_rng([17, number])
    corners = rng.normal(size=(int(rng.integers(4, 10)), 3))
    corners /= np.linalg.norm(corners, axis=1)[:, None] * rng.uniform(1.0, 1.5, (len(corners), 1))
    hull = ConvexHull(corners)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in corners.tolist()]
    for simplex, equation in zip(hull.simplices, hull.equations, strict=True):
        a, b, c = corners[simplex]
        i, j, k = simplex if np.cross(b - a, c - a) @ equation[:3] > 0.0 else simplex[::-1]
        lines.append(f"f {i + 1} {j + 1} {k + 1}")
    path = Path(_folder()) / f"{number}.obj"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return str(path)


@cache
def _folder() -> str:
    return tempfile.mkdtemp(prefix="held-")


def _near_miss(rng: np.random.Generator, motion: HeldMotion) -> HeldMotion:
    """Return a motion on which a held object misses an obstacle by next to nothing, or does not quite miss it.

    The obstacle is one of those there are, moved; those that the object touches are left out.
    """
    held = [part for part in parts(motion, COARSE) if part.bodies[str(motion.objects[0].name)].edges.shape[0] > 1]
    if not held:
        return motion
    name, part = str(motion.objects[0].name), held[0]
    carried, count = part.bodies[name], len(part.t)
    miss = float(np.exp(rng.uniform(*np.log(MISS))) * rng.choice([-1.0, 1.0]))
    obstacle = motion.obstacles[0]
    place = carried.edges[rng.integers(count), 0, 0] + rng.normal(0.0, 0.3, 3)
    if not isinstance(obstacle, HalfSpace):
        obstacle = obstacle.model_copy(update={"center": triple(place)})
    for _ in range(8):
        body = obstacle_body(obstacle, part.t)
        apart = clearances(carried, body, count, MISS[1])
        k = int(apart.argmin())
        if abs(apart[k] - miss) < 1e-4:
            break
        gradient = np.array([_ahead(carried, obstacle, part.t, k, step) for step in PROBE * np.eye(3)])
        length = float(gradient @ gradient)
        if length < 0.1:  # deep inside
            gradient, length = rng.normal(size=3), 1.0
        obstacle = _moved(obstacle, gradient / length * (miss - apart[k]))
    free = [o for o in motion.obstacles[1:] if clearances(carried, obstacle_body(o, part.t), count, 0.0).min() > 0.0]
    return replace(motion, obstacles=(obstacle, *free))


def _ahead(carried: Body, obstacle: Obstacle, t: Array, k: int, step: Array) -> float:
    at = np.array([k])
    ahead, behind = (distance(carried.at(at), obstacle_body(_moved(obstacle, by), t).at(at)) for by in (step, -step))
    return float(ahead[0] - behind[0]) / (2.0 * PROBE)


def _moved(obstacle: Obstacle, by: Array) -> Obstacle:
    if isinstance(obstacle, HalfSpace):
        return obstacle.model_copy(update={"offset": obstacle.offset + float(np.dot(obstacle.normal, by))})
    return obstacle.model_copy(update={"center": triple(np.array(obstacle.center) + by)})


def _with_contacts(rng: np.random.Generator, motion: HeldMotion) -> tuple[Event, ...]:
    """Return the events of a motion with further contacts that are allowed: obstacles and other objects."""
    others = [str(one.name) for one in motion.objects]
    for i, obstacle in enumerate(motion.obstacles):
        if not isinstance(obstacle, HalfSpace) and not is_moving(obstacle):
            others.append(name_of(motion.obstacles, i))
    found = list[Event]()
    for event in motion.events:
        more = [name for name in others if name != event.object and rng.random() < 0.25]
        found.append(replace(event, contacts=(*event.contacts, *more)) if rng.random() < 0.4 else event)
    return tuple(found)
