"""A lower bound of clearances while a robot moves from one configuration straight to another.

This is the reference; `engine/sweep.cpp` has the same in C++.

Two bounds of the distance d of two convex bodies, measured at both ends a and b of the way:

- From either end d has shrunk by no more than the way from there, so d >= (d_a + d_b - l) / 2, where l is how far the
  points of the two can get relative to each other (conservative advancement).
- Between two bodies there is a plane. Let n be the normal of their nearest points at one end. The gap of the planes
  with normal n that touch the one and the other is a lower bound of d at any moment. Each point's coordinate along n
  is, on the way, that of a straight line from a to b but for an eighth of its largest second derivative c, and so
  d >= min(gap_a, gap_b) - c / 8. Short steps lose next to nothing.

For two links all this is seen from the body that carries both.
"""

from __future__ import annotations

from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.shapes import PlacedShape, placed_shapes, support
from humanoid_rail.collision.motion_bound import Reach, Travel


class Pair(NamedTuple):
    """Two bodies that must not touch."""

    link: int
    other: int
    """The obstacle, or the other link."""
    piece: int | None
    """The convex piece of all obstacles' pieces; None for two links."""
    number: int
    """Of all pairs of links, where it is two links; of links and pieces else."""


class Nearest(NamedTuple):
    """How near two bodies are."""

    distance: float
    """m; negative in penetration."""
    point: Array
    """On the link (3,), in the base frame, m."""
    normal: Array
    """From the link to the other (3,), in penetration too."""


class Snapshot(NamedTuple):
    """A robot at a moment."""

    t: float
    q: Array
    bodies: list[pin.SE3]
    """Where the links are."""
    origins: list[pin.SE3]
    """Where the joints are that pairs of links move relative to."""


class Sweep:
    """A robot among obstacles that may move. Not to be shared between threads."""

    def __init__(self, robot: Robot, obstacles: tuple[Obstacle, ...]) -> None:
        self.robot = robot
        self._travel = Travel(robot)
        self._data, self._bodies = robot.model.createData(), robot.collision_model.createData()
        self._request = coal.DistanceRequest()
        pieces = [(i, piece) for i, obstacle in enumerate(obstacles) for piece in placed_shapes(obstacle)]
        self._pieces = [piece for _, piece in pieces]
        self._velocities = [np.array(obstacles[i].velocity) for i, _ in pieces]
        joints = [body.parentJoint for body in robot.collision_model.geometryObjects]
        common = [_common_joint(robot.model, joints[a], joints[b]) for a, b in robot.self_collision_pairs]
        self._origins = [0, *sorted(set(common) - {0})]
        self._origin_of = [self._origins.index(joint) for joint in common]
        self.obstacle_pairs = [
            Pair(link, obstacle, piece, link * len(pieces) + piece)
            for link in range(len(joints))
            for piece, (obstacle, _) in enumerate(pieces)
        ]
        self.link_pairs = [Pair(a, b, None, number) for number, (a, b) in enumerate(robot.self_collision_pairs)]

    def take(self, t: float, q: Array) -> Snapshot:
        """Return where the robot is at a configuration (n,)."""
        robot = self.robot
        pin.forwardKinematics(robot.model, self._data, robot.full_configuration(q))
        pin.updateGeometryPlacements(robot.model, self._data, robot.collision_model, self._bodies)
        origins = [pin.SE3(self._data.oMi[joint]) for joint in self._origins]
        return Snapshot(t, q, [pin.SE3(M) for M in self._bodies.oMg], origins)

    def measure(self, pair: Pair, at: Snapshot) -> Nearest:
        """Return how near two bodies are at a moment."""
        one, two = self._link(pair.link, at), self._other(pair, at)
        result = coal.DistanceResult()
        distance = coal.distance(one.shape, one.placement, two.shape, two.placement, self._request, result)
        return Nearest(distance, result.getNearestPoint1(), result.normal)

    def ways(self, a: Array, b: Array) -> tuple[Reach, Reach]:
        """Return how far links get from the base, and the two of each pair of links from each other, on a straight way.

        Args:
            a: Configuration (n,) at its beginning.
            b: The same at its end.
        """
        before, after = self.robot.full_configuration(a), self.robot.full_configuration(b)
        change, slide = after - before, np.maximum(abs(before), abs(after))
        reaches = [self._travel.reach(change, slide, origin) for origin in self._origins]
        pairs = list(zip(self.robot.self_collision_pairs, self._origin_of, strict=True))
        travel = [reaches[o].travel[link] + reaches[o].travel[other] for (link, other), o in pairs]
        curvature = [reaches[o].curvature[link] + reaches[o].curvature[other] for (link, other), o in pairs]
        return reaches[0], Reach(np.array(travel), np.array(curvature))

    def speed(self, pair: Pair) -> float:
        """Return how fast the obstacle of a pair moves, m/s."""
        return 0.0 if pair.piece is None else float(np.linalg.norm(self._velocities[pair.piece]))

    def least(
        self,
        pair: Pair,
        here: Nearest,
        a: Snapshot,
        there: Nearest,
        b: Snapshot,
        travel: float,
        curvature: float,
        wanted: float,
    ) -> float:
        """Return a lower bound of the distance of a pair on the straight way between two moments, m.

        Args:
            pair: The two bodies.
            here: How near they are at the beginning.
            a: The robot there.
            there: How near they are at the end.
            b: The robot there.
            travel: How far the two get relative to each other, m.
            curvature: The largest second derivative of that by the share of the way, m.
            wanted: Once the bound is as large, no better one is looked for, m.
        """
        bound = (here.distance + there.distance - travel) / 2.0
        if bound < wanted:
            bound = max(bound, self._gap(pair, here, a, a, b) - curvature / 8.0)
        if bound < wanted:
            bound = max(bound, self._gap(pair, there, b, a, b) - curvature / 8.0)
        return float(bound)

    def _gap(self, pair: Pair, nearest: Nearest, at: Snapshot, a: Snapshot, b: Snapshot) -> float:
        """Return the smaller gap, at a and b, of the planes with the normal of the nearest points at a moment."""
        normal = nearest.normal
        if pair.piece is None:
            origin = self._origin_of[pair.number]
            local = at.origins[origin].rotation.T @ normal
            directions = [snapshot.origins[origin].rotation @ local for snapshot in (a, b)]
        else:
            shape, placement = self._pieces[pair.piece]
            if isinstance(shape, coal.Halfspace):
                normal = -placement.getRotation() @ np.array(shape.n)
            directions = [normal, normal]
        return min(
            -support(self._other(pair, snapshot), -direction) - support(self._link(pair.link, snapshot), direction)
            for snapshot, direction in zip((a, b), directions, strict=True)
        )

    def _link(self, link: int, at: Snapshot) -> PlacedShape:
        M = at.bodies[link]
        shape = self.robot.collision_model.geometryObjects[link].geometry
        return PlacedShape(shape, coal.Transform3s(M.rotation, M.translation))

    def _other(self, pair: Pair, at: Snapshot) -> PlacedShape:
        if pair.piece is None:
            return self._link(pair.other, at)
        shape, placement = self._pieces[pair.piece]
        moved = placement.getTranslation() + at.t * self._velocities[pair.piece]
        return PlacedShape(shape, coal.Transform3s(placement.getRotation(), moved))


def _common_joint(model: pin.Model, one: int, two: int) -> int:
    """Return the outermost joint that moves the bodies of two joints alike; 0, the base, where there is none."""
    common = [a for a, b in zip(model.supports[one], model.supports[two], strict=False) if a == b]
    return int(common[-1])
