"""What a follower says of a cycle, as frozen data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

from humanoid_rail._arrays import Array, FrozenArrays, frozen
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import Obstacle, name_of

if TYPE_CHECKING:
    from humanoid_rail import _engine


class FollowerStatus(StrEnum):
    """What a robot does in a cycle."""

    FOLLOWING = "following"
    """It moves, and its stop is proven afresh."""
    REACHED = "reached"
    """|e| is within the tolerance. The joints may still move."""
    BRAKING = "braking"
    """It goes on with a stop that was proven before, because none was found for any other velocity or because it was
    told to."""
    STOPPED = "stopped"
    """It stands still, and the tasks are not reached."""


@dataclass(frozen=True)
class NearPair:
    """Two bodies and how far they are apart."""

    link: str
    """Link of the robot."""
    other: str
    """An obstacle, such as ``obstacles[3] (sphere)``, or another link."""
    distance: float
    """m; negative in penetration, where it may be minus infinity: then its depth was not measured."""

    def __str__(self) -> str:
        if self.distance < 0.0:
            return f"{self.link} is inside {self.other}"
        return f"{self.link} is {self.distance:.4g} m from {self.other}"


@dataclass(frozen=True, eq=False)
class FollowerState(FrozenArrays):
    """A robot at the end of a cycle of a :class:`humanoid_rail.Follower`."""

    cycle: int
    """How many cycles there have been."""
    t: float
    """The time at the end of it, s."""
    q: Array
    """Configuration (n,) there, m and rad."""
    velocity: Array
    """q_dot (n,) that was held in the cycle, m/s and rad/s."""
    status: FollowerStatus
    """What the robot does."""
    reason: str
    """The same in a sentence, with numbers."""
    error: float
    """|e|, m."""
    proven: bool
    """Whether it is proven that the robot can stop before anything touches it. False only after an obstacle got farther
    than its speed allows, until a stop is proven again or the robot is at rest."""
    stop: Array
    """Configuration (n,) where the stop ends if the robot brakes from now on, m and rad."""
    time_to_rest: float
    """How long that takes, s."""
    jumped: str | None
    """An obstacle that got farther than its speed allows, by its name in messages; None if none did."""
    closest: NearPair | None
    """The closest pair at the beginning of the cycle, of those that were measured; None where nothing is near."""
    blocking: NearPair | None
    """A pair that kept a velocity from being proven, with its distance at the beginning of the cycle."""


@dataclass(frozen=True)
class CycleTimes:
    """How long the cycles of a follower's thread took to compute."""

    cycles: int
    """How many there were since the thread was started."""
    overruns: int
    """How many of them were not done when the next one was due: it began late then."""
    median: float
    """s, precise to a microsecond."""
    percentile_99: float
    """The time that 99 % of them took at most, s, precise to a microsecond."""
    longest: float
    """s."""


def state_of(robot: Robot, obstacles: Sequence[Obstacle], dt: float, native: _engine.FollowerState) -> FollowerState:
    """Return a state by names from one of the engine, which has numbers."""
    closest = named_pair(robot, obstacles, native.closest) if native.closest.link >= 0 else None
    blocking = None if native.blocking is None else named_pair(robot, obstacles, native.blocking)
    jumped = None if native.jumped < 0 else name_of(obstacles, native.jumped)
    status = FollowerStatus[native.status.name]
    return FollowerState(
        cycle=native.cycle,
        t=native.cycle * dt,
        q=frozen(native.q),
        velocity=frozen(native.velocity),
        status=status,
        reason=_reason(status, native, jumped, closest, blocking),
        error=native.left,
        proven=native.proven,
        stop=frozen(native.stop),
        time_to_rest=native.cycles_to_rest * dt,
        jumped=jumped,
        closest=closest,
        blocking=blocking,
    )


def named_pair(robot: Robot, obstacles: Sequence[Obstacle], pair: _engine.Nearest) -> NearPair:
    """Return a pair by names from one of the engine."""
    other = name_of(obstacles, pair.other) if pair.with_obstacle else robot.link_names[pair.other]
    return NearPair(robot.link_names[pair.link], other, pair.distance)


def _reason(
    status: FollowerStatus,
    native: _engine.FollowerState,
    jumped: str | None,
    closest: NearPair | None,
    blocking: NearPair | None,
) -> str:
    said = [f"|e| is {native.left:.4g} m"]
    if jumped is not None:
        said.append(f"{jumped} got farther than its speed allows")
    if not native.proven:
        said.append("no stop is proven where the obstacles are now")
    if status is FollowerStatus.BRAKING:
        said.append("the robot brakes")
    if status is FollowerStatus.STOPPED:
        said.append("the robot stands still")
    if blocking is not None:
        said.append(f"a stop could not be proven for a velocity: {blocking}")
    elif status is FollowerStatus.STOPPED and closest is not None:
        said.append(f"no velocity that keeps clear and within the limits brings the hands nearer; {closest}")
    return "; ".join(said)
