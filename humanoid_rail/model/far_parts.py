"""The parts of two neighbouring bodies that are far from the joint between them.

Two bones that share an end point always touch there, so they cannot be checked against each other as they are. What can
be told is whether they meet farther from that point, the pivot, than a distance: where two bodies touch, the place is
equally far from the pivot on both. So each body is cut off near the pivot, and what is left of the two can be checked
as any other pair.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.model.collision_bodies import coal_placement

AWAY = " away from "
"""The name of a far part is that of its body, this, and that of the other body."""
SHARE = 0.5
"""Bodies are cut off at this share of the shorter one's length from the pivot."""
SAME_POINT = 1e-6
"""A pivot is one if it stays this near to its place on both bodies, as a share of the bodies' size."""
LOOKS = 8
"""Whether a pivot stays where it is on both bodies is looked at in this many configurations."""
MOST_JOINTS = 3
"""Bodies with more joints between them than this are no neighbours."""
NEAREST_CELL = 1e-3
"""Relative postures are told apart to this share of the bodies' reach."""
SLACK = 1e-6
"""What is proven within position limits holds as far beyond them too, m and rad: rounding does not leave them."""
MOST_LOOKS = 20_000
"""The postures of two bodies are looked at in at most this many places; then they count as meeting."""


@dataclass(frozen=True, eq=False)
class FarParts:
    """What is left of two neighbouring bodies without what is near to the joint between them."""

    distance: float
    """What is farther from the pivot than this is in them, m."""
    first: pin.GeometryObject
    second: pin.GeometryObject
    joints: tuple[int, ...]
    """The joints of the model between the two bodies."""
    reach: float
    """No point of the part that reaches less far is farther from the pivot, m."""
    turns_nothing: frozenset[int]
    """These of the joints turn a part about its own axis, so they do not matter."""


@dataclass(frozen=True, eq=False)
class _Bar:
    """A primitive shape as a bar along its longest axis, seen from a pivot."""

    axis: int
    """Of the shape's own frame."""
    sign: float
    """Whether it extends along the axis from the pivot, or against it."""
    begin: float
    """How far along the axis it begins, m; negative if that is beyond the pivot."""
    end: float
    """How far along the axis it ends, caps left out, m."""
    cap: float
    """How much farther its end reaches, m."""
    aside: float
    """How far its points are from the parallel to the axis through the pivot, or less, m."""
    is_on_axis: bool
    """Whether it is round and the pivot is on its axis."""


def far_parts(model: pin.Model, first: pin.GeometryObject, second: pin.GeometryObject) -> FarParts | None:
    """Return the far parts of two bodies; None if they are no neighbours or have no part that is far from the joint."""
    joints = _joints_between(model, first.parentJoint, second.parentJoint)
    pivots = _pivots(model, joints, first, second) if 0 < len(joints) <= MOST_JOINTS else None
    if pivots is None:
        return None
    one, other = (_bar(body, pivot) for body, pivot in zip((first, second), pivots, strict=True))
    if one is None or other is None:
        return None
    distance = SHARE * min(one.end + one.cap, other.end + other.cap)
    cuts = [
        _cut(body, pivot, bar, distance) for body, pivot, bar in zip((first, second), pivots, (one, other), strict=True)
    ]
    if cuts[0] is None or cuts[1] is None:
        return None
    reach = min(float(np.hypot(bar.end + bar.cap, bar.aside)) for bar in (one, other))
    parts = _named(first, cuts[0], second), _named(second, cuts[1], first)
    return FarParts(distance, *parts, joints, reach, _idle(model, joints, (first, second), (one, other)))


def may_meet(model: pin.Model, parts: FarParts, q: Array) -> bool:
    """Return whether the far parts can touch within the position limits of the joints between them.

    The joints count as independent of each other. No is a proof: postures are divided until in each cell the distance
    at its middle is more than what its corners can take from it. That distance is itself proven, not the library's.

    Args:
        model: All joints with their limits.
        parts: The far parts.
        q: A configuration (model.nq,) of all joints, for those that are not between the parts.
    """
    indices = [model.joints[j].idx_q for j in parts.joints if j not in parts.turns_nothing]
    ranges = [_range(model.lowerPositionLimit[i], model.upperPositionLimit[i]) for i in indices]
    data, full, looks = model.createData(), np.array(q, float), 0
    cells = [(np.array([np.mean(r) for r in ranges]), np.array([(r[1] - r[0]) / 2.0 for r in ranges]))]
    while cells:
        middle, half = cells.pop()
        full[indices] = middle
        clearance, looks = _separation(model, data, parts, full), looks + 1
        lost = parts.reach * float(half.sum())
        if clearance > lost:
            continue
        if clearance <= 0.0 or lost < NEAREST_CELL * parts.reach or looks > MOST_LOOKS:
            return True
        widest = int(half.argmax())
        half[widest] /= 2.0
        for side in (-1.0, 1.0):
            center = middle.copy()
            center[widest] += side * half[widest]
            cells.append((center, half.copy()))
    return False


