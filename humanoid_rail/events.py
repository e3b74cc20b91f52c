"""What happens to objects along a motion: when a hand comes near one, grasps it, releases it and is away from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput, did_you_mean

UNIT = 1e-6
"""The length of a quaternion differs by less than this from 1."""


class EventKind(StrEnum):
    """What happens."""

    APPROACH = "approach"
    """From then on hands may touch the object that they are about to grasp, or a held one what it is put down on."""
    GRASP = "grasp"
    """From then on the object moves with the hand."""
    RELEASE = "release"
    """From then on the object stands where it is."""
    CLEAR = "clear"
    """From then on the object touches nothing but what holds it."""


@dataclass(frozen=True)
class Event:
    """Something that happens to an object at a time of a motion.

    Raises:
        InvalidInput: If a field is not valid.
    """

    t: float
    """When, s."""
    kind: str
    """`approach`, `grasp`, `release` or `clear`."""
    object: str
    """The name of the object."""
    hands: tuple[str, ...]
    """The hands that do it, or did it before; the object moves with the first one while it is held."""
    position: tuple[float, float, float]
    """Where the object's frame is then, in the base frame, m."""
    quaternion: tuple[float, float, float, float]
    """How it is turned then, in the base frame: w, x, y, z."""
    contacts: tuple[str, ...] = ()
    """What the object may touch from then on until the next of its events: hands, other objects and obstacles by their
    names. It is not checked against these meanwhile, and the certificate says so."""

    def __post_init__(self) -> None:
        if self.kind not in list(EventKind):
            near = did_you_mean(str(self.kind), list(EventKind))
            raise InvalidInput("event.kind", self.kind, f"one of {', '.join(EventKind)}{near}")
        if not np.isfinite(self.t) or self.t < 0.0:
            raise InvalidInput("event.t", self.t, "a time from 0, s")
        if isinstance(self.hands, str) or len(set(self.hands)) < len(self.hands):
            raise InvalidInput("event.hands", self.hands, "the names of hands, each once")
        if isinstance(self.contacts, str):
            raise InvalidInput("event.contacts", self.contacts, "a list of names")
        if len(self.position) != 3 or not np.isfinite(self.position).all():
            raise InvalidInput("event.position", self.position, "three finite numbers, m")
        if len(self.quaternion) != 4 or not abs(np.linalg.norm(self.quaternion) - 1.0) < UNIT:
            raise InvalidInput("event.quaternion", self.quaternion, "four numbers w, x, y, z, of length 1")
        # Plain values, so that files and sentences have them whatever they were given as.
        plain = {"t": float(self.t), "kind": str(self.kind), "hands": tuple(self.hands)}
        plain |= {name: tuple(map(float, getattr(self, name))) for name in ("position", "quaternion")}
        for name, value in plain.items():
            object.__setattr__(self, name, value)

    def __str__(self) -> str:
        by = f" by {' and '.join(self.hands)}" if self.hands else ""
        return f"{self.kind} {self.object}{by}"


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
