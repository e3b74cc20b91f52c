"""The native engine: the interface of the modules of the Python engine, computed in C++.

Importing this module raises ImportError where the extension was not built, or for other versions of Pinocchio or coal.
"""

from __future__ import annotations

from ctypes import CDLL
from importlib.metadata import files
from typing import Protocol
from weakref import WeakKeyDictionary

# Before the extension: these bring the libraries that the extension is linked with.
import coal
import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from humanoid_rail import integration
from humanoid_rail._arrays import Array
from humanoid_rail.collision.certificate import Certificate, Contact
from humanoid_rail.collision.certifier import name_contact
from humanoid_rail.errors import InvalidInput
from humanoid_rail.resolution.integrate import Integration, Settings, explain
from humanoid_rail.kinematics.inverse_kinematics import Posture
from humanoid_rail.kinematics.kinematics import Clearances, Course, Measurement, State
from humanoid_rail.kinematics.joint_limits import Motion
from humanoid_rail.scene.obstacles import Box, Capsule, HalfSpace, Mesh, Obstacle, Sphere
from humanoid_rail.resolution.velocity import Gains
from humanoid_rail.model.robot import Robot
from humanoid_rail.resolution.rollout import PROGRESS_TIME, explain_step
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.trajectory import Status

# Nothing else loads this one, and beside the extension it is only where both are in the same environment.
for _file in files("eiquadprog") or ():
    if _file.name.startswith("libeiquadprog."):
        CDLL(str(_file.locate()))
from humanoid_rail import _engine  # noqa: E402

if (pin.__version__, coal.__version__) != (_engine.PINOCCHIO_VERSION, _engine.COAL_VERSION):
    linked = f"{_engine.PINOCCHIO_VERSION} and {_engine.COAL_VERSION}"
    raise ImportError(f"built for Pinocchio and coal {linked}, and these are {pin.__version__} and {coal.__version__}")

_STATUS = {
    _engine.Status.REACHED: Status.REACHED,
    _engine.Status.STALLED: Status.STALLED,
    _engine.Status.TIME_LIMIT: Status.TIME_LIMIT,
    _engine.Status.SINGULAR: Status.SINGULAR,
    _engine.Status.OVERRUN: Status.OVERRUN,
    _engine.Status.OUT_OF_TIME: Status.STUCK,
}

# Robots as the extension has them: frozen too, and shared between threads.
_robots: WeakKeyDictionary[Robot, _engine.Robot] = WeakKeyDictionary()


class VelocityField(Protocol):
    """q_dot (n,) in m/s and rad/s at a configuration (n,) in m and rad, and a time in s."""

    def __call__(self, q: Array, t: float = 0.0) -> Array:
        """Return the velocity."""
        ...


