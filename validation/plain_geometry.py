"""Clearances of the robot's bones by hand: Table 1 and plain segments. NumPy only.

The robot is that of `humanoid_rail/paper/dh_table.py` and of the list of links that may touch; nothing is shared with
the URDF, Pinocchio, coal or the package's own search for contact.

Clearances are signed, m, but where a bone's axis is inside a box it counts as on its surface.

Reference: C. Ericson, "Real-Time Collision Detection", 2005, 5.1.9, for the nearest points of two segments.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail.paper import dh_table as dh
from humanoid_rail.scene.obstacles import Box, Capsule, Cylinder, HalfSpace, Obstacle, Sphere

RADIUS = 0.05
"""The radius of the bones, m."""
LINKS = tuple(dh.BONES)
THIRDS = 120
"""(2 / 3)^120 is below the rounding of extended precision."""
STRIDE = 20
"""All clearances are measured at one of this many moments."""
STEP = 1e-3
"""The farthest that a bone moves between two moments that are looked at, m: as it passes a body in a curve, at worst
that of its own thickness, the smallest clearance is then found to within STEP^2 / (8 RADIUS), 2.5 um."""


def links_that_may_collide(srdf: Path) -> tuple[tuple[int, int], ...]:
    """Return the pairs of links that an SRDF file does not exempt, by their indices in LINKS."""
    root = ElementTree.fromstring(srdf.read_text(encoding="utf-8"))
    exempt = [{pair.get("link1"), pair.get("link2")} for pair in root.iter("disable_collisions")]
    return tuple((a, b) for a, b in combinations(range(len(LINKS)), 2) if {LINKS[a], LINKS[b]} not in exempt)


PAIRS = links_that_may_collide(Path(__file__).resolve().parent.parent / "robots" / "humanoid_rail.srdf")
"""Pairs of links that must not touch."""


NEIGHBOURS = tuple(
    (a, b)
    for a, b in combinations(range(len(LINKS)), 2)
    if (a, b) not in PAIRS and {LINKS[a], LINKS[b]} != {"left_clavicle", "right_clavicle"}
)
"""Pairs of links that share an end and move relative to each other: they must not touch away from it."""


def bones(q: Array) -> Array:
    """Return the end points (..., 9, 2, 3) of the bones at configurations (..., 12), m."""
    return np.stack(list(dh.bones(q).values()), axis=-3)


def far_segments(one: Array, other: Array) -> tuple[Array, Array]:
    """Return what is left of bones (..., 2, 3) that share an end, farther from it than half the shorter one's length.

    The length is that of the capsule from the shared end on, and the cut is where its surface is that far away.
    """
    ends = ((i, j) for i in (0, 1) for j in (0, 1))
    i, j = min(ends, key=lambda k: float(_norm(one[..., k[0], :] - other[..., k[1], :]).max()))
    lengths = [_norm(bone[..., 1, :] - bone[..., 0, :]) for bone in (one, other)]
    begin = np.sqrt((0.5 * (np.minimum(*lengths) + RADIUS)) ** 2 - RADIUS**2)
    cut = []
    for bone, shared, length in zip((one, other), (i, j), lengths, strict=True):
        near, far = bone[..., shared, :], bone[..., 1 - shared, :]
        cut.append(np.stack([near + (begin / length)[..., None] * (far - near), far], axis=-2))
    return cut[0], cut[1]


def rotation(rpy: tuple[float, float, float]) -> Array:
    """Return the matrix (3, 3) of turns about the fixed axes x, y, z in this order, rad."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    z = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    turned: Array = z @ y @ x
    return turned


def point_segment(point: Array, segment: Array) -> Array:
    """Return the distances (...) of points (..., 3) from segments (..., 2, 3)."""
    start, along = segment[..., 0, :], segment[..., 1, :] - segment[..., 0, :]
    s = np.clip(_ratio(_dot(point - start, along), _dot(along, along)), 0.0, 1.0)
    return _norm(start + s[..., None] * along - point)


def segment_segment(one: Array, other: Array) -> Array:
    """Return the distances (...) of segments (..., 2, 3) from others that broadcast with them."""
    p, d1 = one[..., 0, :], one[..., 1, :] - one[..., 0, :]
    q, d2 = other[..., 0, :], other[..., 1, :] - other[..., 0, :]
    r = p - q
    a, b, e, c, f = _dot(d1, d1), _dot(d1, d2), _dot(d2, d2), _dot(d1, r), _dot(d2, r)
    # Nearest points of the lines; then, of what is beyond an end, that end and the point nearest to it.
    s = np.clip(_ratio(b * f - c * e, a * e - b * b), 0.0, 1.0)
    t = np.clip(_ratio(b * s + f, e), 0.0, 1.0)
    s = np.clip(_ratio(b * t - c, a), 0.0, 1.0)
    return _norm(r + s[..., None] * d1 - t[..., None] * d2)


