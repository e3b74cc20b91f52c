"""Postures of a robot with a name, and where its motions start."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from xml.etree.ElementTree import Element

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.model.robot_file import RobotFile

Posture = Mapping[str, float]
"""Positions of some joints by their names, m and rad."""


def named_postures(
    joints: Sequence[str], known: Sequence[str], srdf: Element | None, file: RobotFile
) -> dict[str, Posture]:
    """Return the postures of an SRDF (`group_state`) and of a robot file, of the joints that move.

    States of the SRDF with the same name are one posture; those of a robot file come before them.

    Args:
        joints: The actuated joints.
        known: All joints of the URDF; positions of those that do not move do not count.
        srdf: The SRDF, if any.
        file: The robot file.

    Raises:
        InvalidInput: If a posture of the robot file names a joint that the URDF does not have, or one of the SRDF is
            no number.
    """
    found: dict[str, dict[str, float]] = {}
    for state in srdf.findall("group_state") if srdf is not None else ():
        for joint in state.findall("joint"):
            name, value = joint.get("name", ""), joint.get("value", "")
            if name in joints:
                found.setdefault(state.get("name", ""), {})[name] = _number(state, name, value)
    for posture, positions in file.postures.items():
        found[posture] = {
            n: x for n, x in checked_names(f"postures.{posture}", positions, known).items() if n in joints
        }
    return dict(found)


def checked_names(field: str, positions: Posture, known: Sequence[str]) -> Posture:
    """Return positions by joint.

    Raises:
        InvalidInput: If a joint is not known.
    """
    for name in positions:
        if name not in known:
            raise InvalidInput(f"{field}.{name}", positions[name], f"a joint of the robot{did_you_mean(name, known)}")
    return positions


def starts(
    joints: Sequence[str], lower: Array, upper: Array, postures: Mapping[str, Posture], file: RobotFile
) -> Iterator[tuple[str, Array]]:
    """Yield where motions could start (n,), the best place first, and what each is called.

    Args:
        joints: The actuated joints.
        lower: Their lower limits (n,).
        upper: Their upper limits (n,).
        postures: Those with a name.
        file: The robot file; what it says of the start is the only place.

    Raises:
        InvalidInput: If the robot file names a posture or a joint that is not there.
    """
    middle = (lower + upper) / 2.0
    match file.initial:
        case None:
            for name, posture in postures.items():
                yield f"the posture {name}", _filled(joints, middle, posture)
            yield "the middle of all limits", middle
            yield "0, or the limit next to it", np.clip(np.zeros(len(joints)), lower, upper)
        case str(name):
            if name not in postures:
                valid = (
                    f"one of the robot's postures{did_you_mean(name, list(postures))}: {', '.join(postures) or 'none'}"
                )
                raise InvalidInput("initial", name, valid)
            yield f"the posture {name}", _filled(joints, middle, postures[name])
        case Mapping() as positions:
            for name in positions:
                if name not in joints:
                    valid = f"a joint that moves{did_you_mean(name, joints)}: {', '.join(joints)}"
                    raise InvalidInput(f"initial.{name}", positions[name], valid)
            yield "what is given", _filled(joints, middle, positions)
        case positions:
            if len(positions) != len(joints):
                raise InvalidInput("initial", list(positions), f"{len(joints)} numbers, for {', '.join(joints)}")
            yield "what is given", np.array(positions, float)


def configuration(joints: Sequence[str], otherwise: Array, posture: Posture) -> tuple[float, ...]:
    """Return a posture as a configuration (n,), with the joints that it does not name where they are otherwise."""
    return tuple(_filled(joints, otherwise, posture).tolist())


def _filled(joints: Sequence[str], otherwise: Array, posture: Posture) -> Array:
    return np.array([posture.get(name, otherwise[i]) for i, name in enumerate(joints)], float)


def _number(state: Element, joint: str, value: str) -> float:
    try:
        return float(value)
    except ValueError:
        where = f"srdf.group_state {state.get('name')}.{joint}"
        raise InvalidInput(where, value, "a number, m or rad") from None