class Kinematics:
    """A robot among obstacles; not to be shared between threads. See :class:`humanoid_rail.Kinematics`."""

    def __init__(self, robot: Robot, obstacles: tuple[Obstacle, ...] = ()) -> None:
        self.robot = robot
        self.obstacles = obstacles
        self.shapes = native_obstacles(obstacles)
        self.safe = _engine.SafeVelocity(native_robot(robot), self.shapes)
        self.engine = self.safe.projection
        self._links = robot.collision_model.ngeoms

    def state(self, q: ArrayLike, t: float = 0.0) -> State:
        """Return everything that eq. 4.9 and its constraints need to know at a configuration (n,) and a time in s."""
        q = np.array(q, float)
        hands, J, mu, mu_gradient, clearance, clearance_gradient, pieces, links = self.safe.state(q, t)
        n = self.robot.n
        return State(
            q=q,
            hands=hands.reshape(-1, 3),
            jacobian=J,
            manipulability=mu,
            manipulability_gradient=mu_gradient,
            clearance=clearance,
            clearance_gradient=clearance_gradient.reshape(*clearance.shape, n),
            pieces=Clearances(pieces[0], pieces[1].reshape(*pieces[0].shape, n), pieces[2]),
            links=Clearances(*links, np.zeros(len(links[0]))),
        )

    def measure(self, q: ArrayLike, horizon: float = np.inf, t: float = 0.0) -> Measurement:
        """Return hands, manipulability and clearances at a configuration (n,), without derivatives.

        Args:
            q: Configuration (n,), m and rad.
            horizon: Clearances beyond it are given as infinite, save the smallest of all, m. Those of pairs of links
                are given in any case.
            t: When, which matters where obstacles move, s.
        """
        hands, mu, clearance, links = self.safe.measure(np.array(q, float), t, horizon)
        return Measurement(hands.reshape(-1, 3), mu, clearance, links)

    def along(self, q: ArrayLike, horizon: float = np.inf, t: ArrayLike | None = None) -> Course:
        """Return the same for each configuration of a motion (N, n), clearances those of the nearest link.

        Args:
            q: Configurations (N, n), m and rad.
            horizon: As for :meth:`measure`.
            t: Times (N,), which matter where obstacles move, s; 0 if not given.
        """
        q = np.array(q, float, order="C")
        times = np.zeros(len(q)) if t is None else np.array(t, float)
        hands, mu, clearance = self.engine.along(times, q, horizon)
        return Course(hands.reshape(len(hands), -1, 3), mu, clearance)

    def gradient_projection(self, targets: ArrayLike, gains: Gains) -> VelocityField:
        """Return eq. 4.9 as a function: q_dot (n,) in m/s and rad/s at a configuration (n,) in m and rad.

        Its second argument is the time in s, which matters where obstacles move.

        Args:
            targets: x_f (h, 3), m.
            gains: K, c_mu, c_kappa and the activation distance.

        Raises:
            InvalidInput: If the targets have another shape. The function raises ValueError for a configuration that has
                another size or is not finite.
        """
        points = self._points(targets)
        converted, velocity = native_gains(gains, points.size), self.engine.velocity
        return lambda q, t=0.0: velocity(q, t, points, converted)

    def safe_velocity(self, targets: ArrayLike, gains: Gains, safety: Safety, dt: float) -> VelocityField:
        """Return the velocity of `method="qp"` as a function, as :meth:`gradient_projection` does that of eq. 4.9.

        Args:
            targets: x_f (h, 3), m.
            gains: K, c_mu, c_kappa and the activation distance.
            safety: Safety distance and gain of the dampers.
            dt: How long a velocity is to be held, s.

        Raises:
            InvalidInput: As :meth:`gradient_projection` does.
        """
        points = self._points(targets)
        converted, velocity = native_gains(gains, points.size), self.safe.velocity
        limits = native_safety(safety)
        return lambda q, t=0.0: velocity(q, t, points, converted, limits, dt)

    def _points(self, targets: ArrayLike) -> Array:
        points = np.array(targets, float)
        if points.shape != (len(self.robot.hands), 3):
            raise InvalidInput("targets", targets, f"an array of shape ({len(self.robot.hands)}, 3)")
        return points.ravel()


def integrate(kinematics: Kinematics, start: Array, targets: Array, gains: Gains, settings: Settings) -> Integration:
    """Integrate q_dot of eq. 4.9 from the start until |e| falls to the tolerance or nothing more can come of it.

    Meanwhile other threads run. See :func:`humanoid_rail.integration.integrate`.
    """
    converted = native_gains(gains, targets.size), _settings(settings, gains.diagonal(targets.size))
    motion = kinematics.engine.integrate(start, targets.ravel(), *converted)
    status, t = _STATUS[motion.status], motion.t
    reason = explain(status, t[-1], motion.left, motion.evaluations, settings, motion.broken)
    return Integration(t, motion.q, status, reason, motion.evaluations, Motion(*motion.visited))


def rollout(
    kinematics: Kinematics, start: Array, targets: Array, gains: Gains, safety: Safety, settings: Settings
) -> Integration:
    """Move by the safe velocity from the start until |e| falls to the tolerance or nothing more can come of it.

    Meanwhile other threads run. See :func:`humanoid_rail.rollout.rollout`.
    """
    converted = (
        native_gains(gains, targets.size),
        native_safety(safety),
        _settings(settings, gains.diagonal(targets.size)),
    )
    motion, overrun = kinematics.safe.rollout(kinematics.shapes, start, targets.ravel(), *converted)
    status, t = _STATUS[motion.status], motion.t
    contact = _contact(kinematics.robot, kinematics.obstacles, overrun)
    reason = explain_step(status, t[-1], motion.left, motion.evaluations, settings, contact)
    return Integration(t, motion.q, status, reason, motion.evaluations, Motion(*motion.visited))


def certify(robot: Robot, obstacles: tuple[Obstacle, ...], t: Array, q: Array) -> Certificate:
    """Return what can be proven of a motion. See :func:`humanoid_rail.certification.certify`."""
    found = _engine.Certifier(native_robot(robot), native_obstacles(obstacles)).certify(t, q)
    some_obstacle, some_pair = bool(obstacles), bool(robot.self_collision_pairs)
    return Certificate(
        certified=found.certified,
        min_clearance_obstacles=found.min_obstacles if some_obstacle else None,
        min_clearance_self=found.min_links if some_pair else None,
        clearance_bound=found.bound if some_obstacle or some_pair else None,
        contact=_contact(robot, obstacles, found.contact),
    )


