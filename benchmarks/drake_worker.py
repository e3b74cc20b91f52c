"""Optimises motions by Drake's KinematicTrajectoryOptimization for `compare_motions.py`.

A cubic B-spline from rest to rest between two given configurations, in the least time within the limits of position,
velocity and acceleration, as far from everything as this package's plans keep, at samples. Drake has no proof for what
is between them.
"""

from __future__ import annotations

import time
import xml.etree.ElementTree as ET
from typing import Any, NamedTuple

import coal
import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    CollisionFilterDeclaration,
    GeometryId,
    GeometrySet,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.inverse_kinematics import MinimumDistanceLowerBoundConstraint
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    CoulombFriction,
    DiscreteContactApproximation,
    MultibodyPlant,
)
from pydrake.planning import KinematicTrajectoryOptimization
from pydrake.solvers import SnoptSolver, SolverOptions
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.trajectories import BsplineTrajectory
from scipy.interpolate import BSpline, CubicHermiteSpline

from benchmarks.worker import serve
from humanoid_rail import InvalidInput, Robot, Scene, load_robot, load_scene
from humanoid_rail._arrays import Array
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.scene.shapes import placed_shapes

CONTROL_POINTS, ORDER = 30, 4
SAMPLES = 150
"""Distances are kept at so many samples; with 100, motions cut the boards of `deep`."""
INFLUENCE = 0.05
"""Pairs that are farther than this beyond the safety distance are not looked at, m."""
MARGIN = 1e-5
"""This share of the limits is left, because solvers keep constraints up to a tolerance."""
LEAST_DURATION, LONGEST_DURATION = 0.1, 60.0
"""The motion takes from this to this, s."""
SETTINGS = {"Major iterations limit": 300, "Major optimality tolerance": 1e-3}
"""Of SNOPT; the tolerance is 1e-6 by default, which takes longer and shortens no motion by a thousandth."""
FREE = 1e3
"""Passive joints have limits of this size in the program, that is none; they follow the others."""
FINE = 1e-3
"""The motion is handed over with this time between its samples, s."""


class Model(NamedTuple):
    """A robot among obstacles, as Drake has it."""

    diagram: Diagram
    plant: MultibodyPlant
    context: Context
    """Of the plant."""
    leading: list[int]
    """The columns of the joints that are planned for among the plant's positions."""
    coupling: Array
    """All the plant's positions (m,) are this (m, n) times the joints that are planned for, plus the next."""
    offset: Array


