"""Which pairs of collision bodies are checked against each other, and what is left out."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.far_parts import FarParts, far_parts, may_meet, part_distance
from humanoid_rail.model.urdf import Urdf
from humanoid_rail.model.urdf_link import Link, MeshFile


@dataclass(frozen=True)
class UncheckedPair:
    """Two links whose bodies are not checked against each other, or only in part."""

    link: str
    other: str
    why: str
    """Why, and what is known of them nevertheless."""

    def __str__(self) -> str:
        return f"{self.link} and {self.other}: {self.why}"


@dataclass(frozen=True)
class Pairs:
    """The pairs of a robot's collision bodies."""

    checked: tuple[tuple[int, int], ...]
    """By index in the collision model."""
    left_out: tuple[UncheckedPair, ...]
    """The others."""


NO_JOINT = "no joint moves them relative to each other"
"""This is said of bodies that nothing moves relative to each other."""
DISABLED = "disabled by the SRDF"
"""This is said of pairs that are left out because the SRDF says so."""
NOWHERE = "not checked anywhere"
"""This is said of pairs that are left out and have no far parts, or parts that touch at the start."""
NO_MEETING = "within the limits they do not meet"
"""This is said of pairs whose far parts cannot touch."""
IN_PART = "checked only"
"""This is said of pairs whose far parts are checked."""
NOT_AMONG = "not among the robot's self_collision_pairs"
"""This is said of pairs of which nothing else is known."""
NEITHER_MOVES = "neither moves"
"""This is said of a link and an obstacle that never move."""


def choose_pairs(
    model: pin.Model, collision_model: pin.GeometryModel, disabled: Mapping[frozenset[str], str], q: Array
) -> Pairs:
    """Return which pairs of bodies of different links are checked: all but those that are disabled.

    Of these, neighbours that can meet away from the joint between them are checked there: their far
    parts are added to the collision model (:mod:`humanoid_rail.model.far_parts`).

    Args:
        model: All joints with their limits.
        collision_model: The bodies. Far parts are added at its end.
        disabled: Pairs of links that need not be checked, with the reason.
        q: Configuration (model.nq,) of all joints where the robot starts.
    """
    # Copies: those in the model move in memory where it grows.
    bodies = [body.copy() for body in collision_model.geometryObjects]
    links = [model.frames[body.parentFrame].name for body in bodies]
    checked, parts = list[tuple[int, int]](), list[tuple[int, int]]()
    known: dict[tuple[str, str], list[str]] = {}
    for (i, a), (j, b) in combinations(enumerate(links), 2):
        if a == b:  # bodies of one link are one body
            continue
        reason = disabled.get(frozenset((a, b)))
        if reason is None:
            checked.append((i, j))
            continue
        far, why = far_pair(model, bodies[i], bodies[j], q)
        if far is not None and why.startswith(IN_PART):
            parts.append((collision_model.addGeometryObject(far.first), collision_model.addGeometryObject(far.second)))
        of_pair = known.setdefault((a, b), [])
        if why not in of_pair:
            of_pair.append(why)
    left_out = (UncheckedPair(a, b, said(disabled[frozenset((a, b))], whys)) for (a, b), whys in known.items())
    return Pairs((*checked, *parts), tuple(left_out))


def said(reason: str, known: Sequence[str]) -> str:
    """Return why a pair of links is left out, and what is known of its bodies nevertheless."""
    return reason if list(known) == [reason] else f"{reason}; {', of others of their bodies: '.join(known)}"


def far_pair(
    model: pin.Model, first: pin.GeometryObject, second: pin.GeometryObject, q: Array
) -> tuple[FarParts | None, str]:
    """Return the far parts of two bodies that are not checked whole, if there are any, and what is known of the pair.

    Args:
        model: All joints with their limits.
        first: A body.
        second: Another one.
        q: Configuration (model.nq,) of all joints where the robot starts.
    """
    if first.parentJoint == second.parentJoint:
        return None, NO_JOINT
    parts = far_parts(model, first, second)
    if parts is None:
        return None, NOWHERE
    beyond = _beyond(parts)
    if not may_meet(model, parts, q):
        return parts, f"{NO_MEETING} {beyond}"
    if part_distance(model, model.createData(), parts, q) <= 0.0:
        return parts, f"{NOWHERE}: where the robot starts they touch {beyond}"
    return parts, checked_in_part(parts)


