"""Kinematics and clearances: against the DH oracle, analytic distances and central differences."""

from __future__ import annotations

from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest
import trimesh
from conftest import assert_gradient, central_difference, random_q
from scipy.spatial import cKDTree
from trimesh.transformations import translation_matrix as translation

from humanoid_rail import Box, Capsule, Cylinder, HalfSpace, Mesh, Robot, Sphere, load_robot
from humanoid_rail.kinematics.kinematics import manipulability_gradient
from humanoid_rail.paper import dh_table as dh
from humanoid_rail.scene.obstacles import Obstacle

ARMS = slice(4, 12)


def dh_manipulability(q: np.ndarray) -> float:
    """Return eq. 3.4 from the DH table alone."""
    J = central_difference(lambda q: dh.hands(q).ravel(), q)[:, ARMS]
    return float(np.sqrt(max(np.linalg.det(J @ J.T), 0.0)))


def test_hands_and_jacobian_are_the_papers(robot: Robot, rng: np.random.Generator, Kinematics: type) -> None:
    kinematics = Kinematics(robot)
    for _ in range(50):
        q = random_q(robot, rng)
        state = kinematics.state(q)
        np.testing.assert_allclose(state.hands, dh.hands(q), atol=1e-12)
        assert_gradient(lambda q: dh.hands(q).ravel(), state.jacobian, q)
        for column in range(12):
            error = state.jacobian[:, column] - central_difference(lambda q: dh.hands(q).ravel(), q)[:, column]
            assert np.linalg.norm(error) <= 1e-8
        assert not state.jacobian[:3, 8:].any()  # the zero blocks of eq. 2.2
        assert not state.jacobian[3:, 4:8].any()


def test_manipulability_is_eq_3_4(robot: Robot, rng: np.random.Generator, Kinematics: type) -> None:
    kinematics = Kinematics(robot)
    assert kinematics.state(robot.initial).manipulability == pytest.approx(2.0, abs=1e-12)
    for _ in range(50):
        q = random_q(robot, rng)
        state = kinematics.state(q)
        J = state.jacobian[:, ARMS]
        assert state.manipulability == pytest.approx(np.sqrt(np.linalg.det(J @ J.T)), rel=1e-9)
        assert state.manipulability == pytest.approx(dh_manipulability(q), rel=1e-6, abs=1e-7)


def test_manipulability_depends_on_the_arms_alone(robot: Robot, rng: np.random.Generator, Kinematics: type) -> None:
    kinematics = Kinematics(robot)
    q, other = random_q(robot, rng), random_q(robot, rng)
    other[ARMS] = q[ARMS]
    assert kinematics.measure(q).manipulability == pytest.approx(kinematics.measure(other).manipulability, rel=1e-12)
    np.testing.assert_allclose(kinematics.state(q).manipulability_gradient[:4], 0.0, atol=1e-13)


def test_manipulability_gradient(robot: Robot, rng: np.random.Generator, Kinematics: type) -> None:
    kinematics = Kinematics(robot)
    for _ in range(50):
        q = random_q(robot, rng)
        assert_gradient(lambda q: kinematics.measure(q).manipulability, kinematics.state(q).manipulability_gradient, q)


@pytest.mark.parametrize("distance", [1e-3, 1e-6])
def test_manipulability_gradient_next_to_a_singularity(
    robot: Robot, rng: np.random.Generator, distance: float, Kinematics: type
) -> None:
    """The left arm is singular where its forearm points along the axis of the shoulder's first joint."""
    kinematics = Kinematics(robot)
    q = random_q(robot, rng)
    q[4:8] = [0.3, np.pi / 2, 0.4, 0.0]  # the hand on the axis of shoulder_roll, the arm stretched
    q[7] += distance
    state = kinematics.state(q)
    h = distance / 100
    numeric = central_difference(lambda q: kinematics.measure(q).manipulability, q, h)
    assert np.linalg.norm(state.manipulability_gradient - numeric) <= 1e-3 * np.linalg.norm(numeric)


def test_manipulability_gradient_is_zero_where_manipulability_is() -> None:
    stretched = np.array([[0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 0.0]])
    derivative = np.random.default_rng(0).normal(size=(3, 4, 12))
    arms = [stretched, np.eye(3, 4)]
    np.testing.assert_array_equal(manipulability_gradient(arms, [derivative, derivative]), np.zeros(12))


def obstacles(cube: str) -> dict[str, tuple[Obstacle, ...]]:
    """Return obstacles of each kind all around the rail."""
    rng = np.random.default_rng(3)

    def places(n: int = 6) -> list[list[float]]:
        return rng.uniform([-1.5, -0.5, 1.5], [1.5, 4.5, 4.0], (n, 3)).tolist()

    def rpy() -> list[float]:
        return rng.uniform(-3, 3, 3).tolist()

    return {
        "sphere": tuple(Sphere(center=p, radius=0.3) for p in places()),
        "box": tuple(Box(center=p, size=[0.5, 0.3, 0.8], rpy=rpy()) for p in places()),
        "capsule": tuple(Capsule(center=p, radius=0.2, length=0.6, rpy=rpy()) for p in places()),
        "halfspace": tuple(HalfSpace(normal=rpy(), offset=-1.0) for _ in range(4)),
        "mesh": tuple(Mesh(file=cube, center=p, rpy=rpy(), scale=[0.5, 0.3, 0.8]) for p in places()),
        "cylinder": tuple(Cylinder(center=p, radius=0.3, length=0.6, rpy=rpy()) for p in places()),
    }