def part_distance(model: pin.Model, data: pin.Data, parts: FarParts, q: Array) -> float:
    """Return how far the parts are from each other at a configuration (model.nq,) of all joints, m."""
    return _measured(model, data, parts, q)[0]


def _measured(model: pin.Model, data: pin.Data, parts: FarParts, q: Array) -> tuple[float, Array, list[pin.SE3]]:
    """Return the library's distance, its normal (3,) from the first part to the second, and where the parts are."""
    pin.forwardKinematics(model, data, q)
    places = [data.oMi[body.parentJoint] * body.placement for body in (parts.first, parts.second)]
    one, other = map(coal_placement, places)
    result = coal.DistanceResult()
    apart = coal.distance(parts.first.geometry, one, parts.second.geometry, other, coal.DistanceRequest(), result)
    return float(apart), np.array(result.normal), places


def _separation(model: pin.Model, data: pin.Data, parts: FarParts, q: Array) -> float:
    """Return a lower bound of the distance of the parts, m: that of two planes between them, whatever their normal."""
    _, normal, places = _measured(model, data, parts, q)
    normal /= float(np.linalg.norm(normal)) or 1.0  # it is 0 of axes that cross, where the bound is none
    extents = [
        _extent(body.geometry, place.rotation.T @ normal)
        for body, place in zip((parts.first, parts.second), places, strict=True)
    ]
    return float(normal @ (places[1].translation - places[0].translation)) - sum(extents)


def _extent(shape: coal.ShapeBase, direction: Array) -> float:
    """Return how far a shape extends from its middle along a direction (3,) of length 1 in its own frame, m."""
    match shape:
        case coal.Capsule():
            return float(shape.halfLength * abs(direction[2]) + shape.radius)
        case coal.Cylinder():
            return float(shape.halfLength * abs(direction[2]) + shape.radius * np.hypot(*direction[:2]))
        case _:
            return float(np.array(shape.halfSide) @ abs(direction))


def _range(lower: float, upper: float) -> tuple[float, float]:
    """Return a range of an angle that has all of its postures, and a little more than those within its limits."""
    if not np.isfinite(lower) or not np.isfinite(upper):
        return -np.pi, np.pi
    return float(lower) - SLACK, float(min(upper, lower + 2.0 * np.pi)) + SLACK


def _joints_between(model: pin.Model, first: int, second: int) -> tuple[int, ...]:
    """Return the joints that move one body relative to another, from the first to the second."""
    up = [list(model.supports[joint])[1:] for joint in (first, second)]
    return (*(j for j in reversed(up[0]) if j not in up[1]), *(j for j in up[1] if j not in up[0]))


def _pivots(
    model: pin.Model, joints: Sequence[int], first: pin.GeometryObject, second: pin.GeometryObject
) -> tuple[Array, Array] | None:
    """Return the point (3,) about which two bodies turn, in the frames of the joints that carry them; None if none."""
    if any(not model.joints[j].shortname().startswith("JointModelR") for j in joints):
        return None
    data, rng = model.createData(), np.random.default_rng(0)
    carriers = (first.parentJoint, second.parentJoint)
    pin.computeJointJacobians(model, data, rng.uniform(-1.0, 1.0, model.nq))
    places = [data.oMi[body.parentJoint] * body.placement for body in (first, second)]
    # The point nearest to the axes of all joints and, where that leaves it open, to the axes of the bodies.
    rows, sides = [], []
    lines = [(_axis(model, data, j), data.oMi[j].translation, 1.0) for j in joints]
    lines += [
        (place.rotation[:, _longest(body)], place.translation, SAME_POINT)
        for place, body in zip(places, (first, second), strict=True)
    ]
    for direction, point, weight in lines:
        across = weight * (np.eye(3) - np.outer(direction, direction))
        rows.append(across)
        sides.append(across @ point)
    middle = (places[0].translation + places[1].translation) / 2.0
    A, b = np.vstack(rows), np.concatenate(sides)
    point = middle + np.linalg.lstsq(A, b - A @ middle, rcond=1e-9)[0]
    pivots = [data.oMi[carrier].inverse().act(point) for carrier in carriers]
    size = sum(2.0 * _half(body)[_longest(body)] for body in (first, second))
    for _ in range(LOOKS):
        pin.forwardKinematics(model, data, rng.uniform(-1.0, 1.0, model.nq))
        one, other = (data.oMi[carrier].act(pivot) for carrier, pivot in zip(carriers, pivots, strict=True))
        if np.linalg.norm(one - other) > SAME_POINT * size:
            return None
    return pivots[0], pivots[1]


