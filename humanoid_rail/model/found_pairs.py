"""Which pairs of links need not be checked, and which are always near each other, as random postures show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.model.pairs import DISABLED, NO_JOINT
from humanoid_rail.model.robot_file import PairsEntry
from humanoid_rail.model.survey import NEAR, POSTURES, Survey
from humanoid_rail.model.urdf import Urdf

KEPT = 1e-3
"""A pair that is always near is kept this far apart, or half the least distance that it has, m."""


@dataclass(frozen=True)
class FoundPairs:
    """Pairs of links that are not like others."""

    left_out: Mapping[frozenset[str], str]
    """Pairs that are not checked against each other, with the reason."""
    distances: Mapping[frozenset[str], float]
    """How far apart pairs are kept that are always near each other, m."""


def possible_pairs(bodies: pin.GeometryModel) -> list[tuple[int, int]]:
    """Return the pairs of bodies, by index, that are on different joints."""
    joints = [body.parentJoint for body in bodies.geometryObjects]
    return [(i, j) for i, j in combinations(range(len(joints)), 2) if joints[i] != joints[j]]


def find_pairs(
    model: pin.Model,
    bodies: pin.GeometryModel,
    urdf: Urdf,
    srdf: Element | None,
    seen: Survey | None,
    given: PairsEntry,
) -> FoundPairs:
    """Return the pairs of links that are left out, and those that are always near each other.

    Left out are links that no joint moves relative to each other, those that an SRDF disables, those on both sides of
    one joint, and those that touch in each of the random postures. How often a pair touches is said with the reason.

    Args:
        model: All joints.
        bodies: The bodies.
        urdf: The robot.
        srdf: Its SRDF, if any.
        seen: What is known of all pairs that are on different joints; None if a robot file says all.
        given: What a robot file says instead.

    Raises:
        InvalidInput: If a robot file names a link that has no body.
    """
    links = [model.frames[body.parentFrame].name for body in bodies.geometryObjects]
    left_out = {
        frozenset((links[i], links[j])): NO_JOINT
        for (i, a), (j, b) in combinations(enumerate(bodies.geometryObjects), 2)
        if a.parentJoint == b.parentJoint and links[i] != links[j]
    }
    if given.left_out is not None:
        left_out |= {_named(links, entry.links): entry.why for entry in given.left_out}
    else:
        assert seen is not None
        left_out |= _reasons(model, bodies, links, urdf, srdf, seen)
    if given.distances is not None:
        return FoundPairs(left_out, {_named(links, e.links): e.distance or 0.0 for e in given.distances})
    assert seen is not None
    return FoundPairs(left_out, _always_near(links, seen, left_out))


def unknown_links(srdf: Element | None, urdf: Urdf) -> list[str]:
    """Return the links that an SRDF disables pairs of and a URDF does not have.

    Raises:
        InvalidInput: If a pair of the SRDF does not name two links.
    """
    names = [name for pair in _disabled(srdf) for name in pair]
    return sorted({name for name in names if name not in urdf.links})


def _named(links: Sequence[str], pair: tuple[str, str]) -> frozenset[str]:
    for link in pair:
        if link not in links:
            known = sorted(set(links))
            raise InvalidInput(
                "pairs.links", link, f"a link with a body{did_you_mean(link, known)}: {', '.join(known)}"
            )
    return frozenset(pair)


def _disabled(srdf: Element | None) -> dict[frozenset[str], str]:
    """Return the pairs that an SRDF disables, with the reason that it gives."""
    found = {}
    for pair in srdf.findall("disable_collisions") if srdf is not None else ():
        link, other = pair.get("link1"), pair.get("link2")
        if link is None or other is None:
            raise InvalidInput("srdf.disable_collisions", dict(pair.attrib), "link1 and link2")
        why = pair.get("reason")
        found[frozenset((link, other))] = f"{DISABLED} ({why})" if why else DISABLED
    return found


def _reasons(
    model: pin.Model,
    bodies: pin.GeometryModel,
    links: Sequence[str],
    urdf: Urdf,
    srdf: Element | None,
    seen: Survey,
) -> dict[frozenset[str], str]:
    disabled, found = _disabled(srdf), {}
    for pair, touches in _touching(links, seen).items():
        share = f"they touch in {touches.mean():.0%} of {len(touches)} random postures"
        if pair in disabled:
            found[pair] = f"{disabled[pair]}; {share}"
        elif joint := _joint_between(model, bodies, links, pair):
            found[pair] = f"on both sides of the joint {joint}; {share}"
        elif len(touches) >= POSTURES // 2 and touches.all():
            found[pair] = share
    return found


def _touching(links: Sequence[str], seen: Survey) -> dict[frozenset[str], Array]:
    """Return for each pair of links in which postures it touches (N,)."""
    found: dict[frozenset[str], Array] = {}
    for (i, j), column in zip(seen.pairs, seen.touching().T, strict=True):
        pair = frozenset((links[i], links[j]))
        found[pair] = found[pair] | column if pair in found else column
    return found


def _joint_between(
    model: pin.Model, bodies: pin.GeometryModel, links: Sequence[str], pair: frozenset[str]
) -> str | None:
    """Return the joint that alone moves two links relative to each other; None if there are more."""
    one, other = (bodies.geometryObjects[links.index(link)].parentJoint for link in sorted(pair))
    if model.parents[one] == other:
        return str(model.names[one])
    return str(model.names[other]) if model.parents[other] == one else None


def _always_near(
    links: Sequence[str], seen: Survey, left_out: Mapping[frozenset[str], str]
) -> dict[frozenset[str], float]:
    found: dict[frozenset[str], float] = {}
    for (i, j), column in zip(seen.pairs, seen.distances.T, strict=True):
        pair, apart = frozenset((links[i], links[j])), column[column > 0.0]
        if pair not in left_out and len(apart) and column.max() <= NEAR:
            found[pair] = min(found.get(pair, KEPT), float(np.min(apart)) / 2.0)
    return found
