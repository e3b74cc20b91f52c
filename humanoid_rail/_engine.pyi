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

PINOCCHIO_VERSION: str = '4.1.0'

COAL_VERSION: str = '3.0.3'

class Robot:
    """A robot's model, collision bodies, linear coupling and hands."""

    def __init__(self, model: str, bodies: str, coupling: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], offset: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], hands: Sequence[tuple[int, Sequence[int]]]) -> None: ...

class Obstacles:
    """Obstacles at rest; each call adds one."""

    def __init__(self) -> None: ...

    def sphere(self, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], radius: float) -> None: ...

    def box(self, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], rotation: Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')], size: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

    def capsule(self, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], rotation: Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')], radius: float, length: float) -> None: ...

    def halfspace(self, normal: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], offset: float) -> None: ...

    def convex(self, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], rotation: Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')], pieces: Sequence[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]]) -> None: ...

class Gains:
    """Parameters of eq. 4.9."""

    def __init__(self, gain: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], c_mu: float, c_kappa: float, epsilon: float) -> None: ...

class Status(enum.Enum):
    """What became of the targets."""

    REACHED = 0

    STALLED = 1

    TIME_LIMIT = 2

    SINGULAR = 3

class Settings:
    """When a motion ends, and how precisely it is integrated."""

    def __init__(self, *, tolerance: float, dt: float, max_time: float, rtol: float, atol: float, max_evaluations: int, patience: float) -> None: ...

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

    def state(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], float, Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]]: ...

    def measure(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], horizon: float) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], float, Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]]: ...

    def along(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None, None), writable=False)], horizon: float) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]]: ...

    def velocity(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], targets: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], gains: Gains) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    def integrate(self, start: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], targets: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], gains: Gains, settings: Settings) -> Integration: ...

def floor_seconds(robot: Robot, obstacles: Obstacles, configurations: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], repeats: int) -> float:
    """
    Seconds of the bare Pinocchio and coal calls that one evaluation of eq. 4.9 is made of.
    """

def velocity_seconds(method: GradientProjection, configurations: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], targets: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], gains: Gains, repeats: int) -> float:
    """Seconds of one evaluation of eq. 4.9, called from C++."""