def checked_in_part(parts: FarParts) -> str:
    """Return what is said of a pair whose far parts are checked."""
    return f"{IN_PART} {_beyond(parts)}"


def _beyond(parts: FarParts) -> str:
    return f"farther than {parts.distance:.4g} m from the joint between them"


def reason_of(pair: UncheckedPair) -> str:
    """Return why a pair was left out, without what :func:`choose_pairs` adds."""
    why, _, known = pair.why.rpartition("; ")
    return why if why and known.startswith((NO_JOINT, NOWHERE, NO_MEETING, IN_PART)) else pair.why


def disabled_pairs(model: pin.Model, srdf: str | None) -> dict[frozenset[str], str]:
    """Return the pairs of links that an SRDF disables, with the reason.

    Args:
        model: All joints.
        srdf: SRDF text, if any.

    Raises:
        InvalidInput: If the text is no SRDF, or names a link that the robot does not have.
    """
    try:
        pairs = ElementTree.fromstring(srdf).findall("disable_collisions") if srdf else []
        disabled = {frozenset((pair.attrib["link1"], pair.attrib["link2"])) for pair in pairs}
    except (ElementTree.ParseError, KeyError) as error:
        raise InvalidInput("srdf", srdf, f"SRDF whose disable_collisions have link1 and link2 ({error})") from error
    for link in frozenset().union(*disabled):
        if not model.existFrame(link):
            raise InvalidInput("srdf.disable_collisions", link, "a link of the URDF")
    return dict.fromkeys(disabled, DISABLED)


def rigid_pairs(model: pin.Model, bodies: pin.GeometryModel) -> dict[frozenset[str], str]:
    """Return the pairs of links with bodies that no joint moves relative to each other, with that as the reason.

    Args:
        model: All joints.
        bodies: The bodies.
    """
    links = [model.frames[body.parentFrame].name for body in bodies.geometryObjects]
    return {
        frozenset((links[i], links[j])): NO_JOINT
        for (i, a), (j, b) in combinations(enumerate(bodies.geometryObjects), 2)
        if a.parentJoint == b.parentJoint and links[i] != links[j]
    }


def unchecked_pairs(
    links: tuple[str, ...],
    checked: tuple[tuple[int, int], ...],
    known: tuple[UncheckedPair, ...],
    objects: Collection[str] = (),
) -> Iterator[UncheckedPair]:
    """Yield the pairs of links that have bodies which are not checked against each other.

    Args:
        links: The link of each body.
        checked: The pairs of bodies that are checked.
        known: What is known of some pairs; nothing of others, where the pairs of a robot were replaced.
        objects: Links that are no part of the robot. All that has to be said of their pairs is known.
    """
    reasons = {frozenset((pair.link, pair.other)): pair.why for pair in known}
    some = {frozenset((links[i], links[j])) for i, j in checked}
    for a, b in combinations(dict.fromkeys(links), 2):
        pair = frozenset((a, b))
        if pair in reasons or (pair not in some and pair.isdisjoint(objects)):
            yield UncheckedPair(a, b, reasons.get(pair, NOT_AMONG))


def links_without_body(
    urdf: Urdf, links: Collection[str], hands: Collection[str] = (), fixed: Collection[str] = ()
) -> tuple[str, ...]:
    """Return the links of a URDF that are visible or have a mass, and no collision body.

    Those that would be hit first come first: hands, then the others by how far what is seen of them reaches from their
    frame, then those that nothing moves.

    Args:
        urdf: All links.
        links: The links that have one.
        hands: The links of hands.
        fixed: The links that no joint moves.
    """
    bare = [link for link in urdf.links.values() if link.name not in links and (link.visuals or link.inertial)]
    bare.sort(key=lambda link: (link.name not in hands, link.name in fixed, -_seen_reach(link)))
    return tuple(link.name for link in bare)


def _seen_reach(link: Link) -> float:
    """Return how far the visual bodies of a link reach from its frame, m; of meshes that is not known: infinity."""
    reaches = [0.0]
    for body in link.visuals:
        if isinstance(body.shape, MeshFile):
            return np.inf
        body.shape.computeLocalAABB()
        middle = body.placement.act(body.shape.aabb_center)
        reaches.append(float(np.linalg.norm(middle)) + body.shape.aabb_radius)
    return max(reaches)
