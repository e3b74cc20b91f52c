"""What is proven of a motion between its samples, as frozen data."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from humanoid_rail.kinematics.deviation import Deviation
from humanoid_rail.model.pairs import UncheckedPair
from humanoid_rail.scene.covers import Cover


@dataclass(frozen=True)
class Contact:
    """The first contact of a motion."""

    t: float
    """When, s."""
    link: str
    """Link of the robot."""
    other: str
    """What it touches: another link, or an obstacle, such as ``obstacles[3] (sphere)``."""
    point: tuple[float, float, float]
    """Where, in the base frame, m."""

    def __str__(self) -> str:
        where = ", ".join(f"{x:.3f}" for x in self.point)
        return f"{self.link} touches {self.other} at t = {self.t:.4g} s, at ({where})"


@dataclass(frozen=True)
class Certificate:
    """What :func:`humanoid_rail.verify` proves of a motion."""

    certified: bool
    """Whether no link touches an obstacle or another link at any time from the first sample to the last; what is left
    out is in `unchecked_pairs` and `links_without_body`."""
    min_clearance_obstacles: float | None
    """Smallest clearance from an obstacle at the samples, or between them where that was looked at, m; None without
    obstacles."""
    min_clearance_self: float | None
    """The same of two links of the robot; None without pairs to check."""
    clearance_bound: float | None
    """No clearance is smaller at any time, m: a true lower bound, at most about 1 mm below the smallest one found.
    None where there is nothing to touch, and where the motion was not looked at up to its end."""
    contact: Contact | None
    """The first contact, if there is one."""
    reason: str | None = None
    """Why the motion was not looked at up to its end, if so, and from when on nothing is proven."""
    unchecked_pairs: tuple[UncheckedPair, ...] = ()
    """Pairs of links that were not checked against each other, or only in part, each with the reason; and links and
    obstacles that never move and are nearer to each other than `clearance_bound`."""
    links_without_body: tuple[str, ...] = ()
    """Links that are visible or have a mass, and no collision body, so that nothing is proven of them."""

    others_bound: float | None = None
    """The clearance bound without pairs of links that keep a distance of their own (`Robot.pair_distances`), m; None of
    robots that have none, and where there is nothing else to touch."""

    only_own_distances: bool = False
    """Whether there is nothing to touch but pairs of links that keep a distance of their own."""

    deviations: tuple[Deviation, ...] = ()
    """How far the motion leaves each constraint at the most, including between samples; empty where it keeps none."""
    covers: tuple[Cover, ...] = ()
    """What stands for the obstacles that were measured, point clouds and height fields: clearances are from these."""

    @property
    def kept_bound(self) -> float | None:
        """A lower bound of all clearances that are to keep the safety distance, m; of all clearances where any touch.

        None where there are none, and where the motion was not looked at up to its end.
        """
        if not self.certified:
            return self.clearance_bound
        if self.only_own_distances:
            return None
        return self.clearance_bound if self.others_bound is None else self.others_bound

    def __bool__(self) -> bool:
        """Return whether the motion is certified."""
        return self.certified


def combined(parts: Sequence[Certificate]) -> Certificate:
    """Return the certificates of the parts of a motion, or of parts of what is around it, as one."""
    if len(parts) == 1:
        return parts[0]
    contacts = [part.contact for part in parts if part.contact is not None]
    reasons = [part.reason for part in parts if part.reason is not None]
    some_own = any(part.others_bound is not None for part in parts)

    def least(value: Callable[[Certificate], float | None], among: Iterable[Certificate] = parts) -> float | None:
        return min((found for part in among if (found := value(part)) is not None), default=None)

    return Certificate(
        certified=all(part.certified for part in parts),
        min_clearance_obstacles=least(lambda part: part.min_clearance_obstacles),
        min_clearance_self=least(lambda part: part.min_clearance_self),
        clearance_bound=None if reasons else least(lambda part: part.clearance_bound),
        contact=min(contacts, key=lambda contact: contact.t, default=None),
        reason=reasons[0] if reasons else None,
        unchecked_pairs=tuple(dict.fromkeys(pair for part in parts for pair in part.unchecked_pairs)),
        links_without_body=tuple(dict.fromkeys(link for part in parts for link in part.links_without_body)),
        others_bound=least(lambda part: part.kept_bound) if some_own and not reasons else None,
        only_own_distances=all(part.only_own_distances for part in parts),
        covers=tuple(dict.fromkeys(cover for part in parts for cover in part.covers)),
    )
