"""Which pairs of links need not be checked, and which bodies are always near each other, as random postures show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from xml.etree.ElementTree import Element

import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.model.pairs import DISABLED, rigid_pairs
from humanoid_rail.model.robot_file import DistanceEntry, PairsEntry
from humanoid_rail.model.survey import ALWAYS_NEAR, POSTURES, Survey
from humanoid_rail.model.urdf import Urdf

KEPT = 1e-3
"""Two bodies that are always near each other are kept at most this far apart, m."""
SHARE = 0.5
"""If these never touch, they are kept apart by no more than this share of their least distance; else by no more than
this share of their largest one."""


@dataclass(frozen=True)
class FoundPairs:
    """Pairs that are not like others."""

    left_out: Mapping[frozenset[str], str]
    """Pairs of links that are not checked against each other, with the reason."""
    distances: Mapping[tuple[int, int], float]
    """How far apart bodies are kept that are always near each other, by index, the lower one first, m."""


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
    """Return the pairs of links that are left out, and those of bodies that are always near each other.

    Left out are links that no joint moves relative to each other, those that an SRDF or a robot file leaves out,
    neighbours in the URDF, and those that touch in each of the random postures. How often a pair touches is said with
    the reason.

    Args:
        model: All joints.
        bodies: The bodies.
        urdf: The robot.
        srdf: Its SRDF, if any.
        seen: What is known of all pairs that are on different joints; None if the robot file says all.
        given: What a robot file says beside that.

    Raises:
        InvalidInput: If a robot file names a link or a body that is not there.
    """
    links = [model.frames[body.parentFrame].name for body in bodies.geometryObjects]
    left_out = rigid_pairs(model, bodies)
    named = {_named(links, entry.links): entry.why for entry in given.left_out}
    own = {pair: entry.distance for entry in given.distances for pair in _bodies(links, entry)}
    if seen is None:
        return FoundPairs(left_out | named, own)
    left_out |= _reasons(links, urdf, srdf, seen, named)
    return FoundPairs(left_out, _always_near(links, seen, left_out) | own)


def _named(links: Sequence[str], pair: tuple[str, str]) -> frozenset[str]:
    for link in pair:
        if link not in links:
            known = sorted(set(links))
            raise InvalidInput(
                "pairs.links", link, f"a link with a body{did_you_mean(link, known)}: {', '.join(known)}"
            )
    return frozenset(pair)


def _bodies(links: Sequence[str], entry: DistanceEntry) -> list[tuple[int, int]]:
    """Return the bodies of two links that an entry of a robot file is about, by index."""
    _named(links, entry.links)
    of_links = [[i for i, link in enumerate(links) if link == name] for name in entry.links]
    if entry.bodies is not None:
        for name, there, number in zip(entry.links, of_links, entry.bodies, strict=True):
            if number >= len(there):
                raise InvalidInput("pairs.bodies", number, f"less than {len(there)}, the bodies of {name}")
        of_links = [[there[number]] for there, number in zip(of_links, entry.bodies, strict=True)]
    return [(min(i, j), max(i, j)) for i in of_links[0] for j in of_links[1]]


def _disabled(srdf: Element | None) -> dict[frozenset[str], str]:
    """Return the pairs that an SRDF disables and does not enable again, with the reason that it gives."""
    found: dict[frozenset[str], str] = {}
    for pair in srdf.findall("disable_collisions") if srdf is not None else ():
        link, other = pair.get("link1"), pair.get("link2")
        if link is None or other is None:
            raise InvalidInput("srdf.disable_collisions", dict(pair.attrib), "link1 and link2")
        why = pair.get("reason")
        found[frozenset((link, other))] = f"{DISABLED} ({why})" if why else DISABLED
    for pair in srdf.findall("enable_collisions") if srdf is not None else ():
        found.pop(frozenset((pair.get("link1", ""), pair.get("link2", ""))), None)
    return found


def _reasons(
    links: Sequence[str], urdf: Urdf, srdf: Element | None, seen: Survey, named: Mapping[frozenset[str], str]
) -> dict[frozenset[str], str]:
    disabled, neighbours, found = {**_disabled(srdf), **named}, _neighbours(urdf), {}
    for pair, touches in _touching(links, seen).items():
        share = f"they touch in {touches.mean():.0%} of {len(touches)} random postures"
        if pair in disabled:
            found[pair] = f"{disabled[pair]}; {share}"
        elif pair in neighbours:
            found[pair] = f"neighbours at {neighbours[pair]}; {share}"
        elif len(touches) >= POSTURES // 2 and touches.all():
            found[pair] = share
    return found


def _neighbours(urdf: Urdf) -> dict[frozenset[str], str]:
    """Return the links with only joints and links without bodies between them, and the names of these joints."""
    above, found = {joint.child: joint for joint in urdf.joints.values()}, {}
    for name, link in urdf.links.items():
        if not link.collisions:
            continue
        joints, other = [], name
        while other in above and (other == name or not urdf.links[other].collisions):
            joints.append(above[other])
            other = above[other].parent
        if joints and urdf.links[other].collisions:
            moving = [joint.name for joint in reversed(joints) if joint.kind != "fixed"]
            found[frozenset((name, other))] = f"the joint{'s' * (len(moving) > 1)} {', '.join(moving)}"
    return found


def _touching(links: Sequence[str], seen: Survey) -> dict[frozenset[str], Array]:
    """Return for each pair of links in which postures it touches (N,)."""
    found: dict[frozenset[str], Array] = {}
    for (i, j), column in zip(seen.pairs, seen.touching().T, strict=True):
        pair = frozenset((links[i], links[j]))
        found[pair] = found[pair] | column if pair in found else column
    return found


def _always_near(
    links: Sequence[str], seen: Survey, left_out: Mapping[frozenset[str], str]
) -> dict[tuple[int, int], float]:
    found: dict[tuple[int, int], float] = {}
    for (i, j), column in zip(seen.pairs, seen.distances.T, strict=True):
        least, largest = float(column.min()), float(column.max())
        if frozenset((links[i], links[j])) not in left_out and 0.0 < largest <= ALWAYS_NEAR:
            found[i, j] = min(KEPT, SHARE * (least if least > 0.0 else largest))
    return found