def validity(robot: Robot, obstacles: tuple[Obstacle, ...], distance: float) -> _engine.Validity:
    """Return the :class:`humanoid_rail.validity.Validity` of a robot among obstacles."""
    return _engine.Validity(native_robot(robot), native_obstacles(obstacles), distance)


class InverseKinematics:
    """A robot among obstacles; see :class:`humanoid_rail.inverse_kinematics.InverseKinematics`."""

    def __init__(self, robot: Robot, obstacles: tuple[Obstacle, ...]) -> None:
        self._engine = _engine.InverseKinematics(native_robot(robot), native_obstacles(obstacles))

    def solve(self, start: Array, targets: Array, weights: Array, distance: float) -> Posture:
        """Look, from a configuration, for one near it that reaches."""
        return Posture(*self._engine.solve(start, targets, weights, distance))


def _contact(robot: Robot, obstacles: tuple[Obstacle, ...], found: _engine.Contact | None) -> Contact | None:
    if found is None:
        return None
    return name_contact(robot, obstacles, found.t, found.link, found.other, found.with_obstacle, found.point)


def _settings(settings: Settings, K: Array) -> _engine.Settings:
    return _engine.Settings(
        tolerance=settings.tolerance,
        dt=settings.dt,
        max_time=settings.max_time,
        rtol=settings.rtol,
        atol=settings.atol,
        max_evaluations=integration.MAX_EVALUATIONS,
        patience=integration.PATIENCE / K.min(),
        progress=PROGRESS_TIME / K.min(),
        planning_time=settings.max_planning_time,
    )


def native_safety(safety: Safety) -> _engine.Safety:
    """Return the constraints' parameters as the extension has them."""
    return _engine.Safety(distance=safety.safety_distance, gain=safety.damper_gain)


def native_gains(gains: Gains, size: int) -> _engine.Gains:
    """Return gains as the extension has them, K with `size` elements.

    Raises:
        InvalidInput: If K has another size, or there are objectives written in Python.
    """
    if gains.objectives:
        raise InvalidInput("objectives", gains.objective_names, "none with the native engine")
    return _engine.Gains(gains.diagonal(size), gains.c_mu, gains.c_kappa, gains.epsilon)


def native_robot(robot: Robot) -> _engine.Robot:
    """Return a robot as the extension has it, made once for each robot."""
    if robot not in _robots:
        hands = [(robot.model.getFrameId(hand.frame), robot.arm_columns(hand)) for hand in robot.hands]
        model, bodies = robot.model.saveToString(), robot.collision_model.saveToString()
        _robots[robot] = _engine.Robot(
            model,
            bodies,
            robot.coupling,
            robot.offset,
            hands,
            list(robot.self_collision_pairs),
            robot.lower,
            robot.upper,
            robot.velocity_limit,
        )
    return _robots[robot]


def native_obstacles(obstacles: tuple[Obstacle, ...]) -> _engine.Obstacles:
    """Return obstacles as the extension has them; beside `shapes.py`."""
    result = _engine.Obstacles()
    for obstacle in obstacles:
        if not isinstance(obstacle, Sphere | Box | Capsule | HalfSpace | Mesh):
            raise InvalidInput("obstacles", obstacle, "a Sphere, Box, Capsule, HalfSpace or Mesh")
        velocity = np.array(obstacle.velocity)
        match obstacle:
            case Sphere():
                result.sphere(np.array(obstacle.center), obstacle.radius, velocity)
            case Box():
                result.box(*_placement(obstacle), np.array(obstacle.size), velocity)
            case Capsule():
                result.capsule(*_placement(obstacle), obstacle.radius, obstacle.length, velocity)
            case HalfSpace():
                length = float(np.linalg.norm(obstacle.normal))
                result.halfspace(np.array(obstacle.normal) / length, obstacle.offset / length, velocity)
            case Mesh():
                result.convex(*_placement(obstacle), list(obstacle.pieces), velocity)
    return result


def _placement(obstacle: Box | Capsule | Mesh) -> tuple[Array, Array]:
    return np.array(obstacle.center), pin.rpy.rpyToMatrix(*obstacle.rpy)
