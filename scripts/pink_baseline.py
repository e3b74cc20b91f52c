"""Pink (https://github.com/stephane-caron/pink) on the same robot, targets and obstacles, for comparisons.

Each hand has a frame task on its position, each pair of a link and an obstacle a row in a control barrier function.
There are no limits and no other tasks, as in eq. 4.9. Needs the extra `compare`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pink
import pinocchio as pin
from pink.barriers import SelfCollisionBarrier
from pink.tasks import FrameTask

from humanoid_rail import Robot, Scene
from humanoid_rail.arrays import Array
from humanoid_rail.shapes import placed_shapes

SOLVER = "daqp"
"""The fastest of the QP solvers that Pink takes, on problems of this size."""


@dataclass(frozen=True)
class Rollout:
    """Where Pink went."""

    q: Array
    """Configurations (N, n), dt apart."""
    reached: bool
    """Whether |e| fell to the tolerance."""


class Pink:
    """Pink's inverse kinematics for a scene. The passive joints follow their leaders as Pinocchio's mimic joints."""

    def __init__(self, robot: Robot, scene: Scene, dt: float = 0.01, gain: float = 1.0, barriers: bool = True) -> None:
        self.dt = dt
        self.model = pin.buildModelFromXML(robot.urdf, True)
        # Eq. 4.9 knows no limits either; and Pink would log every step beyond them.
        self.model.lowerPositionLimit[:], self.model.upperPositionLimit[:] = -np.inf, np.inf
        bodies = _bodies(self.model, robot, scene) if barriers else None
        start = np.array(robot.initial if scene.initial is None else scene.initial, float)
        self.configuration = pink.Configuration(
            self.model,
            self.model.createData(),
            start,
            collision_model=bodies,
            collision_data=bodies.createData() if bodies else None,
        )
        pairs = len(bodies.collisionPairs) if bodies else 0
        self.barriers = [SelfCollisionBarrier(pairs, d_min=0.0)] if pairs else []
        self.tasks = []
        for hand in robot.hands:
            # In Pink a gain is the share of the error that a step takes away.
            task = FrameTask(hand.frame, position_cost=1.0, orientation_cost=0.0, gain=gain * dt)
            task.set_target(pin.SE3(np.eye(3), np.array(scene.targets[hand.name])))
            self.tasks.append(task)
        self.frames = [hand.frame for hand in robot.hands]
        self.targets = np.array([scene.targets[hand.name] for hand in robot.hands])

    def velocity(self) -> Array:
        """Return q_dot (n,) where the robot is."""
        velocity: Array = pink.solve_ik(
            self.configuration, self.tasks, self.dt, SOLVER, limits=[], barriers=self.barriers, safety_break=False
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

    def rollout(self, tolerance: float = 0.01, max_time: float = 60.0) -> Rollout:
        """Step until |e| falls to the tolerance, m, or the time is over, s."""
        path = [self.configuration.q.copy()]
        while self.error() > tolerance and len(path) * self.dt < max_time:
            self.configuration.integrate_inplace(self.velocity(), self.dt)
            path.append(self.configuration.q.copy())
        return Rollout(np.array(path), self.error() <= tolerance)


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
