"""Pink (https://github.com/stephane-caron/pink) on the same robot, targets and obstacles, for comparisons.

Each hand has a frame task on its position, each pair of a link and an obstacle a row in a control barrier function.
There are no other tasks, and unless asked for no limits and no pairs of two links, as in eq. 4.9. Needs the extra
`compare`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pink
import pinocchio as pin
from pink.barriers import SelfCollisionBarrier
from pink.exceptions import PinkError
from pink.tasks import FrameTask
from qpsolvers.exceptions import QPError

from benchmarks.planners import FAILED
from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.robot import Robot
from humanoid_rail.resolution.qp import PRECISION
from humanoid_rail.result import Status
from humanoid_rail.scene.obstacles import is_moving
from humanoid_rail.scene.scene import Scene, start_of_scene, target_points
from humanoid_rail.scene.shapes import placed_shapes

SOLVER = "daqp"
"""The fastest of the QP solvers that Pink takes, on problems of this size."""


@dataclass(frozen=True)
class Rollout:
    """Where Pink went."""

    t: Array
    """Times (N,), s."""
    q: Array
    """Configurations (N, n), m and rad."""
    status: str
    """A :class:`Status`, or `failed`."""
    reason: str
    """The status in a sentence."""

    @property
    def reached(self) -> bool:
        """Whether |e| fell to the tolerance."""
        return self.status == Status.REACHED


class Pink:
    """Pink's inverse kinematics for a scene. The passive joints follow their leaders as Pinocchio's mimic joints."""

    def __init__(
        self,
        robot: Robot,
        scene: Scene,
        dt: float = 0.01,
        gain: float = 1.0,
        barriers: bool = True,
        safety_distance: float | None = None,
    ) -> None:
        """Set Pink up at the start of a scene.

        Args:
            robot: The robot.
            scene: Start, targets and obstacles.
            dt: How long a velocity is held, s.
            gain: Of the hands' errors, 1/s.
            barriers: Whether to keep clear of the obstacles.
            safety_distance: What the barriers keep, m. If given there are barriers between links too, and limits of
                position and speed: all that Pink has to move a robot safely.

        Raises:
            InvalidInput: If an obstacle moves, which Pink's barriers cannot know.
        """
        for i, obstacle in enumerate(scene.obstacles):
            if is_moving(obstacle):
                raise InvalidInput(f"obstacles[{i}].velocity", obstacle.velocity, "0, 0, 0: Pink knows no other")
        self.dt = dt
        self.model = pin.buildModelFromXML(robot.urdf, True)
        # Without `limits` there are all of the model. The solver's own tolerance, 1e-6, would let joints creep beyond.
        self.options: dict[str, object] = {"limits": []} if safety_distance is None else {"primal_tol": PRECISION}
        if safety_distance is None:
            # Pink would log every step beyond them.
            self.model.lowerPositionLimit[:], self.model.upperPositionLimit[:] = -np.inf, np.inf
        bodies = _bodies(self.model, robot, scene) if barriers else None
        if bodies and safety_distance is not None:
            for pair in robot.self_collision_pairs:
                bodies.addCollisionPair(pin.CollisionPair(*pair))
        start = np.array(start_of_scene(robot, scene))
        self.configuration = pink.Configuration(
            self.model,
            self.model.createData(),
            start,
            collision_model=bodies,
            collision_data=bodies.createData() if bodies else None,
        )
        pairs = len(bodies.collisionPairs) if bodies else 0
        # At its default gain Pink gets farther among shelves than at that of `qp`, which is ten times as large.
        self.barriers = [SelfCollisionBarrier(pairs, d_min=safety_distance or 0.0)] if pairs else []
        self.tasks = []
        self.targets = target_points(robot, scene)
        for hand, target in zip(robot.hands, self.targets, strict=True):
            # In Pink a gain is the share of the error that a step takes away.
            task = FrameTask(hand.frame, position_cost=1.0, orientation_cost=0.0, gain=gain * dt)
            task.set_target(pin.SE3(np.eye(3), target))
            self.tasks.append(task)
        self.frames = [hand.frame for hand in robot.hands]

    def velocity(self) -> Array:
        """Return q_dot (n,) where the robot is."""
        velocity: Array = pink.solve_ik(
            self.configuration,
            self.tasks,
            self.dt,
            SOLVER,
            barriers=self.barriers,
            safety_break=False,
            **self.options,
        )
        return velocity

    def error(self) -> float:
        """Return |e| where the robot is, m."""
        hands = [self.configuration.get_transform_frame_to_world(frame).translation for frame in self.frames]
        return float(np.linalg.norm(np.array(hands) - self.targets))

    def at(self, q: Array) -> Array:
        """Return q_dot (n,) at another configuration (n,), everything that takes included."""
        self.configuration.update(q)
        return self.velocity()

    def rollout(self, tolerance: float = 0.01, max_time: float = 60.0, patience: float = np.inf) -> Rollout:
        """Step until |e| falls to the tolerance or nothing more can come of it.

        Args:
            tolerance: Of |e|, m.
            max_time: Longest motion, s.
            patience: So long without any progress, as `qp` counts it, a motion has stalled, s.
        """
        path = [self.configuration.q.copy()]
        left = best = self.error()
        best_step = 0

        def ended(status: str, why: str = "") -> Rollout:
            t: Array = self.dt * np.arange(len(path), dtype=float)
            return Rollout(t, np.array(path), status, f"|e| is {left:.4g} m at t = {t[-1]:.4g} s{why}")

        while left > tolerance:
            step = len(path)
            if step * self.dt >= max_time:
                return ended(Status.TIME_LIMIT)
            if (step - best_step) * self.dt > patience:
                return ended(Status.STALLED)
            try:
                velocity = self.velocity()
            except (PinkError, QPError) as error:
                return ended(FAILED, f": {type(error).__name__}")
            self.configuration.integrate_inplace(velocity, self.dt)
            path.append(self.configuration.q.copy())
            left = self.error()
            if left < (1.0 - engine().PROGRESS) * best:
                best, best_step = left, step
        return ended(Status.REACHED)


def _bodies(model: pin.Model, robot: Robot, scene: Scene) -> pin.GeometryModel:
    """Return links and obstacles, and all pairs of one and the other."""
    bodies = pin.buildGeomFromUrdfString(model, robot.urdf, pin.GeometryType.COLLISION)
    links = range(bodies.ngeoms)
    for i, obstacle in enumerate(scene.obstacles):
        for j, (shape, placement) in enumerate(placed_shapes(obstacle)):
            where = pin.SE3(placement.getRotation(), placement.getTranslation())
            index = bodies.addGeometryObject(pin.GeometryObject(f"obstacle_{i}_{j}", 0, where, shape))
            for link in links:
                bodies.addCollisionPair(pin.CollisionPair(link, index))
    return bodies
