"""Random motions on which hands grasp, carry and release random objects among random obstacles, many near to contact.

The seed and a motion's number determine the motion. Hands may grasp from any distance: certificates believe that.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from math import pi
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull

from humanoid_rail import Box, Capsule, Mesh, Scene, Sphere, Timing
from humanoid_rail._arrays import Array, triple
from humanoid_rail.events import Event
from humanoid_rail.paper import dh_table as dh
from humanoid_rail.scene.obstacles import HalfSpace, Obstacle, is_moving, name_of
from validation.held_geometry import Body, body_of, bone, clearances, distance, obstacle_body
from validation.plain_geometry import LINKS, RADIUS, STEP, clearance, rotation
from validation.random_motions import MISS, PROBE, START, links_are_apart, random_obstacle, random_start, robot

LINEAR, CUBIC, TWO, NEAR = "linear", "cubic", "two hands", "near miss"
KINDS = (LINEAR, CUBIC, TWO, NEAR)
"""The kinds of motions: one object on straight or cubic motions, one in each hand or in both, and near misses."""
HANDS = {"left": ("left_forearm", "pL"), "right": ("right_forearm", "pR")}
"""The link and the frame of each hand."""
SHAPES = 12
"""So many meshes there are."""
COARSE = 10
"""While a near miss is made, the motion is looked at this many times finer than its samples."""


@dataclass(frozen=True, eq=False)
class HeldMotion:
    """A motion with objects, as `verify` takes it: linear in q between its samples, or cubic if it has a timing."""

    kind: str
    t: Array
    """(N,), s."""
    q: Array
    """(N, 12), m and rad."""
    timing: Timing | None
    events: tuple[Event, ...]
    objects: tuple[Obstacle, ...]
    obstacles: tuple[Obstacle, ...]

    def scene(self) -> Scene:
        """Return its scene."""
        return Scene.model_validate(
            {"name": "random", "targets": {}, "obstacles": self.obstacles, "objects": self.objects}
        )

    def configuration(self, at: Array) -> Array:
        """Return the configurations (K, 12) at times (K,), s; of a cubic motion by the polynomials of Hermite."""
        k = np.clip(np.searchsorted(self.t, at, side="right") - 1, 0, len(self.t) - 2)
        width = self.t[k + 1] - self.t[k]
        s = ((at - self.t[k]) / width)[:, None]
        if self.timing is None:
            return self.q[k] + s * (self.q[k + 1] - self.q[k])
        v0, v1 = (width[:, None] * self.timing.velocity[i] for i in (k, k + 1))
        ends = (1.0 + 2.0 * s) * (1.0 - s) ** 2 * self.q[k] + s**2 * (3.0 - 2.0 * s) * self.q[k + 1]
        found: Array = ends + s * (1.0 - s) ** 2 * v0 - s**2 * (1.0 - s) * v1
        return found


@dataclass(frozen=True, eq=False)
class Part:
    """A part of a motion between two events, at K moments."""

    t: Array
    """(K,), s."""
    bodies: dict[str, Body]
    """The bones, the objects and the obstacles, by their names."""
    pairs: tuple[tuple[str, str], ...]
    """The pairs that have to be checked."""
    left_out: frozenset[frozenset[str]]
    """The pairs that are not, and move relative to each other."""
    leaves_limits: bool
    """Whether a joint leaves its position limits."""


@dataclass(eq=False)
class _State:
    """Where objects are, by name: the frame of each that stands, the hands and the place in the hand of the others."""

    standing: dict[str, tuple[Array, Array]]
    held: dict[str, tuple[tuple[str, ...], Array, Array]]
    contacts: dict[str, frozenset[str]]


def parts(motion: HeldMotion, finer: int) -> Iterator[Part]:
    """Yield the parts of a motion, looked at so many times finer than its samples, or finer still."""
    state = _State(
        {
            str(one.name): (rotation(getattr(one, "rpy", (0.0, 0.0, 0.0))), np.array(getattr(one, "center", None)))
            for one in motion.objects
        },
        {},
        {},
    )
    begin, number = float(motion.t[0]), 0
    events = motion.events
    while True:
        together = [event for event in events[number:] if event.t == events[number].t]
        end = together[0].t if together else float(motion.t[-1])
        if end > begin or not together:
            yield _part(motion, state, begin, end, finer)
        if not together:
            return
        _happen(motion, state, together)
        begin, number = end, number + len(together)


def _happen(motion: HeldMotion, state: _State, events: list[Event]) -> None:
    frames = {hand: _hand(motion.configuration(np.array([events[0].t])), hand) for hand in HANDS}
    for kind in ("release", "grasp"):
        for event in (event for event in events if event.kind == kind):
            turned, place = (x[0] for x in frames[event.hands[0]])
            if kind == "release":
                hands, own, there = state.held.pop(event.object)
                turned, place = (x[0] for x in frames[hands[0]])
                state.standing[event.object] = (turned @ own, turned @ there + place)
            else:
                own, there = state.standing.pop(event.object)
                state.held[event.object] = (event.hands, turned.T @ own, turned.T @ (there - place))
    for event in events:
        touched = (HANDS[name][0] if name in HANDS else name for name in event.contacts)
        state.contacts[event.object] = frozenset(touched)


def _hand(q: Array, hand: str) -> tuple[Array, Array]:
    there = dh.frames(q)[HANDS[hand][1]]
    return there[:, :3, :3], there[:, :3, 3]


def _moments(motion: HeldMotion, state: _State, begin: float, end: float, finer: int) -> Array:
    """Return times (K,) between which nothing moves by more than about STEP."""
    inside = motion.t[(motion.t > begin) & (motion.t < end)]
    knots = np.unique(np.concatenate([[begin], inside, [end]]))
    if len(knots) == 1:
        return knots
    steps = np.full(len(knots) - 1, finer)
    t = _divided(knots, steps)
    speed = max((float(np.linalg.norm(one.velocity)) for one in motion.obstacles), default=0.0)
    moved = speed * np.diff(t)
    for body in _moving(motion, state, t).values():
        moved = np.maximum(moved, np.sqrt((np.diff(body.edges, axis=0) ** 2).sum(axis=-1)).max(axis=(1, 2)))
    longest = moved.reshape(-1, finer).max(axis=1)
    return _divided(knots, finer * np.maximum(np.ceil(longest / STEP), 1).astype(int))


def _divided(knots: Array, steps: np.ndarray) -> Array:
    pieces = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(knots, knots[1:], steps, strict=False)]
    return np.concatenate([*pieces, knots[-1:]])


def _moving(motion: HeldMotion, state: _State, t: Array) -> dict[str, Body]:
    """Return the bones and the held objects at times (K,), s."""
    frames = dh.frames(motion.configuration(t))
    found = {
        link: bone(np.stack([frames[start][:, :3, 3], frames[end][:, :3, 3]], axis=1))
        for link, (start, end) in dh.BONES.items()
    }
    for one in motion.objects:
        if one.name in state.held:
            hands, own, there = state.held[one.name]
            hand = frames[HANDS[hands[0]][1]]
            turned, place = hand[:, :3, :3], hand[:, :3, 3]
            found[one.name] = body_of(one, turned @ own, turned @ there + place)
    return found


def _part(motion: HeldMotion, state: _State, begin: float, end: float, finer: int) -> Part:
    t = _moments(motion, state, begin, end, finer)
    bodies = _moving(motion, state, t)
    for one in motion.objects:
        if one.name in state.standing:
            turned, place = state.standing[one.name]
            bodies[one.name] = body_of(one, turned[None], place[None])
    obstacles = {name_of(motion.obstacles, i): one for i, one in enumerate(motion.obstacles)}
    bodies |= {name: obstacle_body(one, t) for name, one in obstacles.items()}
    objects = [str(one.name) for one in motion.objects]
    allowed = {frozenset((name, other)) for name, others in state.contacts.items() for other in others}
    allowed |= {frozenset((name, HANDS[hand][0])) for name, (hands, *_) in state.held.items() for hand in hands}
    candidates = [(link, other) for link in LINKS for other in (*objects, *obstacles)]
    # What stands still is not checked against what stands still.
    candidates += [
        (name, other) for name in objects for other, one in obstacles.items() if name in state.held or is_moving(one)
    ]
    candidates += [
        (a, b) for i, a in enumerate(objects) for b in objects[i + 1 :] if a in state.held or b in state.held
    ]
    pairs = tuple(pair for pair in candidates if frozenset(pair) not in allowed)
    q, slack = motion.configuration(t), 1e-6
    leaves = bool(((q < robot().lower - slack) | (q > robot().upper + slack)).any())
    return Part(t, bodies, pairs, frozenset(map(frozenset, candidates)) & allowed, leaves)


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
        _, tip = _hand(motion.configuration(times[1:2]), hands[0])
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