def segment_box(segment: Array, half: Array) -> Array:
    """Return the distances (...) of segments (..., 2, 3) from the box of all x with |x| <= half (3,), 0 inside.

    Along a segment the square of the distance is convex. Its derivative is linear but for kinks where the segment
    crosses the planes of the faces, so where it is 0 lies on a straight line between two of them.
    """
    start, along = segment[..., 0, :], segment[..., 1, :] - segment[..., 0, :]
    kinks = np.concatenate([_ratio(-half - start, along), _ratio(half - start, along)], axis=-1)
    ends = np.broadcast_to([0.0, 1.0], (*kinks.shape[:-1], 2))
    s = np.sort(np.concatenate([np.clip(kinks, 0.0, 1.0), ends], axis=-1), axis=-1)
    at = start[..., None, :] + s[..., None] * along[..., None, :]
    slope = _dot(at - np.clip(at, -half, half), along[..., None, :])
    after = np.where(slope[..., -1] < 0.0, s.shape[-1] - 1, np.argmax(slope >= 0.0, axis=-1))
    before = np.maximum(after - 1, 0)
    (s0, s1), (g0, g1) = (
        [np.take_along_axis(x, i[..., None], -1)[..., 0] for i in (before, after)] for x in (s, slope)
    )
    # Still falling at the end: the end itself.
    share = np.where(g1 < 0.0, 1.0, np.clip(_ratio(-g0, g1 - g0), 0.0, 1.0))
    point = start + (s0 + share * (s1 - s0))[..., None] * along
    return _norm(point - np.clip(point, -half, half))


def segment_cylinder(segment: Array, radius: float, half_length: float) -> Array:
    """Return the distances (...) of segments (..., 2, 3) from a solid cylinder along z around the origin, 0 inside.

    Along a segment the distance is convex: the third in which it cannot be least is left out again and again.
    """
    start, along = segment[..., 0, :], segment[..., 1, :] - segment[..., 0, :]

    def distance(s: Array) -> Array:
        at = start + s[..., None] * along
        beside = np.maximum(_norm(at[..., :2]) - radius, 0.0)
        return np.hypot(beside, np.maximum(abs(at[..., 2]) - half_length, 0.0))

    low, high = np.zeros_like(start[..., 0]), np.ones_like(start[..., 0])
    for _ in range(THIRDS):
        a, b = low + (high - low) / 3.0, high - (high - low) / 3.0
        is_left = distance(a) <= distance(b)
        low, high = np.where(is_left, low, a), np.where(is_left, b, high)
    return np.minimum(distance(low), distance(high))


def clearance(obstacle: Obstacle, t: float | Array, segment: Array) -> Array:
    """Return the clearances (...) of bones (..., 2, 3) from an obstacle at times (...), m.

    Raises:
        TypeError: If it is a mesh.
    """
    moved = segment - (np.asarray(t)[..., None] * np.array(obstacle.velocity))[..., None, :]
    match obstacle:
        case Sphere():
            return point_segment(np.array(obstacle.center), moved) - obstacle.radius - RADIUS
        case Capsule():
            half = 0.5 * obstacle.length * rotation(obstacle.rpy)[:, 2]
            axis = np.array(obstacle.center) + np.array([-half, half])
            return segment_segment(moved, axis) - obstacle.radius - RADIUS
        case Box():
            local = (moved - np.array(obstacle.center)) @ rotation(obstacle.rpy)
            return segment_box(local, 0.5 * np.array(obstacle.size)) - RADIUS
        case Cylinder():
            local = (moved - np.array(obstacle.center)) @ rotation(obstacle.rpy)
            return segment_cylinder(local, obstacle.radius, 0.5 * obstacle.length) - RADIUS
        case HalfSpace():
            heights = moved @ np.array(obstacle.normal) - obstacle.offset
            nearest: Array = heights.min(axis=-1) / float(np.linalg.norm(obstacle.normal)) - RADIUS
            return nearest
    raise TypeError(f"no distance from a {obstacle.type}")