@pytest.mark.parametrize("kind", ["sphere", "box", "capsule", "cylinder", "halfspace", "mesh"])
@pytest.mark.parametrize("radius", [0.05, 0.0])
def test_clearance_gradients_on_both_sides_of_contact(
    kind: str, radius: float, cube_file: str, rng: np.random.Generator, Kinematics: type
) -> None:
    """Every column, of every link and obstacle; configurations where the nearest point jumps are left out."""
    robot = load_robot(link_radius=radius)
    kinematics = Kinematics(robot, obstacles(cube_file)[kind])
    h, seen = 1e-6, {"apart": 0, "contact": 0, "jumps": 0}
    for _ in range(40):
        q = random_q(robot, rng)
        state = kinematics.state(q)
        numeric = central_difference(lambda q: kinematics.measure(q).clearance, q, h)
        nearby = [kinematics.state(q + step).clearance_gradient for step in h * rng.normal(size=(3, 12))]
        for pair in np.ndindex(state.clearance.shape):
            gradient = state.clearance_gradient[pair]
            jump = max(np.linalg.norm(other[pair] - gradient) for other in nearby)
            if jump > 1e-3:
                seen["jumps"] += 1
                continue
            # coal finds nearest points of cylinders step by step, and depths by flat pieces in place of round faces.
            rough = 2e-2 if state.clearance[pair] < 0 else 1e-3
            precise = rough if kind == "cylinder" else 1e-6
            error = np.linalg.norm(gradient - numeric[pair])
            assert error <= precise * max(np.linalg.norm(gradient), 1e-3), (kind, pair)
            seen["contact" if state.clearance[pair] < 0 else "apart"] += 1
    assert seen["contact"] >= (20 if kind == "halfspace" else 3), seen
    assert seen["apart"] >= 500, seen
    assert seen["jumps"] <= 0.02 * sum(seen.values()), seen


def segment_distance(a: np.ndarray, b: np.ndarray, p: np.ndarray) -> float:
    s = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return float(np.linalg.norm(a + s * (b - a) - p))


@pytest.mark.parametrize("radius", [0.05, 0.0])
def test_clearance_of_spheres_and_half_spaces_is_the_analytic_one(
    radius: float, rng: np.random.Generator, Kinematics: type
) -> None:
    robot = load_robot(link_radius=radius)
    center, normal = np.array([-0.5, 1.5, 2.8]), np.array([0.3, 0.4, 1.2])
    kinematics = Kinematics(robot, (Sphere(center=center, radius=0.4), HalfSpace(normal=normal, offset=2.6)))
    for _ in range(100):
        q = random_q(robot, rng)
        measured = kinematics.measure(q).clearance
        for psi, (a, b) in zip(measured, dh.bones(q).values(), strict=True):
            heights = np.array([a, b]) @ normal / np.linalg.norm(normal) - 2.6 / np.linalg.norm(normal)
            expected = [segment_distance(a, b, center) - 0.4 - radius, heights.min() - radius]
            np.testing.assert_allclose(psi, expected, atol=1e-9)


