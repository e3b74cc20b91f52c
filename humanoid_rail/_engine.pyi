"""
The native engine: velocities, motions and proofs on Pinocchio and coal, in C++.
"""

from collections.abc import Callable, Sequence
import enum
from typing import Annotated

import numpy
from numpy.typing import NDArray


PINOCCHIO_VERSION: str = '4.1.0'

COAL_VERSION: str = '3.0.3'

CONTACT: float = 1e-06

RESOLUTION: float = 0.001

MAX_CHECKS: int = 2000000

APART: float = 2e-06

PROGRESS: float = 0.01

class Robot:
    """A robot's model, collision bodies, linear coupling and hands."""

    def __init__(self, model: str, bodies: str, coupling: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], offset: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], hands: Sequence[tuple[int, Sequence[int]]], self_collision_pairs: Sequence[tuple[int, int]], pair_distances: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], lower: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], upper: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], velocity_limit: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]) -> None: ...

class Obstacles:
    """Obstacles, at rest or moving; each call adds one."""

    def __init__(self) -> None: ...

    def sphere(self, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], radius: float, velocity: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

    def box(self, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], rotation: Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')], size: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], velocity: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

    def capsule(self, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], rotation: Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')], radius: float, length: float, velocity: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

    def cylinder(self, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], rotation: Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')], radius: float, length: float, velocity: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

    def spheres(self, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], rotation: Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')], centers: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], radii: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], velocity: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

    def halfspace(self, normal: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], offset: float, velocity: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

    def convex(self, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], rotation: Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')], pieces: Sequence[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]], velocity: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

class Task:
    """Something to be reached: an error that is to become 0."""

class PointTask(Task):
    """A point of a hand that has to be at a place."""

    def __init__(self, hand: int, offset: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], target: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

class DirectionTask(Task):
    """A hand that has to point in a direction."""

    def __init__(self, hand: int, pointing: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], direction: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], lever: float) -> None: ...

class RelativeTask(Task):
    """Two hands that have to be in a relation."""

    def __init__(self, first: int, second: int, difference: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], in_first: bool = False) -> None: ...

class DistanceTask(Task):
    """Two hands that have to be at a distance."""

    def __init__(self, first: int, second: int, distance: float) -> None: ...

class LineTask(Task):
    """A point of a hand that has to be on a line."""

    def __init__(self, hand: int, offset: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], point: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], across: Annotated[NDArray[numpy.float64], dict(shape=(3, 2), order='F')]) -> None: ...

class AxisTask(Task):
    """An axis of a hand that has to lie along a direction."""

    def __init__(self, hand: int, axis: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], direction: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], across: Annotated[NDArray[numpy.float64], dict(shape=(3, 2), order='F')], lever: float) -> None: ...

class OrientationTask(Task):
    """A hand that has to be turned in one way."""

    def __init__(self, hand: int, rotation: Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')], reference: int, lever: float) -> None: ...

class ConfigurationTask(Task):
    """Joints that have to be at positions."""

    def __init__(self, joints: Sequence[int], target: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]) -> None: ...

class WithinBoxTask(Task):
    """A task that is done within a tolerance along axes."""

    def __init__(self, task: Task, axes: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], tolerance: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]) -> None: ...

class WithinBallTask(Task):
    """A task that is done within a tolerance of its norm."""

    def __init__(self, task: Task, tolerance: float) -> None: ...

class FunctionTask(Task):
    """A task that is computed in Python."""

    def __init__(self, rows: int, function: Callable[..., object]) -> None: ...

class TaskStack:
    """Tasks one below the other."""

    def __init__(self, tasks: Sequence[Task]) -> None: ...

    @property
    def rows(self) -> int: ...

class State:
    """Everything that is true of a robot among obstacles at a configuration."""

    @property
    def hands(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def rotations(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]: ...

    @property
    def jacobian(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]: ...

    @property
    def angular_jacobian(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]: ...

    @property
    def manipulability(self) -> float: ...

    @property
    def manipulability_gradient(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def clearance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]: ...

    @property
    def clearance_gradient(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]: ...

    @property
    def piece_distance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]: ...

    @property
    def piece_gradient(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]: ...

    @property
    def piece_rate(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]: ...

    @property
    def link_distance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def link_gradient(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]: ...

class Measurement:
    """The values of a state without its derivatives."""

    @property
    def hands(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def manipulability(self) -> float: ...

    @property
    def clearance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]: ...

    @property
    def link_distance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

class Course:
    """What is true along a motion."""

    @property
    def hands(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]: ...

    @property
    def manipulability(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def clearance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]: ...

class Posture:
    """A configuration that was found, and how good it is."""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def error(self) -> float: ...

    @property
    def clearance(self) -> float: ...

    @property
    def reached(self) -> bool: ...

