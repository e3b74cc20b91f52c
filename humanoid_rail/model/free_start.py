"""A place where the motions of a robot can start: nothing that is checked touches there."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.model.building import Mechanism
from humanoid_rail.model.found_pairs import FoundPairs, possible_pairs
from humanoid_rail.model.survey import ALWAYS_NEAR, NEAR, random_postures, survey

MOST_PAIRS = 3
"""No more pairs than this are named."""
LEAVE_OUT = "name them in pairs.left_out if that is how the robot is built"
"""What can be done about links that touch wherever it was looked."""


def free_start(
    mechanism: Mechanism,
    bodies: pin.GeometryModel,
    pairs: FoundPairs,
    places: Sequence[tuple[str, Array]],
    is_given: bool,
) -> tuple[Array, str]:
    """Return the first place (n,), m and rad, at which all pairs keep their distance, and what it is called.

    After the places come random postures, unless the place is given. At that one nothing has to do more than not touch.

    Args:
        mechanism: How the joints move.
        bodies: The bodies.
        pairs: Which of them are not checked, and the distances of others.
        places: Where motions could start, and what each place is called.
        is_given: Whether the first place is the only one.

    Raises:
        InvalidInput: If there is none; the error names the links that are in the way most often, and how often.
    """
    links = [mechanism.model.frames[body.parentFrame].name for body in bodies.geometryObjects]
    checked = [(i, j) for i, j in possible_pairs(bodies) if frozenset((links[i], links[j])) not in pairs.left_out]
    room = np.array([0.0 if is_given else pairs.distances.get(pair, ALWAYS_NEAR) for pair in checked])
    in_the_way, count = Counter[str](), 0
    for why, q in places if is_given else _with_random(mechanism, places):
        distances = survey(mechanism.model, bodies, checked, q[None], mechanism.full_configuration).distances[0]
        near = np.flatnonzero(np.minimum(distances, NEAR) <= room)
        if not len(near):
            before = f"; at {count} places before it too near each other are {_often(in_the_way, count)}"
            return q, why + (before if count else "")
        count += 1
        in_the_way.update({" and ".join(links[index] for index in checked[int(k)]) for k in near})
    if is_given:
        worst = ", ".join(names for names, _ in in_the_way.most_common(MOST_PAIRS))
        said = f"one at which nothing touches; there {worst} do; {LEAVE_OUT}"
        raise InvalidInput("initial", places[0][1].tolist(), said)
    said = f"one at which nothing touches, by initial=...; of {count} postures that were tried none is free: too near "
    raise InvalidInput("initial", MISSING, f"{said}each other are {_often(in_the_way, count)}; {LEAVE_OUT}")


def _often(pairs: Counter[str], count: int) -> str:
    """Return the pairs that are too near each other most often, and in which share of a number of places."""
    return ", ".join(f"{names} in {times / count:.0%}" for names, times in pairs.most_common(MOST_PAIRS))


def _with_random(mechanism: Mechanism, places: Sequence[tuple[str, Array]]) -> Iterator[tuple[str, Array]]:
    yield from places
    for q in random_postures(mechanism.limits.lower, mechanism.limits.upper):
        yield "a random posture, the first that is free", q
