"""Why a plan failed, as frozen plain data; :mod:`humanoid_rail.planning.diagnosing` finds it out."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from humanoid_rail.model.robot import called

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Miss:
    """How far a hand is from its target at the nearest miss."""

    hand: str
    """Name of the hand."""
    position: Vector
    """Where the hand is, in the base frame, m."""
    target: Vector
    """Where it should be, in the base frame, m."""

    @property
    def distance(self) -> float:
        """How far the hand is from its target, m."""
        return float(np.linalg.norm(np.subtract(self.target, self.position)))


@dataclass(frozen=True)
class BlockingPair:
    """A link, and what keeps it from going on."""

    link: str
    """Name of the link."""
    other: str
    """The obstacle as messages call it, or the other link."""
    obstacle: int | None
    """Index of the obstacle; None if it is a link."""
    clearance: float
    """How far apart the two are at the nearest miss, m; negative in penetration."""
    beyond: float
    """The same where the motion would have to go on to, m: with the hands at their targets, or, where these can be
    reached by no path, at the first configuration of a straight line to there that does not keep the distance."""


TRIED = {
    "planned": "tried: auto finds a plan",
    "posture": "tried: there is a configuration, and no path was found in a short search",
}
"""How a remedy was tried out, in words, by `Remedy.proven`."""


@dataclass(frozen=True)
class Remedy:
    """A change that would help. The fields that it is not about are empty."""

    what: str
    """The change in words."""
    proven: str
    """What was done to find out: `planned`, a plan of the changed problem was made, or `posture`, a configuration at
    the targets was found and no path to it was looked for, or not found within the few edge checks that were spent."""
    targets: tuple[tuple[str, Vector], ...] = ()
    """Hands, and where their targets would have to be, m."""
    option: tuple[str, float] | None = None
    """An option of the method, and its value."""
    limit: tuple[str, str, float] | None = None
    """A joint, `lower` or `upper`, and the position limit that would do, m or rad."""
    without: tuple[int, ...] = ()
    """Obstacles that would have to go, by index."""


@dataclass(frozen=True)
class Diagnosis:
    """Why a plan failed: how near the robot can get, what blocks it there, and what would help."""

    step: int
    """The step of targets that was not reached, from 0."""
    q: tuple[float, ...]
    """The nearest miss that was found: a configuration (n,), m and rad."""
    found_by: str
    """Where it comes from: `search` (the sampling planner has a path to it), `motion` (the motion ends there),
    `posture` (clear of everything, a path to it was not asked for) or `reach` (within the joint limits, whatever it
    touches)."""
    misses: tuple[Miss, ...]
    """How far each hand with a target is from it there."""
    blocking: tuple[BlockingPair, ...]
    """What blocks, the worst first."""
    limits: tuple[str, ...]
    """The joint limits that hold it back there, in words."""
    remedies: tuple[Remedy, ...]
    """What would help, each tried out; empty if nothing that was tried does."""
    solves: int
    """How many times inverse kinematics was called to find out."""

    @property
    def miss(self) -> str:
        """The nearest miss and what blocks there, in one line; empty if there is nothing to say of it."""
        hands = [
            f"{called(miss.hand)} {length(miss.distance)} m from its target" for miss in self.misses if _counts(miss)
        ]
        if self.misses and not hands:
            hands = ["the hands at their targets"]
        pairs = [f"{pair.link} blocked by {pair.other}" for pair in self.blocking[:1]]
        return ", ".join(" and ".join(part) for part in (hands, pairs, self.limits) if part)

    def summary(self) -> dict[str, Any]:
        """Return it as plain data, with the distances."""
        data = asdict(self)
        for miss, own in zip(data["misses"], self.misses, strict=True):
            miss["distance"] = own.distance
        return data


MISS, HELPS = "nearest miss", "what would help"
"""The clauses of a reason begin so that a diagnosis says in full."""


def besides(reason: str, diagnosis: Diagnosis | None) -> tuple[str, ...]:
    """Return the clauses of a reason that a diagnosis does not say: the first one says what happened."""
    clauses = reason.split("; ")
    if diagnosis is None:
        return (reason,)
    return tuple(clause for clause in clauses if not clause.startswith((MISS, HELPS)))


def length(value: float) -> str:
    """Return a length in m with three digits, or whole metres where it is long."""
    return f"{value:.3g}" if value < 100.0 else f"{value:.0f}"


SHORT = 1e-3
"""Hands that are nearer to their targets than this are not said to miss them, m."""


def _counts(miss: Miss) -> bool:
    return miss.distance > SHORT


def read_diagnosis(data: dict[str, Any] | None) -> Diagnosis | None:
    """Return what :meth:`Diagnosis.summary` gave, also after JSON had it."""
    if data is None:
        return None
    misses = [{name: miss[name] for name in ("hand", "position", "target")} for miss in data["misses"]]
    remedies = [
        Remedy(
            what=remedy["what"],
            proven=remedy["proven"],
            targets=tuple((hand, _vector(place)) for hand, place in remedy["targets"]),
            option=None if remedy["option"] is None else tuple(remedy["option"]),
            limit=None if remedy["limit"] is None else tuple(remedy["limit"]),
            without=tuple(remedy["without"]),
        )
        for remedy in data["remedies"]
    ]
    return Diagnosis(
        step=data["step"],
        q=tuple(data["q"]),
        found_by=data["found_by"],
        misses=tuple(Miss(m["hand"], _vector(m["position"]), _vector(m["target"])) for m in misses),
        blocking=tuple(BlockingPair(**pair) for pair in data["blocking"]),
        limits=tuple(data["limits"]),
        remedies=tuple(remedies),
        solves=data["solves"],
    )


def _vector(values: Any) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z
