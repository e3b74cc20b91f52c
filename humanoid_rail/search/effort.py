"""How a plan was found, what it cost and what its path is like: frozen data."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PathQuality:
    """What a path is like, in joint coordinates in units of their speed limits."""

    length: float
    """Sum of the norms of dq / speed limit, s: at the speed limits no path takes longer."""
    sharpest_turn: float
    """The largest angle between two pieces, or two steps between samples, that follow each other, rad."""


@dataclass(frozen=True)
class Search:
    """What `method="auto"` did to find a plan."""

    seed: int
    """Of the random numbers."""
    goals: int
    """How many configurations at the targets there were to choose from."""
    searches: int
    """How often the sampling planner was started."""
    checks: int
    """How many straight ways between configurations were checked."""
    raw: PathQuality | None
    """The first path of the sampling planner, before it was made shorter and rounded; None if there is none,
    or none for some of the legs."""