@dataclass(frozen=True, eq=False)
class Course:
    """Where the bones are along a motion, at M moments."""

    t: Array
    """(M,), s."""
    bones: Array
    """End points (M, 9, 2, 3), m."""
    shift: Array
    """How far the points of each bone are at most from where they were at the multiple of STRIDE before (M, 9), m."""

    def from_obstacle(self, obstacle: Obstacle, near: float) -> Array:
        """Return the clearance of each bone from an obstacle (M, 9), m.

        Of those that are neither the smallest nor below `near` (m) only a lower bound.
        """
        apart = clearance(obstacle, self.t[::STRIDE, None], self.bones[::STRIDE])
        since = self.t - self._at_anchors(self.t[::STRIDE])
        lower = self._at_anchors(apart) - self.shift - float(np.linalg.norm(obstacle.velocity)) * since[:, None]
        k, link = np.nonzero(lower < max(near, apart.min()))
        lower[k, link] = clearance(obstacle, self.t[k], self.bones[k, link])
        return lower

    def between_links(self, near: float) -> Array:
        """Return the clearance of each of PAIRS (M, 27), m; of those that do not matter, as above, a lower bound."""
        one, other = np.array(PAIRS).T
        apart = segment_segment(self.bones[::STRIDE, one], self.bones[::STRIDE, other]) - 2.0 * RADIUS
        lower = self._at_anchors(apart) - self.shift[:, one] - self.shift[:, other]
        k, pair = np.nonzero(lower < max(near, apart.min()))
        lower[k, pair] = segment_segment(self.bones[k, one[pair]], self.bones[k, other[pair]]) - 2.0 * RADIUS
        return lower

    def between_neighbours(self) -> Array:
        """Return the clearance of what is far from the shared end of each of NEIGHBOURS (M, 8), m."""
        far = [far_segments(self.bones[:, one], self.bones[:, other]) for one, other in NEIGHBOURS]
        return np.stack([segment_segment(*segments) - 2.0 * RADIUS for segments in far], axis=-1)

    def _at_anchors(self, values: Array) -> Array:
        repeated: Array = np.repeat(values, STRIDE, axis=0)[: len(self.t)]
        return repeated


def follow(t: Array, q: Array, finer: int, speed: float = 0.0) -> Course:
    """Return the course of a motion that is linear in q between its samples.

    Args:
        t: Times (N,), s.
        q: Configurations (N, 12), m and rad.
        finer: How many times finer than the samples to look; finer still where things move farther than STEP.
        speed: That of the fastest obstacle, m/s.
    """
    steps = np.full(len(t) - 1, finer, np.int64)
    at = bones(configuration(t, q, _moments(t, steps)))
    moved = _norm(np.diff(at, axis=0)).max(axis=(1, 2)).reshape(-1, finer).max(axis=1)
    moved += speed * np.diff(t) / finer
    if (moved > STEP).any():
        steps = finer * np.maximum(np.ceil(moved / STEP), 1).astype(np.int64)
        at = bones(configuration(t, q, _moments(t, steps)))
    anchors = np.repeat(at[::STRIDE], STRIDE, axis=0)[: len(at)]
    # Points of a bone lie between its ends.
    return Course(_moments(t, steps), at, _norm(at - anchors).max(axis=-1))


def configuration(t: Array, q: Array, at: float | Array) -> Array:
    """Return the configurations (..., 12) of a motion, samples t (N,) and q (N, 12), at times (...), s."""
    return np.stack([np.interp(at, t, column) for column in q.T], axis=-1)


def _moments(t: Array, steps: NDArray[np.int64]) -> Array:
    """Return the times (sum of steps + 1,) that divide each interval of t (N,) into steps (N - 1,) equal parts."""
    k = np.repeat(np.arange(len(steps)), steps)
    part = np.arange(len(k)) - np.repeat(np.cumsum(steps) - steps, steps)
    return np.append(t[k] + (t[k + 1] - t[k]) * part / steps[k], t[-1])


def _dot(a: Array, b: Array) -> Array:
    product: Array = np.einsum("...i,...i->...", a, b)
    return product


def _norm(a: Array) -> Array:
    return np.sqrt(_dot(a, a))


def _ratio(a: Array, b: Array) -> Array:
    """Return a / b, and 0 where b is 0."""
    a, b = np.broadcast_arrays(a, b)
    return np.divide(a, b, out=np.zeros(a.shape), where=b != 0.0)
