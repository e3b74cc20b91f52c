"""Events along a motion: hands grasp objects and release them, each at a time and with the object at a pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal, get_args

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput

Kind = Literal["grasp", "release"]
"""What hands do to an object."""
KINDS: tuple[Kind, ...] = get_args(Kind)
UNIT = 1e-6
"""The length of a quaternion differs by less than this from 1."""


@dataclass(frozen=True)
class Event:
    """Hands grasp an object or release it.

    Raises:
        InvalidInput: If a field is not valid.
    """

    t: float
    """When, s from the start of the motion."""
    kind: Kind
    """`grasp` or `release`."""
    object: str
    """The name of the object."""
    hands: tuple[str, ...]
    """The names of the hands, one or more."""
    position: tuple[float, float, float]
    """Where the object's origin is at this time in the base frame, m."""
    quaternion: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    """The object's orientation at this time in the base frame: x, y, z, w, of length 1."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InvalidInput("event.kind", self.kind, f"one of {', '.join(KINDS)}")
        if not np.isfinite(self.t) or self.t < 0.0:
            raise InvalidInput("event.t", self.t, "a time from 0, s")
        if not self.object:
            raise InvalidInput("event.object", self.object, "the name of an object")
        if isinstance(self.hands, str) or not self.hands or len(set(self.hands)) < len(self.hands):
            raise InvalidInput("event.hands", self.hands, "the names of one or more hands, each once")
        if len(self.position) != 3 or not np.isfinite(self.position).all():
            raise InvalidInput("event.position", self.position, "three finite numbers, m")
        if len(self.quaternion) != 4 or not abs(np.linalg.norm(self.quaternion) - 1.0) < UNIT:
            raise InvalidInput("event.quaternion", self.quaternion, "four numbers x, y, z, w, of length 1")
        # Plain numbers, so that files and sentences have them whatever they were given as.
        plain = {"t": float(self.t), "hands": tuple(self.hands)}
        plain |= {name: tuple(map(float, getattr(self, name))) for name in ("position", "quaternion")}
        for name, value in plain.items():
            object.__setattr__(self, name, value)

    def __str__(self) -> str:
        return f"{self.kind} {self.object} by {' and '.join(self.hands)}"


def events_data(events: Sequence[Event]) -> list[dict[str, Any]]:
    """Return events as plain data, as JSON has it."""
    return [{name: list(x) if isinstance(x, tuple) else x for name, x in asdict(event).items()} for event in events]


def read_events(data: Sequence[Mapping[str, Any]]) -> tuple[Event, ...]:
    """Return the events that :func:`events_data` made plain data of.

    Raises:
        InvalidInput: If a field is not valid.
        TypeError: If a field is missing or unknown.
    """
    found = []
    for event in data:
        fields: dict[str, Any] = {name: tuple(x) if isinstance(x, list) else x for name, x in event.items()}
        found.append(Event(**fields))
    return tuple(found)


def notes_at(t: Array, events: Sequence[Event]) -> list[str]:
    """Return what happens at each of the times (N,) in s: the events that are nearest to it, with semicolons between.

    An event that is between two of the times says when it is. Events at one time stay in their order.
    """
    notes: list[list[str]] = [[] for _ in t]
    for event in events:
        i = int(np.argmin(abs(t - event.t)))
        notes[i].append(str(event) if t[i] == event.t else f"{event} at {event.t!r} s")
    return ["; ".join(told) for told in notes]
