"""Looks for contact along a motion: pair by pair, again when two could have come near enough to matter.

This is the reference; `engine/certificate.cpp` has the same in C++. How distances are bounded between two moments is in
`sweep.py`.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.collision.certificate import Certificate, Contact
from humanoid_rail.scene.obstacles import Obstacle, name_of
from humanoid_rail.model.robot import Robot
from humanoid_rail.collision.swept_distance import Nearest, Pair, Snapshot, Sweep
from humanoid_rail.collision.motion_bound import Reach

RESOLUTION = 1e-3
"""How far the bound may lie below the smallest clearance found, m."""
HOPE = 1.6
"""How far to look ahead, in units of the distance that a pair can spare."""
CONTACT = 1e-6
"""What coal's distances are precise to, m: two that come nearer touch."""


def certify(robot: Robot, obstacles: tuple[Obstacle, ...], t: Array, q: Array) -> Certificate:
    """Return what can be proven of a motion that is linear in q between its samples.

    Args:
        robot: The robot.
        obstacles: What its links must not touch, beside each other.
        t: Times (N,), ever later, s.
        q: Configurations (N, n), m and rad.
    """
    return _Search(robot, obstacles, t, q).run()


def name_contact(
    robot: Robot, obstacles: Sequence[Obstacle], t: float, link: int, other: int, with_obstacle: bool, point: Array
) -> Contact:
    """Return a contact by names from one by numbers; `other` is an obstacle or a link."""
    name = name_of(obstacles, other) if with_obstacle else robot.link_names[other]
    x, y, z = (float(c) for c in point)
    return Contact(float(t), robot.link_names[link], name, (x, y, z))


class _Search:
    """One motion."""

    def __init__(self, robot: Robot, obstacles: tuple[Obstacle, ...], t: Array, q: Array) -> None:
        self._robot, self._obstacles, self._t, self._q = robot, obstacles, t, q
        self._sweep = Sweep(robot, obstacles)
        self._seen: dict[int, Snapshot] = {}
        self._least = {True: np.inf, False: np.inf}  # of obstacles, and of links
        self._bound = np.inf
        self._contact: Contact | None = None
        ways = [self._sweep.ways(a, b) for a, b in pairwise(q)]
        self._link_ways = _along([links for links, _ in ways], len(robot.link_names))
        self._pair_ways = _along([pairs for _, pairs in ways], len(robot.self_collision_pairs))

    def run(self) -> Certificate:
        pairs = [*self._sweep.obstacle_pairs, *self._sweep.link_pairs]
        # The sooner a small clearance is known, the less of what is larger has to be looked at.
        for k in {len(self._t) - 1, (len(self._t) - 1) // 2}:
            for pair in pairs:
                self._measure(pair, self._at(k))
        for pair in pairs:
            self._search(pair)
        bound = float(min(self._bound, *self._least.values())) - CONTACT
        return Certificate(
            certified=self._contact is None and bound > 0,
            min_clearance_obstacles=self._least[True] if self._sweep.obstacle_pairs else None,
            min_clearance_self=self._least[False] if self._sweep.link_pairs else None,
            clearance_bound=bound if pairs else None,
            contact=self._contact,
        )

    def _search(self, pair: Pair) -> None:
        """Follow a pair along the motion."""
        here = self._measure(pair, self._at(0))
        if here.distance < CONTACT:
            self._touch(pair, here, self._at(0))
        self._accept(here.distance)
        speed = self._sweep.speed(pair)
        ways, column = (self._pair_ways, pair.number) if pair.piece is None else (self._link_ways, pair.link)
        travel, curvature = ways.travel[:, column] + speed * self._t, ways.curvature[:, column]
        k, last = 0, len(self._t) - 1
        while k < last:
            spare = here.distance - self._wanted(pair, self._t[k])
            if travel[k + 1] - travel[k] <= HOPE * spare:
                # As far as the two can go and come back, if they are as far apart again there; ...
                hoped = int(np.searchsorted(travel - travel[k], HOPE * spare, side="right")) - 1
                there = self._measure(pair, self._at(hoped))
                between = (here.distance + there.distance - (travel[hoped] - travel[k])) / 2.0
                if between >= self._wanted(pair, self._t[k]):
                    self._accept(between)
                    here, k = there, hoped
                    continue
                # ... or at least as far as they can spare.
                after = int(np.searchsorted(travel - travel[k], spare, side="right")) - 1
                if after > k:
                    self._accept(here.distance - (travel[after] - travel[k]))
                    k = after
                    if k < last:
                        here = self._measure(pair, self._at(k))
                    continue
            there = self._measure(pair, self._at(k + 1))
            way = travel[k + 1] - travel[k], curvature[k]
            self._step(pair, here, self._at(k), there, self._at(k + 1), *way)
            here, k = there, k + 1

    def _step(
        self, pair: Pair, here: Nearest, a: Snapshot, there: Nearest, b: Snapshot, travel: float, curvature: float
    ) -> None:
        """Bound the distance of a pair on the straight way between two moments at which it was measured."""
        wanted = self._wanted(pair, a.t, closely=True)
        bound = self._sweep.least(pair, here, a, there, b, travel, curvature, wanted)
        if bound >= wanted or travel <= CONTACT:
            if bound < wanted:
                self._touch(pair, there, b)
            self._accept(bound)
            return
        middle = self._sweep.take(0.5 * (a.t + b.t), 0.5 * (a.q + b.q))
        between = self._measure(pair, middle)
        half = 0.5 * travel, 0.25 * curvature  # half the way, at half the rates
        self._step(pair, here, a, between, middle, *half)
        self._step(pair, between, middle, there, b, *half)

    def _wanted(self, pair: Pair, t: float, closely: bool = False) -> float:
        """Return what a bound has to reach: the smallest clearance so far; looked at closely, a little less.

        Until there is contact every pair has to be proven apart.
        """
        least = self._least[pair.piece is not None]
        wanted = least - (min(RESOLUTION, least / 2.0) if least > 0 else RESOLUTION) if closely else least
        return max(wanted, 0.5 * CONTACT) if self._contact is None or t < self._contact.t else wanted

    def _accept(self, bound: float) -> None:
        self._bound = min(self._bound, bound)

    def _touch(self, pair: Pair, nearest: Nearest, at: Snapshot) -> None:
        if self._contact is None or at.t < self._contact.t:
            with_obstacle = pair.piece is not None
            self._contact = name_contact(
                self._robot, self._obstacles, at.t, pair.link, pair.other, with_obstacle, nearest.point
            )

    def _measure(self, pair: Pair, at: Snapshot) -> Nearest:
        nearest = self._sweep.measure(pair, at)
        kind = pair.piece is not None
        self._least[kind] = min(self._least[kind], nearest.distance)
        return nearest

    def _at(self, k: int) -> Snapshot:
        if k not in self._seen:
            self._seen[k] = self._sweep.take(float(self._t[k]), self._q[k])
        return self._seen[k]


def _along(reaches: list[Reach], size: int) -> Reach:
    """Return how far bodies travel from the first sample to each (N, size), and curvatures between (N - 1, size)."""
    travel = np.array([reach.travel for reach in reaches]).reshape(len(reaches), size)
    curvature = np.array([reach.curvature for reach in reaches]).reshape(len(reaches), size)
    return Reach(np.vstack([np.zeros(size), np.cumsum(travel, axis=0)]), curvature)