class InverseKinematics:
    """Looks for configurations in which tasks are done."""

    def __init__(self, robot: Robot, obstacles: Obstacles) -> None: ...

    def solve(self, start: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], tasks: TaskStack, distance: float) -> Posture: ...

    def reached(self, starts: Annotated[NDArray[numpy.float64], dict(shape=(None, None), writable=False)], tasks: TaskStack, distance: float) -> list[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]]:
        """The configurations in which the tasks are done."""

    def pulled(self, goal: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], start: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], tasks: TaskStack, distance: float) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    def evaluate(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], tasks: TaskStack) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]]: ...

    def errors(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None, None), writable=False)], tasks: TaskStack) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """The errors of the tasks at each configuration."""

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
    def others_bound(self) -> float: ...

    @property
    def contact(self) -> Contact | None: ...

    @property
    def stopped(self) -> float | None: ...

class Certifier:
    """Proves motions free of contact, or finds the first contact."""

    def __init__(self, robot: Robot, obstacles: Obstacles) -> None: ...

    def certify(self, t: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], q: Annotated[NDArray[numpy.float64], dict(shape=(None, None), writable=False)], velocity: Annotated[NDArray[numpy.float64], dict(shape=(None, None), writable=False)], max_checks: int) -> Certificate:
        """Without velocities, (0, n), the motion is linear in q."""

class EdgeChecker:
    """Whether a robot keeps its distance at a configuration or on an edge."""

    def __init__(self, robot: Robot, obstacles: Obstacles, distance: float, own_share: float) -> None: ...

    def is_valid(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]) -> bool: ...

    def is_edge_valid(self, a: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], b: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]) -> bool: ...

class SweptDistance:
    """Lower bounds of clearances on the edge between two configurations."""

    def __init__(self, robot: Robot, obstacles: Obstacles) -> None: ...

    def pairs(self) -> list[tuple[int, int, int]]: ...

    def distance(self, pair: int, t: float, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]) -> tuple[float, Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]]: ...

    def lower_bound(self, pair: int, t_a: float, a: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], t_b: float, b: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]) -> float: ...

class MotionBound:
    """
    How far the points of links can get while joints move at constant rates.
    """

    def __init__(self, robot: Robot) -> None: ...

    def displacements(self, change: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], slide: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], origin: int) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]]: ...

class LinkBoxes:
    """
    Bounds of pairs of links that take long to measure, from boxes around them.
    """

    def __init__(self, robot: Robot) -> None: ...

    def bounds(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]) -> list[tuple[int, float, float]]:
        """
        Of each pair its number, a lower bound of its distance, m, and an upper one of its approach, m/s.
        """

def closest_pairs(robot: Robot, obstacles: Obstacles, t: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], q: Annotated[NDArray[numpy.float64], dict(shape=(None, None), writable=False)]) -> tuple[list[tuple[int, int, float, Annotated[NDArray[numpy.float64], dict(shape=(2, 3), order='C')]]], list[tuple[int, int, float, Annotated[NDArray[numpy.float64], dict(shape=(2, 3), order='C')]]]]:
    """The closest link and obstacle, and the closest links, at each moment."""

class Gains:
    """Parameters of eq. 4.9."""

    def __init__(self, gain: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], c_mu: float, c_kappa: float, epsilon: float, singular_value: float, objective: Callable[..., object] | None = None) -> None: ...

class Safety:
    """Parameters of the constraints of the safe velocity."""

    def __init__(self, *, distance: float, gain: float, horizon: float, margin_share: float, least_margin: float, limit_gain: float, task_weight: float, least_rate: float, fastest: float, precision: float, shares: Sequence[float], equality: Callable[..., object] | None = None, constraints: TaskStack | None = None) -> None: ...

class Settings:
    """When a motion ends, and how precisely it is integrated."""

    def __init__(self, *, tolerance: float, dt: float, max_time: float, rtol: float, atol: float, max_evaluations: int, patience: float, progress: float, planning_time: float) -> None: ...

class Status(enum.Enum):
    """What became of the tasks."""

    REACHED = 0

    STALLED = 1

    TIME_LIMIT = 2

    SINGULAR = 3

    OVERRUN = 4

    OUT_OF_TIME = 5

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

class SafeVelocity:
    """A robot among obstacles: what is true of it, and how it moves."""

    def __init__(self, robot: Robot, obstacles: Obstacles) -> None: ...

    def state(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], t: float) -> State: ...

    def measure(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], t: float, horizon: float) -> Measurement: ...

    def along(self, t: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], q: Annotated[NDArray[numpy.float64], dict(shape=(None, None), writable=False)], horizon: float) -> Course: ...

    def projection_velocity(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], t: float, tasks: TaskStack, gains: Gains) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """q_dot of eq. 4.9."""

    def velocity(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], t: float, tasks: TaskStack, gains: Gains, safety: Safety, dt: float) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """q_dot of the quadratic program."""

    def reachable_velocity(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], t: float, tasks: TaskStack, gains: Gains, safety: Safety, dt: float, lower: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], upper: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], fallback: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """The same among the velocities that can be had."""

    def constraints(self) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]]:
        """The rows and sides of the last velocity's program."""

    def integrate(self, start: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], tasks: TaskStack, gains: Gains, settings: Settings) -> Integration: ...

    def rollout(self, start: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], tasks: TaskStack, gains: Gains, safety: Safety, settings: Settings) -> tuple[Integration, Contact | None]: ...