def rotation(rpy: np.ndarray) -> np.ndarray:
    """Return Rz(yaw) Ry(pitch) Rx(roll), URDF's convention, by hand."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    Rx = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    Ry = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    Rz = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return Rz @ Ry @ Rx


def distance_between(link: np.ndarray, inside: np.ndarray) -> float:
    """Return the distance of a segment from a point set, sampled densely enough to be right to 1e-3 m."""
    along = link[0] + np.linspace(0, 1, 400)[:, None] * (link[1] - link[0])
    return float(cKDTree(inside).query(along)[0].min())


def test_capsules_and_boxes_are_where_rpy_and_size_put_them(
    robot: Robot, rng: np.random.Generator, Kinematics: type
) -> None:
    """All three angles, the length between the end spheres, the full edge lengths; against points of the solids."""
    for _ in range(8):
        rpy, center = rng.uniform(-3, 3, 3), rng.uniform([-1.5, 0, 1.5], [1.5, 4, 4], 3)
        capsule = Capsule(center=center, radius=0.15, length=0.8, rpy=rpy)
        box = Box(center=center, size=[0.3, 0.6, 1.0], rpy=rpy)
        axis = center + np.linspace(-0.4, 0.4, 800)[:, None] * rotation(rpy)[:, 2]
        grid = np.stack(np.meshgrid(*(np.linspace(-s / 2, s / 2, 60) for s in box.size)), axis=-1).reshape(-1, 3)
        solid = center + grid @ rotation(rpy).T
        q = random_q(robot, rng)
        psi = Kinematics(robot, (capsule, box)).measure(q).clearance
        for (to_capsule, to_box), bone in zip(psi, dh.bones(q).values(), strict=True):
            assert to_capsule == pytest.approx(distance_between(bone, axis) - 0.15 - 0.05, abs=2e-3)
            if to_box > 0.05:
                assert to_box == pytest.approx(distance_between(bone, solid) - 0.05, abs=2e-2)


def test_a_mesh_of_several_pieces_is_as_near_as_its_nearest(robot: Robot, tmp_path: Path, Kinematics: type) -> None:
    """An L of two boxes, against the two boxes, from everywhere."""
    upright = trimesh.creation.box((0.2, 0.4, 1.0), transform=translation([0.0, 0.0, 0.5]))
    foot = trimesh.creation.box((0.8, 0.4, 0.2), transform=translation([0.3, 0.0, 0.1]))
    ell = trimesh.boolean.union([upright, foot], engine="manifold")
    ell.export(tmp_path / "ell.ply")
    rng = np.random.default_rng(5)
    for center in ([-1.0, 1.0, 2.5], [-0.8, 2.5, 3.0], [1.2, 1.0, 2.8]):
        mesh = Mesh(file=str(tmp_path / "ell.ply"), center=center)
        assert len(mesh.pieces) >= 2
        boxes = (
            Box(center=np.add(center, [0.0, 0.0, 0.5]), size=(0.2, 0.4, 1.0)),
            Box(center=np.add(center, [0.3, 0.0, 0.1]), size=(0.8, 0.4, 0.2)),
        )
        kinematics = Kinematics(robot, (mesh, *boxes))
        for _ in range(10):
            psi = kinematics.measure(random_q(robot, rng)).clearance
            expected = psi[:, 1:].min(axis=1)
            apart = expected > 0.0
            np.testing.assert_allclose(psi[apart, 0], expected[apart], atol=2e-3)
            assert (psi[expected < -2e-3, 0] < 0).all()


def test_a_mesh_has_an_inside(robot: Robot, cube_file: str, Kinematics: type) -> None:
    """A link wholly inside a mesh is in penetration, as it is inside the same box."""
    where = dh.bones(robot.initial)["left_forearm"].mean(axis=0)
    mesh, box = Mesh(file=cube_file, center=where, scale=4.0), Box(center=where, size=[4.0, 4.0, 4.0])
    clearance = Kinematics(robot, (mesh, box)).measure(robot.initial).clearance
    assert clearance[5, 0] < -1.0
    np.testing.assert_allclose(clearance[:, 0], clearance[:, 1], atol=1e-6)


def test_no_obstacles(robot: Robot, Kinematics: type) -> None:
    state = Kinematics(robot).state(robot.initial)
    assert state.clearance.shape == (9, 0)
    assert state.clearance_gradient.shape == (9, 0, 12)


# Facts about the libraries that the design rests on: these tests notice the day they stop being true.


def test_coal_normal_points_from_the_first_body_to_the_second_also_in_penetration() -> None:
    for z in (1.0, 0.35):
        result = coal.DistanceResult()
        capsule, sphere = coal.Capsule(0.2, 1.0), coal.Sphere(0.3)
        x = coal.Transform3s(np.eye(3), np.array([z, 0.0, 0.0]))
        distance = coal.distance(capsule, coal.Transform3s(), sphere, x, coal.DistanceRequest(), result)
        assert distance == pytest.approx(z - 0.5)
        np.testing.assert_allclose(result.normal, [1.0, 0.0, 0.0], atol=1e-9)


def test_pinocchio_frees_mimic_joints_by_default_and_has_no_hessians_with_them(robot: Robot) -> None:
    assert pin.buildModelFromXML(robot.urdf).nq == 14
    model = pin.buildModelFromXML(robot.urdf, mimic=True)
    with pytest.raises(Exception, match=r"[Mm]imic"):
        pin.computeJointKinematicHessians(model, model.createData(), robot.initial)


def test_pinocchio_hands_numpy_a_column_major_hessian(robot: Robot, rng: np.random.Generator) -> None:
    model, data = robot.model, robot.model.createData()
    q, frame = robot.full_configuration(random_q(robot, rng)), robot.model.getFrameId("left_hand")
    pin.computeJointKinematicHessians(model, data, q)
    raw = pin.getFrameKinematicHessian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)

    def J(q: np.ndarray) -> np.ndarray:
        return pin.computeFrameJacobian(model, model.createData(), q, frame, pin.LOCAL_WORLD_ALIGNED)

    numeric = central_difference(J, q)
    assert abs(raw - numeric).max() > 0.1
    np.testing.assert_allclose(np.reshape(np.ravel(raw), raw.shape, order="F"), numeric, atol=1e-8)
