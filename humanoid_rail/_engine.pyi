"""
The native engine: eq. 4.9 and its integration on Pinocchio and coal, in C++.
"""

from collections.abc import Sequence
import enum
from typing import Annotated

import numpy
from numpy.typing import NDArray


SINGULAR_VALUE: float = 0.1

MAX_DAMPING: float = 0.07071067811865475

INFLUENCE: float = 0.5

FREE_SPEED: float = 2.0

LIMIT_GAIN: float = 10.0

TASK_WEIGHT: float = 1000.0

LEAST_RATE: float = 1e-06

SHARE: float = 0.1

LEAST_MARGIN: float = 0.001

PINOCCHIO_VERSION: str = '4.1.0'

COAL_VERSION: str = '3.0.3'

class Robot:
    """A robot's model, collision bodies, linear coupling and hands."""

    def __init__(self, model: str, bodies: str, coupling: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], offset: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], hands: Sequence[tuple[int, Sequence[int]]], self_collision_pairs: Sequence[tuple[int, int]], lower: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], upper: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], velocity_limit: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]) -> None: ...

class Obstacles:
    """Obstacles, at rest or moving; each call adds one."""

    def __init__(self) -> None: ...

    def sphere(self, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], radius: float, velocity: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

    def box(self, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], rotation: Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')], size: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], velocity: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

    def capsule(self, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], rotation: Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')], radius: float, length: float, velocity: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

    def halfspace(self, normal: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], offset: float, velocity: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

    def convex(self, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], rotation: Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')], pieces: Sequence[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]], velocity: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

class Gains:
    """Parameters of eq. 4.9."""

    def __init__(self, gain: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], c_mu: float, c_kappa: float, epsilon: float) -> None: ...

class Status(enum.Enum):
    """What became of the targets."""

    REACHED = 0

    STALLED = 1

    TIME_LIMIT = 2

    SINGULAR = 3

    OVERRUN = 4

    OUT_OF_TIME = 5

class Settings:
    """When a motion ends, and how precisely it is integrated."""

    def __init__(self, *, tolerance: float, dt: float, max_time: float, rtol: float, atol: float, max_evaluations: int, patience: float, progress: float, planning_time: float) -> None: ...

class Integration:
    """A sampled motion and why it ended."""

    @property
    def status(self) -> Status: ...

    @property
    def left(self) -> float: ...

    @property
    def evaluations(self) -> int: ...

    @property
    def broken(self) -> str: ...

    @property
    def t(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]: ...

    @property
    def visited(self) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]]: ...

class GradientProjection:
    """Eq. 4.9 for a robot among obstacles. Not to be shared between threads."""

    def __init__(self, robot: Robot, obstacles: Obstacles) -> None: ...

    def along(self, t: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], q: Annotated[NDArray[numpy.float64], dict(shape=(None, None), writable=False)], horizon: float) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]]: ...

    def velocity(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], t: float, targets: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], gains: Gains) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    def integrate(self, start: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], targets: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], gains: Gains, settings: Settings) -> Integration: ...

class Safety:
    """Parameters of the constraints of the safe velocity."""

    def __init__(self, *, distance: float, gain: float) -> None: ...

class Contact:
    """A link that touches an obstacle or another link."""

    @property
    def t(self) -> float: ...

    @property
    def link(self) -> int: ...

    @property
    def other(self) -> int: ...

    @property
    def with_obstacle(self) -> bool: ...

    @property
    def point(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]: ...

class Certificate:
    """What is proven of a motion."""

    @property
    def certified(self) -> bool: ...

    @property
    def min_obstacles(self) -> float: ...

    @property
    def min_links(self) -> float: ...

    @property
    def bound(self) -> float: ...

    @property
    def contact(self) -> Contact | None: ...

class Certifier:
    """Looks for contact on motions. Not to be shared between threads."""

    def __init__(self, robot: Robot, obstacles: Obstacles) -> None: ...

    def certify(self, t: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], q: Annotated[NDArray[numpy.float64], dict(shape=(None, None), writable=False)]) -> Certificate: ...

class SafeVelocity:
    """
    The velocity closest to eq. 4.9's that keeps clear. Not to be shared between threads.
    """

    def __init__(self, robot: Robot, obstacles: Obstacles) -> None: ...

    @property
    def projection(self) -> GradientProjection: ...

    def state(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], t: float) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], float, Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')], tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]], tuple[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]]]: ...

    def measure(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], t: float, horizon: float) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], float, Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]]: ...

    def velocity(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], t: float, targets: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], gains: Gains, safety: Safety, dt: float) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    def constraints(self) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]]: ...

    def rollout(self, obstacles: Obstacles, start: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], targets: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], gains: Gains, safety: Safety, settings: Settings) -> tuple[Integration, Contact | None]: ...

class Validity:
    """Whether a robot keeps its distance. Not to be shared between threads."""

    def __init__(self, robot: Robot, obstacles: Obstacles, distance: float) -> None: ...

    def holds_at(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]) -> bool: ...

    def holds_between(self, a: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], b: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]) -> bool: ...

class InverseKinematics:
    """Looks for configurations. Not to be shared between threads."""

    def __init__(self, robot: Robot, obstacles: Obstacles) -> None: ...

    def solve(self, start: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], targets: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], weights: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], distance: float) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], float, float]: ...

def floor_seconds(robot: Robot, obstacles: Obstacles, configurations: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], repeats: int) -> float:
    """
    Seconds of the bare Pinocchio and coal calls that one evaluation of eq. 4.9 is made of.
    """

def velocity_seconds(method: GradientProjection, configurations: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], targets: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], gains: Gains, repeats: int) -> float:
    """Seconds of one evaluation of eq. 4.9, called from C++."""

def safe_velocity_seconds(method: SafeVelocity, configurations: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], targets: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], gains: Gains, safety: Safety, dt: float, repeats: int) -> float:
    """Seconds of one safe velocity, called from C++."""
