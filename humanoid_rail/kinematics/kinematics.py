"""What is true of a robot among obstacles at one configuration: eq. 2.1, 2.2, 3.4 and the psi of eq. 3.3.

This is the reference, to be read; `native_kinematics.py` has the same in C++.

Shapes: n actuated joints, h hands, L links (collision bodies), O obstacles, K convex pieces of all obstacles, P pairs
of links to check against each other. Metres and radians, in the base frame.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import wraps
from typing import Any, NamedTuple, TypeVar, cast

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from humanoid_rail._arrays import Array, checked_array
from humanoid_rail.errors import checked_number
from humanoid_rail.kinematics.manipulability import manipulability, manipulability_gradient
from humanoid_rail.kinematics.state import Clearances, Course, Measurement, State, checked_course
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.scene.shapes import PlacedShape, placed_shapes

CYLINDER_TOLERANCE = 1e-10
"""coal's search ends at this precision where one body is a cylinder, whose normals are too rough otherwise."""
F = TypeVar("F", bound=Callable[..., Any])


def _one_at_a_time(method: F) -> F:
    """Have calls from several threads wait for one another: they share Pinocchio's workspace."""

    @wraps(method)
    def waiting(self: Kinematics, *arguments: Any, **named: Any) -> Any:
        with self._lock:
            return method(self, *arguments, **named)

    return cast(F, waiting)


