"""What the bodies of a hand say of it: where its fingers point, how far they reach, what its tool point is inside."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import coal
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array, triple
from humanoid_rail.model.building import Mechanism
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.model.hands import FINGER, TOOL, moving_before
from humanoid_rail.model.robot import Hand, called
from humanoid_rail.model.urdf import Urdf

ALONG = float(np.cos(np.radians(40.0)))
"""Fingers point along an axis of the frame if the angle between them has at least this cosine."""
AHEAD = 0.05
"""Fingers that end farther in front of the frame than this are worth a word, m."""
POINT = 1e-6
"""A point is a sphere of this radius, m."""


@dataclass(frozen=True)
class HandShape:
    """What the bodies of a hand say of it."""

    pointing: tuple[float, float, float] | None
    """The axis of the frame along which its fingers point; None if it has none, or they point between axes."""
    ahead: float
    """How far the fingers reach beyond the origin of the frame along it, m; 0 if there are none."""
    around: tuple[str, ...]
    """The links with bodies that the origin of the frame is inside."""


def hands_by_shape(
    hands: Sequence[Hand],
    found: Sequence[str],
    mechanism: Mechanism,
    bodies: pin.GeometryModel,
    original: Urdf,
    as_written: bool,
) -> tuple[list[Hand], list[str]]:
    """Return hands with the directions in which they point, and what was found of them, in sentences.

    Args:
        hands: The hands, each with a frame that is there.
        found: How each was found; empty if it was given.
        mechanism: How the joints move.
        bodies: The bodies.
        original: The URDF before joints were locked.
        as_written: Whether nothing is to be found, as of a robot that was saved.
    """
    done, said = [], []
    for hand, why in zip(hands, found, strict=True):
        if why:
            said.append(f"T{called(hand.name)[1:]} is {hand.frame}, {why}.")
        if as_written:
            done.append(hand)
            continue
        shape, given = hand_shape(mechanism, bodies, original, hand.frame), hand.pointing
        if given is None:
            hand = replace(hand, pointing=shape.pointing or ((0.0, 0.0, 1.0) if TOOL.search(hand.frame) else None))
        if given is None and hand.pointing is not None:
            along = " ".join(f"{x:g}" for x in hand.pointing)
            reason = "as its fingers do" if shape.pointing else "by custom, as no fingers say otherwise"
            said.append(f"T{called(hand.name)[1:]} points along {along} of {hand.frame}, {reason}.")
        if shape.ahead > AHEAD and shape.pointing == hand.pointing:
            said.append(f"The fingers of the hand {hand.name} end {shape.ahead:.2f} m in front of {hand.frame}.")
        if shape.around and why:
            around = ", ".join(shape.around)
            said.append(f"The point of the hand {hand.name}, {hand.frame}, is inside of the body of {around}.")
        done.append(hand)
    return done, said


def hand_shape(mechanism: Mechanism, bodies: pin.GeometryModel, original: Urdf, frame: str) -> HandShape:
    """Return what the bodies of a hand say of it.

    Fingers are bodies that move with the frame and hang on joints behind the arm in the original, or are called so.
    They point from the origins of their links to their middle.

    Args:
        mechanism: How the joints move.
        bodies: The bodies.
        original: The URDF before joints were locked.
        frame: The frame of the hand.
    """
    model = mechanism.model
    index = model.getFrameId(frame)
    joint, placement = model.frames[index].parentJoint, model.frames[index].placement.copy()
    own = [body for body in bodies.geometryObjects if body.parentJoint == joint]
    inside = dict.fromkeys(model.frames[b.parentFrame].name for b in own if _contains(b, placement.translation))
    arm = set(moving_before(original, frame))
    corners, begins = [], []
    for body in own:
        link = model.frames[body.parentFrame].name
        is_behind_arm = link in original.links and not set(moving_before(original, link)) <= arm
        if is_behind_arm or FINGER.search(link):
            corners.append(np.array(list(_corners(body))))
            begins.append(model.frames[body.parentFrame].placement.translation.copy())
    if not corners:
        return HandShape(None, 0.0, tuple(inside))
    ahead = np.mean([c.mean(axis=0) for c in corners], axis=0) - np.mean(begins, axis=0)
    length = float(np.linalg.norm(ahead))
    if length == 0.0:
        return HandShape(None, 0.0, tuple(inside))
    direction = placement.rotation.T @ ahead / length
    axis = int(abs(direction).argmax())
    if abs(direction[axis]) < ALONG:
        return HandShape(None, 0.0, tuple(inside))
    pointing = np.sign(direction[axis]) * np.eye(3)[axis] + 0.0
    reach = ((np.vstack(corners) - placement.translation) @ placement.rotation @ pointing).max()
    return HandShape(triple(pointing), max(0.0, float(reach)), tuple(inside))


def _corners(body: pin.GeometryObject) -> Iterator[Array]:
    """Yield corners of a body, or of the box around it, in the frame of its joint, m."""
    shape = body.geometry
    if hasattr(shape, "num_points"):
        yield from (body.placement.act(shape.point(i)) for i in range(shape.num_points))
        return
    shape.computeLocalAABB()
    low, high = shape.aabb_local.min_, shape.aabb_local.max_
    for k in np.ndindex(2, 2, 2):
        yield body.placement.act(np.where(k, high, low))


def _contains(body: pin.GeometryObject, point: Array) -> bool:
    """Return whether a body contains a point in the frame of its joint."""
    result, here = coal.CollisionResult(), pin.SE3(np.eye(3), point)
    ball, request = coal.Sphere(POINT), coal.CollisionRequest()
    coal.collide(body.geometry, coal_placement(body.placement), ball, coal_placement(here), request, result)
    return bool(result.isCollision())
