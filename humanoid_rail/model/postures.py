"""Postures of a robot with a name, and where its motions start."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.model.position_limits import beyond_limits
from humanoid_rail.model.robot_file import RobotFile

Posture = Mapping[str, float]
"""Positions of some joints by their names, m and rad."""


@dataclass(frozen=True, eq=False)
class MovingJoints:
    """The actuated joints as far as postures have to know them; n is their number."""

    names: tuple[str, ...]
    lower: Array
    """(n,), m and rad."""
    upper: Array
    """(n,), m and rad."""

    def range_of(self, name: str) -> str:
        """Return the position limits of a joint in words."""
        i = self.names.index(name)
        return f"a position within {float(self.lower[i])!r} to {float(self.upper[i])!r}"

    def beyond(self, posture: Posture) -> tuple[str, ...]:
        """Return the joints that a posture has beyond their limits by more than rounding."""
        q = self.filled(self.middle, posture)
        return tuple(self.names[i] for i in beyond_limits(q, self.lower, self.upper))

    @property
    def middle(self) -> Array:
        """The middle of all limits (n,), m and rad."""
        middle: Array = (self.lower + self.upper) / 2.0
        return middle

    def filled(self, otherwise: Array, posture: Posture) -> Array:
        """Return a posture as a configuration (n,), with the joints that it does not name where they are otherwise."""
        return np.array([posture.get(name, otherwise[i]) for i, name in enumerate(self.names)], float)


@dataclass(frozen=True)
class Postures:
    """Postures by name."""

    able: Mapping[str, Posture]
    """Those that the robot can have."""
    unable: Mapping[str, str]
    """Those of the SRDF that it cannot have, with the reason."""


def named_postures(joints: MovingJoints, known: Sequence[str], srdf: Element | None, file: RobotFile) -> Postures:
    """Return the postures of an SRDF (`group_state`) and of a robot file, of the joints that move.

    States of the SRDF with the same name are one posture; those of a robot file come before them.

    Args:
        joints: The actuated joints.
        known: All joints of the URDF; positions of those that do not move do not count.
        srdf: The SRDF, if any.
        file: The robot file.

    Raises:
        InvalidInput: If a posture of the robot file names a joint that the URDF does not have or has one beyond its
            limits, or one of the SRDF is no number.
    """
    found: dict[str, dict[str, float]] = {}
    for state in srdf.findall("group_state") if srdf is not None else ():
        for joint in state.findall("joint"):
            name, value = joint.get("name", ""), joint.get("value", "")
            if name in joints.names:
                found.setdefault(state.get("name", ""), {})[name] = _number(state, name, value)
    beyond = {posture: names for posture, at in found.items() if (names := joints.beyond(at))}
    unable = {
        posture: ", ".join(f"{name} at {found[posture][name]:.6g} is not {joints.range_of(name)}" for name in names)
        for posture, names in beyond.items()
        if posture not in file.postures
    }
    able: dict[str, Posture] = {posture: at for posture, at in found.items() if posture not in unable}
    for posture, positions in file.postures.items():
        where = f"postures.{posture}"
        at = {n: x for n, x in checked_names(where, positions, known).items() if n in joints.names}
        _check_limits(where, joints, at)
        able[posture] = at
    return Postures(able, unable)


def checked_names(field: str, positions: Posture, known: Sequence[str]) -> Posture:
    """Return positions by joint.

    Raises:
        InvalidInput: If a joint is not known.
    """
    for name in positions:
        if name not in known:
            raise InvalidInput(f"{field}.{name}", positions[name], f"a joint of the robot{did_you_mean(name, known)}")
    return positions


def _check_limits(where: str, joints: MovingJoints, posture: Posture) -> None:
    for name in joints.beyond(posture):
        raise InvalidInput(f"{where}.{name}", posture[name], joints.range_of(name))


def starts(joints: MovingJoints, postures: Postures, file: RobotFile) -> Iterator[tuple[str, Array]]:
    """Yield where motions could start (n,), the best place first, and what each is called.

    Args:
        joints: The actuated joints.
        postures: Those with a name.
        file: The robot file; what it says of the start is the only place.

    Raises:
        InvalidInput: If the robot file names a posture or a joint that is not there, or a position beyond a limit.
    """
    middle, names = joints.middle, joints.names

    def place(posture: Posture) -> Array:
        # Rounding beyond a limit is put onto it.
        return np.clip(joints.filled(middle, posture), joints.lower, joints.upper)

    match file.initial:
        case None:
            for name, posture in postures.able.items():
                yield f"the posture {name}", place(posture)
            yield "the middle of all limits", middle
            yield "0, or the limit next to it", np.clip(np.zeros(len(names)), joints.lower, joints.upper)
        case str(name):
            if name in postures.unable:
                raise InvalidInput("initial", name, f"a posture that the robot can have: {postures.unable[name]}")
            if name not in postures.able:
                able = list(postures.able)
                valid = f"one of the robot's postures{did_you_mean(name, able)}: {', '.join(able) or 'none'}"
                raise InvalidInput("initial", name, valid)
            yield f"the posture {name}", place(postures.able[name])
        case Mapping() as positions:
            for name in positions:
                if name not in names:
                    valid = f"a joint that moves{did_you_mean(name, names)}: {', '.join(names)}"
                    raise InvalidInput(f"initial.{name}", positions[name], valid)
            _check_limits("initial", joints, positions)
            yield "what is given", place(positions)
        case positions:
            if len(positions) != len(names):
                raise InvalidInput("initial", list(positions), f"{len(names)} numbers, for {', '.join(names)}")
            given = dict(zip(names, positions, strict=True))
            _check_limits("initial", joints, given)
            yield "what is given", place(given)


def _number(state: Element, joint: str, value: str) -> float:
    try:
        return float(value)
    except ValueError:
        where = f"srdf.group_state {state.get('name')}.{joint}"
        raise InvalidInput(where, value, "a number, m or rad") from None
