"""The native engine: the interface of `kinematics.py`, `resolution.py` and `integration.py`, computed in C++.

Importing this module raises ImportError where the extension was not built, or for other versions of Pinocchio or coal.
"""

from __future__ import annotations

from collections.abc import Callable
from weakref import WeakKeyDictionary

# Before the extension: it brings the libraries that the extension is linked with.
import coal
import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from humanoid_rail import _engine, integration
from humanoid_rail.arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.integration import Integration, Settings, explain
from humanoid_rail.kinematics import Course, Measurement, State
from humanoid_rail.limits import Motion
from humanoid_rail.obstacles import Box, Capsule, HalfSpace, Mesh, Obstacle, Sphere
from humanoid_rail.resolution import Gains
from humanoid_rail.robot import Robot
from humanoid_rail.trajectory import Status

if (pin.__version__, coal.__version__) != (_engine.PINOCCHIO_VERSION, _engine.COAL_VERSION):
    linked = f"{_engine.PINOCCHIO_VERSION} and {_engine.COAL_VERSION}"
    raise ImportError(f"built for Pinocchio and coal {linked}, and these are {pin.__version__} and {coal.__version__}")

_STATUS = {
    _engine.Status.REACHED: Status.REACHED,
    _engine.Status.STALLED: Status.STALLED,
    _engine.Status.TIME_LIMIT: Status.TIME_LIMIT,
    _engine.Status.SINGULAR: Status.SINGULAR,
}

METHODS = ("gradient-projection",)
"""The methods that the extension has."""

# Robots as the extension has them: frozen too, and shared between threads.
_robots: WeakKeyDictionary[Robot, _engine.Robot] = WeakKeyDictionary()


class Kinematics:
    """A robot among obstacles; not to be shared between threads. See :class:`humanoid_rail.Kinematics`."""

    def __init__(self, robot: Robot, obstacles: tuple[Obstacle, ...] = ()) -> None:
        self.robot = robot
        self._shape = (robot.collision_model.ngeoms, len(obstacles))
        self.engine = _engine.GradientProjection(native_robot(robot), native_obstacles(obstacles))

    def state(self, q: ArrayLike) -> State:
        """Return everything eq. 4.9 needs to know at a configuration (n,)."""
        q = np.array(q, float)
        hands, J, mu, mu_gradient, clearance, clearance_gradient = self.engine.state(q)
        return State(
            q=q,
            hands=hands.reshape(-1, 3),
            jacobian=J,
            manipulability=mu,
            manipulability_gradient=mu_gradient,
            clearance=clearance,
            clearance_gradient=clearance_gradient.reshape(*self._shape, self.robot.n),
        )

    def measure(self, q: ArrayLike, horizon: float = np.inf) -> Measurement:
        """Return hands, manipulability and clearances at a configuration (n,), without derivatives.

        Args:
            q: Configuration (n,), m and rad.
            horizon: Clearances beyond it are given as infinite, save the smallest of all, m.
        """
        hands, mu, clearance = self.engine.measure(np.array(q, float), horizon)
        return Measurement(hands.reshape(-1, 3), mu, clearance)

    def along(self, q: ArrayLike, horizon: float = np.inf) -> Course:
        """Return the same for each configuration of a motion (N, n), clearances those of the nearest link."""
        hands, mu, clearance = self.engine.along(np.array(q, float, order="C"), horizon)
        return Course(hands.reshape(len(hands), -1, 3), mu, clearance)

    def gradient_projection(self, targets: ArrayLike, gains: Gains) -> Callable[[Array], Array]:
        """Return eq. 4.9 as a function: q_dot (n,) in m/s and rad/s at a configuration (n,) in m and rad.

        Args:
            targets: x_f (h, 3), m.
            gains: K, c_mu, c_kappa and the activation distance.

        Raises:
            InvalidInput: If the targets have another shape. The function raises ValueError for a configuration that has
                another size or is not finite.
        """
        points = np.array(targets, float)
        if points.shape != (len(self.robot.hands), 3):
            raise InvalidInput("targets", targets, f"an array of shape ({len(self.robot.hands)}, 3)")
        points = points.ravel()
        converted, velocity = native_gains(gains, points.size), self.engine.velocity
        return lambda q: velocity(q, points, converted)


def integrate(
    kinematics: Kinematics, method: str, start: Array, targets: Array, gains: Gains, settings: Settings
) -> Integration:
    """Integrate q_dot from the start until |e| falls to the tolerance or nothing more can come of it.

    Meanwhile other threads run. See :func:`humanoid_rail.integration.integrate`.
    """
    if method not in METHODS:
        raise InvalidInput("method", method, f"one of {', '.join(METHODS)}")
    K = gains.diagonal(targets.size)
    motion = kinematics.engine.integrate(
        start,
        targets.ravel(),
        native_gains(gains, targets.size),
        _engine.Settings(
            tolerance=settings.tolerance,
            dt=settings.dt,
            max_time=settings.max_time,
            rtol=settings.rtol,
            atol=settings.atol,
            max_evaluations=integration.MAX_EVALUATIONS,
            patience=integration.PATIENCE / K.min(),
        ),
    )
    status, t = _STATUS[motion.status], motion.t
    reason = explain(status, t[-1], motion.left, motion.evaluations, settings, motion.broken)
    return Integration(t, motion.q, status, reason, motion.evaluations, Motion(*motion.visited))


def native_gains(gains: Gains, size: int) -> _engine.Gains:
    """Return gains as the extension has them, K with `size` elements."""
    return _engine.Gains(gains.diagonal(size), gains.c_mu, gains.c_kappa, gains.epsilon)


def native_robot(robot: Robot) -> _engine.Robot:
    """Return a robot as the extension has it, made once for each robot."""
    if robot not in _robots:
        hands = [(robot.model.getFrameId(hand.frame), robot.arm_columns(hand)) for hand in robot.hands]
        model, bodies = robot.model.saveToString(), robot.collision_model.saveToString()
        _robots[robot] = _engine.Robot(model, bodies, robot.coupling, robot.offset, hands)
    return _robots[robot]


def native_obstacles(obstacles: tuple[Obstacle, ...]) -> _engine.Obstacles:
    """Return obstacles as the extension has them; beside `shapes.py`."""
    result = _engine.Obstacles()
    for obstacle in obstacles:
        match obstacle:
            case Sphere():
                result.sphere(np.array(obstacle.center), obstacle.radius)
            case Box():
                result.box(*_placement(obstacle), np.array(obstacle.size))
            case Capsule():
                result.capsule(*_placement(obstacle), obstacle.radius, obstacle.length)
            case HalfSpace():
                length = float(np.linalg.norm(obstacle.normal))
                result.halfspace(np.array(obstacle.normal) / length, obstacle.offset / length)
            case Mesh():
                result.convex(*_placement(obstacle), list(obstacle.pieces))
            case _:
                raise InvalidInput("obstacles", obstacle, "a Sphere, Box, Capsule, HalfSpace or Mesh")
    return result


def _placement(obstacle: Box | Capsule | Mesh) -> tuple[Array, Array]:
    return np.array(obstacle.center), pin.rpy.rpyToMatrix(*obstacle.rpy)
