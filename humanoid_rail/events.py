"""What happens to objects along a motion: when a hand comes near one, grasps it, releases it and is away from it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


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
    """Something that happens to an object at a time of a motion."""

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

    def __str__(self) -> str:
        by = f" by {' and '.join(self.hands)}" if self.hands else ""
        return f"{self.kind} {self.object}{by}"