def make_model(robot: Robot, scene: Scene) -> Model:
    """Return a robot with its own collision bodies in a scene.

    Raises:
        InvalidInput: If there is an obstacle that moves, or that Drake does not have.
    """
    builder = DiagramBuilder()
    # Couplings of joints need a discrete plant of this kind; nothing is simulated.
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, MultibodyPlant(time_step=1e-3))
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    Parser(plant).AddModelsFromString(without_bodies(robot.urdf), "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(robot.model.frames[1].name))
    bodies: list[GeometryId] = []
    for body in robot.collision_model.geometryObjects:
        frame = robot.model.frames[body.parentFrame]
        placement = RigidTransform((frame.placement.inverse() * body.placement).homogeneous)
        link, shape = plant.GetBodyByName(frame.name), drake_shape(body.geometry)
        bodies.append(plant.RegisterCollisionGeometry(link, placement, shape, body.name, CoulombFriction()))
    for k, obstacle in enumerate(scene.obstacles):
        if any(obstacle.velocity):
            raise InvalidInput("obstacles", obstacle, "one at rest, for Drake")
        for piece, (shape, placed) in enumerate(placed_shapes(obstacle)):
            at = RigidTransform(RotationMatrix(placed.getRotation()), placed.getTranslation())
            name = f"obstacle {k} {piece}"
            plant.RegisterCollisionGeometry(plant.world_body(), at, drake_shape(shape), name, CoulombFriction())
    plant.Finalize()
    checked = {frozenset(pair) for pair in robot.self_collision_pairs}
    for i, one in enumerate(bodies):
        for j, other in enumerate(bodies[:i]):
            if frozenset((i, j)) not in checked:
                neither = CollisionFilterDeclaration().ExcludeBetween(GeometrySet(one), GeometrySet(other))
                scene_graph.collision_filter_manager().Apply(neither)
    diagram = builder.Build()
    context = plant.GetMyMutableContextFromRoot(diagram.CreateDefaultContext())
    at = [plant.GetJointByName(name).position_start() for name in robot.model.names[1:]]
    coupling, offset = np.zeros((len(at), robot.n)), np.zeros(len(at))
    coupling[at], offset[at] = robot.coupling, robot.offset
    leading = [plant.GetJointByName(name).position_start() for name in robot.joint_names]
    return Model(diagram, plant, context, leading, coupling, offset)


def without_bodies(urdf: str) -> str:
    """Return a URDF without its shapes: those of collisions are added as this package has them."""
    root = ET.fromstring(urdf)
    for link in root.iter("link"):
        for name in ("visual", "collision", "collision_checking"):
            for element in link.findall(name):
                link.remove(element)
    return ET.tostring(root, encoding="unicode")


def drake_shape(shape: coal.CollisionGeometry) -> Shape:
    """Return a shape as Drake has it.

    Raises:
        InvalidInput: If it is none of those that are told apart here.
    """
    match shape:
        case coal.Sphere():
            return Sphere(shape.radius)
        case coal.Box():
            return Box(*(2.0 * shape.halfSide))
        case coal.Capsule():
            return Capsule(shape.radius, 2.0 * shape.halfLength)
    raise InvalidInput("obstacles", type(shape).__name__, "a Sphere, a Box or a Capsule, for Drake")


def make_program(robot: Robot, model: Model, start: Array, goal: Array) -> KinematicTrajectoryOptimization:
    """Return the program of the motion of least time from rest to rest between two configurations (n,)."""
    size = len(model.offset)
    program = KinematicTrajectoryOptimization(size, CONTROL_POINTS, ORDER)
    points = program.control_points()
    for passive in set(range(size)) - set(model.leading):
        for k in range(CONTROL_POINTS):
            follows = model.coupling[passive] @ points[model.leading, k] + model.offset[passive]
            program.get_mutable_prog().AddLinearEqualityConstraint(points[passive, k] - follows, 0.0)

    def spread(limit: Array, elsewhere: float) -> Array:
        values = np.full(size, elsewhere)
        values[model.leading] = limit
        return values

    velocity = spread((1.0 - MARGIN) * robot.velocity_limit, FREE)
    acceleration = spread((1.0 - MARGIN) * robot.acceleration_limit, FREE)
    program.AddPositionBounds(spread(robot.lower, -FREE), spread(robot.upper, FREE))
    program.AddVelocityBounds(-velocity, velocity)
    program.AddAccelerationBounds(-acceleration, acceleration)
    program.AddDurationConstraint(LEAST_DURATION, LONGEST_DURATION)
    program.AddDurationCost(1.0)
    for q, s in ((start, 0.0), (goal, 1.0)):
        at = model.coupling @ q + model.offset
        program.AddPathPositionConstraint(at, at, s)
        program.AddPathVelocityConstraint(np.zeros(size), np.zeros(size), s)
    distance = MinimumDistanceLowerBoundConstraint(
        model.plant, Safety().safety_distance, model.context, None, INFLUENCE
    )
    for s in np.linspace(0.0, 1.0, SAMPLES + 2)[1:-1]:
        program.AddPathPositionConstraint(distance, s)
    return program


def set_seed(program: KinematicTrajectoryOptimization, model: Model, q: Array, duration: float) -> None:
    """Begin at the spline that is nearest to configurations (K, n) at even times of a duration in s."""
    basis = program.basis()
    matrix = BSpline.design_matrix(np.linspace(0.0, 1.0, len(q)), np.array(basis.knots()), ORDER - 1).toarray()
    points = np.linalg.lstsq(matrix, q @ model.coupling.T + model.offset, rcond=None)[0]
    scaled = type(basis)(ORDER, list(duration * np.array(basis.knots())))
    program.SetInitialGuess(BsplineTrajectory(scaled, [point[:, None] for point in points]))


def answer(robot: Robot, request: dict[str, Any]) -> dict[str, Any]:
    """Return the motion that comes of a seed, which is straight if that is asked for, and the processor time."""
    try:
        model = make_model(robot, load_scene(request["scene"]))
    except InvalidInput as error:
        return {"failed": str(error), "planning_time": 0.0}
    t, q, velocity = (np.array(request[name]) for name in ("t", "q", "velocity"))
    share = np.linspace(0.0, 1.0, 400)
    seed = CubicHermiteSpline(t, q, velocity)(share * t[-1])
    if request["straight"]:
        seed = q[0] + share[:, None] * (q[-1] - q[0])
    options = SolverOptions()
    for name, value in SETTINGS.items():
        options.SetOption(SnoptSolver.id(), name, value)
    started = time.process_time()
    program = make_program(robot, model, q[0], q[-1])
    set_seed(program, model, seed, float(t[-1]))
    result = SnoptSolver().Solve(program.prog(), None, options)
    spent = time.process_time() - started
    if not result.is_success():
        return {"failed": f"SNOPT says {result.get_solution_result().name}", "planning_time": spent}
    found = program.ReconstructTrajectory(result)
    times = np.append(np.arange(0.0, found.end_time() - 0.5 * FINE, FINE), found.end_time())
    rate = found.MakeDerivative()
    return {
        "planning_time": spent,
        "time": spent,
        "reason": f"SNOPT says {result.get_solution_result().name}",
        "t": times.tolist(),
        "q": found.vector_values(times)[model.leading].T.tolist(),
        "velocity": rate.vector_values(times)[model.leading].T.tolist(),
    }


def main() -> None:
    """Answer requests until stdin ends."""
    robot = load_robot()
    serve(lambda request: answer(robot, request))


if __name__ == "__main__":
    main()