class Kinematics:
    """A robot among obstacles, with the workspace that Pinocchio and coal need. Threads may share it."""

    def __init__(self, robot: Robot, obstacles: tuple[Obstacle, ...] = ()) -> None:
        self.robot = robot
        self.obstacles = obstacles
        self._pieces = [
            _Piece(piece, np.array(obstacle.velocity), i)
            for i, obstacle in enumerate(obstacles)
            for piece in placed_shapes(obstacle)
        ]
        self._data = robot.model.createData()
        self._bodies = robot.collision_model.createData()
        self._request, self._cylinder_request = coal.DistanceRequest(), coal.DistanceRequest()
        self._cylinder_request.gjk_tolerance = CYLINDER_TOLERANCE
        self._lock = threading.RLock()

    @_one_at_a_time
    def state(self, q: ArrayLike, t: float = 0.0) -> State:
        """Return everything that eq. 4.9 and its constraints need to know at a configuration (n,) and a time in s."""
        q, t = checked_array("q", q, (self.robot.n,)), checked_number("t", t)
        robot, model, data = self.robot, self.robot.model, self._data
        full = robot.full_configuration(q)
        pin.computeJointKinematicHessians(model, data, full)
        self._place()
        jacobians = [self._hand_jacobian(hand.frame) for hand in robot.hands]
        arms = [J[:3, robot.arm_columns(hand)] for J, hand in zip(jacobians, robot.hands, strict=True)]
        arm_derivatives = [self._hand_hessian(hand.frame)[:, robot.arm_columns(hand), :] for hand in robot.hands]
        links, link_jacobians = self._links(), [self._link_jacobian(i) for i in range(len(robot.link_names))]
        pieces = self._piece_clearances(t, links, link_jacobians)
        nearest = self._nearest_pieces(pieces.distance)
        return State(
            q=q,
            t=t,
            robot=robot,
            hands=self._hands(),
            rotations=np.array([self._data.oMf[model.getFrameId(hand.frame)].rotation for hand in robot.hands]),
            jacobian=np.vstack([J[:3] for J in jacobians]),
            angular_jacobian=np.vstack([J[3:] for J in jacobians]),
            manipulability=manipulability(arms),
            manipulability_gradient=manipulability_gradient(arms, arm_derivatives),
            clearance=np.take_along_axis(pieces.distance, nearest, axis=1),
            clearance_gradient=np.take_along_axis(pieces.gradient, nearest[:, :, None], axis=1),
            pieces=pieces,
            links=self._link_clearances(links, link_jacobians),
        )

    @_one_at_a_time
    def measure(self, q: ArrayLike, horizon: float = np.inf, t: float = 0.0) -> Measurement:
        """Return hands, manipulability and clearances at a configuration (n,), without derivatives.

        Args:
            q: Configuration (n,), m and rad.
            horizon: Clearances beyond it are infinite, except for the smallest of all, m. Those of pairs of links are
                given in any case.
            t: Time, which matters where obstacles move, s.
        """
        robot, t = self.robot, checked_number("t", t)
        full = robot.full_configuration(checked_array("q", q, (robot.n,)))
        pin.computeJointJacobians(robot.model, self._data, full)
        self._place()
        arms = [self._hand_jacobian(hand.frame)[:3, robot.arm_columns(hand)] for hand in robot.hands]
        links = self._links()
        shape = (len(links), len(self._pieces))
        distances = [
            [
                self._nearest(link, piece.at(t)).distance if moves or piece.velocity.any() else np.inf
                for piece in self._pieces
            ]
            for link, moves in zip(links, robot.moving_bodies, strict=True)
        ]
        pieces = np.array(distances).reshape(shape)
        clearance = np.take_along_axis(pieces, self._nearest_pieces(pieces), axis=1)
        between = [self._nearest(links[a], links[b]).distance for a, b in robot.self_collision_pairs]
        return Measurement(self._hands(), manipulability(arms), _up_to(horizon, clearance), np.array(between))

    @_one_at_a_time
    def along(self, q: ArrayLike, horizon: float = np.inf, t: ArrayLike | None = None) -> Course:
        """Return the same for each configuration of a motion (N, n), clearances those of the nearest link.

        Args:
            q: Configurations (N, n), m and rad.
            horizon: As for :meth:`measure`.
            t: Times (N,), which matter where obstacles move, s; 0 if not given.
        """
        q, times = checked_course(self.robot, q, t)
        measured = [self.measure(row, horizon, time) for row, time in zip(q, times, strict=True)]
        return Course(
            hands=np.array([m.hands for m in measured]),
            manipulability=np.array([m.manipulability for m in measured]),
            clearance=np.array([m.clearance.min(axis=0) for m in measured]),
        )

    @_one_at_a_time
    def hand_positions(self, q: ArrayLike) -> Array:
        """Return f(q) of eq. 2.1 (h, 3), m."""
        pin.framesForwardKinematics(self.robot.model, self._data, self.robot.full_configuration(q))
        return self._hands()

    @_one_at_a_time
    def stick_figure(self, q: ArrayLike) -> Array:
        """Return the origins (joints + h, 3) of all joints, passive ones included, and of the hands, m."""
        pin.framesForwardKinematics(self.robot.model, self._data, self.robot.full_configuration(q))
        return np.vstack([[M.translation for M in list(self._data.oMi)[1:]], self._hands()])

    @_one_at_a_time
    def bones(self, q: ArrayLike) -> Array:
        """Return the two end points (L, 2, 3) of the axis of every link, m. All links have to be capsules."""
        pin.forwardKinematics(self.robot.model, self._data, self.robot.full_configuration(q))
        self._place()
        half = [body.geometry.halfLength for body in self.robot.collision_model.geometryObjects]
        return np.array(
            [
                [M.translation - length * M.rotation[:, 2], M.translation + length * M.rotation[:, 2]]
                for M, length in zip(self._bodies.oMg, half, strict=True)
            ]
        )

    def _place(self) -> None:
        """Update the placements of frames and collision bodies after those of the joints."""
        pin.updateFramePlacements(self.robot.model, self._data)
        pin.updateGeometryPlacements(self.robot.model, self._data, self.robot.collision_model, self._bodies)

    def _hands(self) -> Array:
        model = self.robot.model
        return np.array([self._data.oMf[model.getFrameId(hand.frame)].translation for hand in self.robot.hands])

    def _hand_jacobian(self, frame: str) -> Array:
        """Return the linear and angular Jacobian of one hand (6, n): J_full S."""
        model, data = self.robot.model, self._data
        J = pin.getFrameJacobian(model, data, model.getFrameId(frame), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        hand: Array = J @ self.robot.coupling
        return hand

    def _hand_hessian(self, frame: str) -> Array:
        """Return dJ / dq of one hand (3, n, n), the last axis the joint it is derived by: S^T H_full S."""
        model, data, S = self.robot.model, self._data, self.robot.coupling
        H = pin.getFrameKinematicHessian(model, data, model.getFrameId(frame), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        # Pinocchio hands NumPy its column-major tensor as if it were row-major.
        H = np.reshape(np.ravel(H), H.shape, order="F")
        derivative: Array = np.einsum("ijk,ja,kb->iab", H[:3], S, S)
        return derivative

    def _links(self) -> list[PlacedShape]:
        bodies = self.robot.collision_model.geometryObjects
        return [PlacedShape(body.geometry, coal_placement(M)) for body, M in zip(bodies, self._bodies.oMg, strict=True)]

    def _piece_clearances(self, t: float, links: list[PlacedShape], jacobians: list[Array]) -> Clearances:
        """Return psi (L, K), d psi / dq and d psi / dt for each link and each convex piece.

        The distance between p1 on a link and p2 on an obstacle that moves at v changes by d psi / dq = -n^T dp1/dq and
        d psi / dt = n^T v, with n from the link to the obstacle. coal's normal points that way in penetration too, so
        this holds on both sides of contact. With V and W the linear and angular rows of the link's spatial Jacobian at
        the base's origin, dp1/dq = V + W x p1, and n^T (W x p1) = (p1 x n)^T W: a unit force along n at p1, seen by the
        joints. Two of which neither ever moves are no pair: psi is infinite.
        """
        shape = (len(links), len(self._pieces))
        result = Clearances(np.zeros(shape), np.zeros((*shape, self.robot.n)), np.zeros(shape))
        pieces = [(piece.at(t), piece.velocity) for piece in self._pieces]
        for i, (link, J) in enumerate(zip(links, jacobians, strict=True)):
            for k, (piece, velocity) in enumerate(pieces):
                if not self.robot.moving_bodies[i] and not velocity.any():
                    result.distance[i, k] = np.inf
                    continue
                nearest = self._nearest(link, piece)
                result.distance[i, k] = nearest.distance
                result.gradient[i, k] = -nearest.wrench @ J
                result.rate[i, k] = nearest.normal @ velocity
        return result

    def _link_clearances(self, links: list[PlacedShape], jacobians: list[Array]) -> Clearances:
        """Return the distances (P,) of pairs of links, and d/dq = n^T (dp2/dq - dp1/dq): both forces act at p1."""
        pairs = self.robot.self_collision_pairs
        result = Clearances(np.zeros(len(pairs)), np.zeros((len(pairs), self.robot.n)), np.zeros(len(pairs)))
        for i, (one, two) in enumerate(pairs):
            nearest = self._nearest(links[one], links[two])
            result.distance[i] = nearest.distance
            result.gradient[i] = nearest.wrench @ (jacobians[two] - jacobians[one])
        return result

    def _link_jacobian(self, link: int) -> Array:
        """Return the spatial Jacobian (6, n) of a link at the base's origin."""
        joint = self.robot.collision_model.geometryObjects[link].parentJoint
        J = pin.getJointJacobian(self.robot.model, self._data, joint, pin.ReferenceFrame.WORLD)
        jacobian: Array = J @ self.robot.coupling
        return jacobian

    def _nearest_pieces(self, distance: Array) -> NDArray[np.intp]:
        """Return for each link and obstacle (L, O) the piece that is nearest, given the distances (L, K)."""
        of = np.array([piece.obstacle for piece in self._pieces], int)
        pieces = [np.flatnonzero(of == obstacle) for obstacle in range(len(self.obstacles))]
        nearest = [some[distance[:, some].argmin(axis=1)] for some in pieces]
        return np.array(nearest, int).reshape(len(pieces), len(distance)).T

    def _nearest(self, one: PlacedShape, two: PlacedShape) -> _Nearest:
        """Return how near two convex bodies are, the point on the first and the normal towards the second."""
        result = coal.DistanceResult()
        is_cylinder = isinstance(one.shape, coal.Cylinder) or isinstance(two.shape, coal.Cylinder)
        request = self._cylinder_request if is_cylinder else self._request
        distance = coal.distance(one.shape, one.placement, two.shape, two.placement, request, result)
        return _Nearest(distance, result.getNearestPoint1(), result.normal)


def _up_to(horizon: float, clearance: Array) -> Array:
    """Return clearances with those beyond the horizon infinite, except for the smallest."""
    return np.where(clearance <= max(horizon, clearance.min(initial=np.inf)), clearance, np.inf)


class _Piece(NamedTuple):
    """A convex piece of an obstacle."""

    start: PlacedShape
    """At t = 0."""
    velocity: Array
    obstacle: int

    def at(self, t: float) -> PlacedShape:
        """Return where it is at a time."""
        shape, placement = self.start
        moved = coal.Transform3s(placement.getRotation(), placement.getTranslation() + t * self.velocity)
        return PlacedShape(shape, moved)


class _Nearest(NamedTuple):
    distance: float
    point: Array
    normal: Array

    @property
    def wrench(self) -> Array:
        """A unit force along the normal at the point, and its moment about the base's origin."""
        (x, y, z), (a, b, c) = self.point, self.normal
        return np.array([a, b, c, y * c - z * b, z * a - x * c, x * b - y * a])
