"""The smallest shift of a target with which there is a configuration clear of everything."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.inverse_kinematics import Posture
from humanoid_rail.kinematics.task import Task
from humanoid_rail.planning.probe import Probe, hand_of, hands_with_targets, shifted

FIRST_RADIUS = 0.005
"""The first shifts that are tried have this length, m."""
GROWTH = 1.6
"""The next ones are this many times as long."""
RADII = 13
"""So many lengths are tried, up to 1.4 m."""
HALVINGS = 5
"""The length of a shift is narrowed down by half so often."""
NEAR_STARTS = 3
"""Each shift is tried from so many starts."""
MILLIMETRE = 1e-3
AXES_FIRST = 1.15
"""A shift along an axis is taken where no other is shorter by more than this factor: it is easier to make."""

_DIRECTIONS = sorted(
    (np.array(d, float) / np.linalg.norm(d) for d in product((-1, 0, 1), repeat=3) if any(d)),
    key=lambda d: np.count_nonzero(d),
)


def shifted_targets(
    probe: Probe, tasks: Sequence[Task], starts: Sequence[Array]
) -> tuple[tuple[Task, ...], Array] | None:
    """Return tasks with some hands' targets shifted, and a configuration (n,) in which they are done.

    The targets are shifted that cannot be reached by their hands alone; where each can, that of the hand that needs the
    smallest shift.

    Args:
        probe: What tries it.
        tasks: What is to be reached.
        starts: Configurations (n,) near which to look, m and rad.
    """
    hands = hands_with_targets(tasks)
    alone = {hand: [task for task in tasks if hand_of(task) == hand] for hand in hands}
    blocked = [hand for hand in hands if len(hands) > 1 and probe.posture(alone[hand], near=starts) is None]
    if not blocked:
        found = [(hand, _smallest_shift(probe, tasks, hand, starts)) for hand in hands]
        made = [(hand, *shift) for hand, shift in found if shift is not None]
        if not made:
            return None
        hand, shift, q = min(made, key=lambda one: float(np.linalg.norm(one[1])))
        return shifted(tasks, hand, shift), q
    settled = [task for task in tasks if hand_of(task) not in blocked]
    q = starts[0]
    for hand in blocked:
        one = _smallest_shift(probe, [*settled, *alone[hand]], hand, starts)
        if one is None:
            return None
        shift, q = one
        tasks = shifted(tasks, hand, shift)
        settled += [task for task in tasks if hand_of(task) == hand]
        starts = [q, *starts]
    return tuple(tasks), q


def _smallest_shift(
    probe: Probe, tasks: Sequence[Task], hand: str, starts: Sequence[Array]
) -> tuple[Array, Array] | None:
    """Return the smallest shift (3,) in m of a hand's target that was found, and a configuration (n,) there."""
    shorter = 0.0
    for k in range(RADII):
        radius = FIRST_RADIUS * GROWTH**k
        found = []
        for direction in _DIRECTIONS:
            if probe.is_over:
                return None
            q = _at(probe, tasks, hand, radius * direction, starts)
            if q is not None:
                found.append(_narrowed(probe, tasks, hand, direction, (shorter, radius), q))
        if found:
            _, shift, q = min(found, key=lambda one: one[0] if np.count_nonzero(one[1]) == 1 else AXES_FIRST * one[0])
            return shift, q
        shorter = radius
    return None


def _at(probe: Probe, tasks: Sequence[Task], hand: str, shift: Array, starts: Sequence[Array]) -> Array | None:
    moved = shifted(tasks, hand, shift)
    for start in starts[:NEAR_STARTS]:
        found: Posture = probe.solve(start, moved)
        if found.reached:
            return found.q
    return None


def _narrowed(
    probe: Probe, tasks: Sequence[Task], hand: str, direction: Array, bounds: tuple[float, float], q: Array
) -> tuple[float, Array, Array]:
    """Return the length of a shift in a direction between two bounds in m, the shift (3,), and a configuration there.

    It is a number of whole millimetres along each axis.
    """
    low, high = bounds
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        there = _at(probe, tasks, hand, middle * direction, [q])
        low, high, q = (middle, high, q) if there is None else (low, middle, there)
    rounded = np.sign(direction) * np.ceil(high * np.abs(direction) / MILLIMETRE - 1e-9) * MILLIMETRE
    there = _at(probe, tasks, hand, rounded, [q])
    return (high, high * direction, q) if there is None else (float(np.linalg.norm(rounded)), rounded, there)