class Step(enum.Enum):
    """What is known of a step of a rollout."""

    SAFE = 0

    FREE = 1

    BLOCKED = 2

class StepJudge:
    """Whether steps without obstacles are safe."""

    def __init__(self, robot: Robot, safety_distance: float) -> None: ...

    def judge(self, a: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], b: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], horizon: float) -> Step:
        """
        Of the step from a to b; pairs farther apart than the horizon are not looked at.
        """

class EdgeFilter:
    """
    Whether a robot seems to keep its distance on an edge, from samples of it.
    """

    def __init__(self, robot: Robot, obstacles: Obstacles, distance: float, own_share: float, portable: bool = False) -> None: ...

    def is_edge_free(self, a: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], b: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]) -> bool: ...

class Sampler:
    """
    Paths by sampling: RRT-Connect, shortcuts, and the proof of what they find.
    """

    def __init__(self, robot: Robot, obstacles: Obstacles, distance: float, own_share: float, units: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], constraints: TaskStack | None = None) -> None: ...

    def walk(self, start: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], goal: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')] | None, Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')], int]: ...

    def connect(self, start: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)], goals: Annotated[NDArray[numpy.float64], dict(shape=(None, None), writable=False)], lower: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], upper: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], longest: float, seed: int, max_checks: int, seconds: float) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')] | None, Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')], int]: ...

    def shorten(self, path: Annotated[NDArray[numpy.float64], dict(shape=(None, None), writable=False)], shorter_than: float, seed: int, max_checks: int, seconds: float) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')] | None, Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')], int]: ...

class FollowerStatus(enum.Enum):
    """What a robot does in a cycle."""

    FOLLOWING = 0

    REACHED = 1

    BRAKING = 2

    STOPPED = 3

class Nearest:
    """The shortest line from a link to an obstacle or another link."""

    @property
    def link(self) -> int: ...

    @property
    def other(self) -> int: ...

    @property
    def with_obstacle(self) -> bool: ...

    @property
    def distance(self) -> float: ...

class FollowerState:
    """A robot at the end of a cycle."""

    @property
    def cycle(self) -> int: ...

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def velocity(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def status(self) -> FollowerStatus: ...

    @property
    def left(self) -> float: ...

    @property
    def proven(self) -> bool: ...

    @property
    def stop(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def cycles_to_rest(self) -> int: ...

    @property
    def jumped(self) -> int: ...

    @property
    def closest(self) -> Nearest: ...

    @property
    def blocking(self) -> Nearest | None: ...

class CycleTimes:
    """How long cycles took."""

    @property
    def cycles(self) -> int: ...

    @property
    def overruns(self) -> int: ...

    @property
    def longest(self) -> float: ...

    def percentile(self, share: float) -> float: ...

class Follower:
    """Follows targets, cycle by cycle or in a thread of its own."""

    def __init__(self, robot: Robot, obstacles: Obstacles, start: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], tasks: TaskStack, gains: Gains, safety: Safety, *, dt: float, tolerance: float, acceleration: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], obstacle_speeds: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], latency: float) -> None: ...

    def set_goal(self, tasks: TaskStack, gains: Gains) -> None: ...

    def move_obstacle(self, obstacle: int, center: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')], rotation: Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')], velocity: Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]) -> None: ...

    def step(self, brakes: bool) -> FollowerState: ...

    def start(self) -> None: ...

    def stop(self) -> None: ...

    def end(self) -> None: ...

    def state(self) -> FollowerState: ...

    def times(self) -> CycleTimes: ...

    @property
    def is_running(self) -> bool: ...

    def contact(self) -> Nearest | None:
        """A pair that touches where the robot is. Not while it runs."""

class ClearanceRows:
    """The pairs that a small change of samples may bring too near."""

    @property
    def sample(self) -> Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C')]: ...

    @property
    def spare(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def gradient(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]: ...

    @property
    def least(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

class MotionClearance:
    """How near a robot is to everything at samples of a motion."""

    def __init__(self, robot: Robot, obstacles: Obstacles) -> None: ...

    def rows(self, samples: Annotated[NDArray[numpy.float64], dict(shape=(None, None), writable=False)], distance: float, horizon: float, reach: Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]) -> ClearanceRows: ...

def library_call_seconds(robot: Robot, obstacles: Obstacles, configurations: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], repeats: int) -> float:
    """
    Seconds of the bare Pinocchio and coal calls that one evaluation of eq. 4.9 is made of.
    """

def velocity_seconds(kinematics: SafeVelocity, configurations: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], tasks: TaskStack, gains: Gains, repeats: int) -> float:
    """Seconds of one evaluation of eq. 4.9, called from C++."""

def safe_velocity_seconds(kinematics: SafeVelocity, configurations: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')], tasks: TaskStack, gains: Gains, safety: Safety, dt: float, repeats: int) -> float:
    """Seconds of one safe velocity, called from C++."""
