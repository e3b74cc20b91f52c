"""Motions on which hands hold objects, and where everything is along them, by plain geometry."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from humanoid_rail import Scene, Timing
from humanoid_rail._arrays import Array
from humanoid_rail.events import Event
from humanoid_rail.paper import dh_table as dh
from humanoid_rail.scene.obstacles import Obstacle, is_moving, name_of
from validation.held_geometry import Body, body_of, bone, obstacle_body
from validation.plain_geometry import LINKS, STEP, rotation
from validation.random_motions import robot

HANDS = {"left": ("left_forearm", "pL"), "right": ("right_forearm", "pR")}
"""The link and the frame of each hand."""


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
    frames = {hand: hand_frame(motion.configuration(np.array([events[0].t])), hand) for hand in HANDS}
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


def hand_frame(q: Array, hand: str) -> tuple[Array, Array]:
    """Return how the frame of a hand is turned (K, 3, 3) and where it is (K, 3), m, at configurations (K, 12)."""
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