def _axis(model: pin.Model, data: pin.Data, joint: int) -> Array:
    """Return the axis (3,) of a revolute joint, of length 1, where the Jacobians of the joints are computed."""
    # Of a single joint Pinocchio has a flat array.
    return np.array(np.reshape(data.J, (6, model.nv))[3:, model.joints[joint].idx_v])


def _half(body: pin.GeometryObject) -> Array:
    """Return half the size (3,) of a body along its axes, round caps left out, m; nothing for other shapes."""
    shape = body.geometry
    match shape:
        case coal.Capsule() | coal.Cylinder():
            return np.array([shape.radius, shape.radius, shape.halfLength])
        case coal.Box():
            return np.array(shape.halfSide)
        case _:
            return np.zeros(3)


def _longest(body: pin.GeometryObject) -> int:
    return int(_half(body).argmax()) if isinstance(body.geometry, coal.Box) else 2


def _bar(body: pin.GeometryObject, pivot: Array) -> _Bar | None:
    """Return a body as a bar; None if it has another shape, or the pivot is not near one of its ends."""
    half, axis, shape = _half(body), _longest(body), body.geometry
    place = body.placement.inverse().act(pivot)
    along, off = float(place[axis]), float(np.linalg.norm(np.delete(place, axis)))
    if half[axis] <= 0.0 or abs(along) < half[axis] / 2.0:
        return None
    is_box = isinstance(shape, coal.Box)
    return _Bar(
        axis=axis,
        sign=-float(np.sign(along)),
        begin=abs(along) - float(half[axis]),
        end=abs(along) + float(half[axis]),
        cap=float(shape.radius) if isinstance(shape, coal.Capsule) else 0.0,
        aside=off + (float(np.hypot(*np.delete(half, axis))) if is_box else float(shape.radius)),
        is_on_axis=not is_box and off <= SAME_POINT * float(half[axis]),
    )


def _cut(body: pin.GeometryObject, pivot: Array, bar: _Bar, distance: float) -> tuple[coal.ShapeBase, pin.SE3] | None:
    """Return what is left of a body beyond a distance from the pivot, or a little more.

    None if nothing is cut off, or something is left behind the pivot too.
    """
    begin = np.sqrt(max(distance**2 - bar.aside**2, 0.0))
    if not max(bar.begin, bar.cap - bar.begin, 0.0) < begin < bar.end:
        return None
    shape, length = body.geometry, bar.end - begin
    center = np.zeros(3)
    center[bar.axis] = body.placement.inverse().act(pivot)[bar.axis] + bar.sign * (begin + length / 2.0)
    placement = body.placement * pin.SE3(np.eye(3), center)
    match shape:
        case coal.Capsule():
            return coal.Capsule(shape.radius, length), placement
        case coal.Cylinder():
            return coal.Cylinder(shape.radius, length), placement
        case _:
            sides = 2.0 * np.array(shape.halfSide)
            sides[bar.axis] = length
            return coal.Box(*sides), placement


def _named(
    body: pin.GeometryObject, cut: tuple[coal.ShapeBase, pin.SE3], other: pin.GeometryObject
) -> pin.GeometryObject:
    part = pin.GeometryObject(f"{body.name}{AWAY}{other.name}", body.parentJoint, body.parentFrame, cut[1], cut[0])
    part.meshColor = body.meshColor
    return part


def _idle(
    model: pin.Model,
    joints: Sequence[int],
    bodies: tuple[pin.GeometryObject, pin.GeometryObject],
    bars: tuple[_Bar, _Bar],
) -> frozenset[int]:
    """Return the joints next to one of the bodies that turn it about its own axis."""
    data = model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    idle = set()
    for joint, body, bar in zip((joints[0], joints[-1]), bodies, bars, strict=True):
        axis = _axis(model, data, joint)
        own = (data.oMi[body.parentJoint] * body.placement).rotation[:, bar.axis]
        if bar.is_on_axis and np.linalg.norm(np.cross(axis, own)) <= SAME_POINT:
            idle.add(joint)
    return frozenset(idle)
