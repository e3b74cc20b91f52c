"""The certificate: what it says is true, and it says enough."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from conftest import changed, plan, random_q, random_scene
from hypothesis import given, settings
from hypothesis import strategies as st

from humanoid_rail import (
    Box,
    HalfSpace,
    InvalidInput,
    Kinematics,
    Mesh,
    Robot,
    Scene,
    Sphere,
    load_robot,
    plan_case,
    read_trajectory,
    retime,
    verify,
    write_trajectory,
)
from humanoid_rail.model.beyond_limits import robot_of_motion

TARGETS = {"left": (-1.6, 0.6, 3.4), "right": (-1.6, 2.2, 3.4)}


class Motion(NamedTuple):
    t: np.ndarray
    q: np.ndarray


def scene_of(*obstacles: object) -> Scene:
    return Scene(name="some", targets=TARGETS, obstacles=obstacles)


def densely(robot: Robot, scene: Scene, motion: Motion, finer: int = 100) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return fine times and the least clearances there, from obstacles and of links."""
    kinematics = Kinematics(robot, scene.obstacles)
    u = np.linspace(0, len(motion.t) - 1, finer * (len(motion.t) - 1) + 1)
    t = np.interp(u, np.arange(len(motion.t)), motion.t)
    q = np.array([np.interp(t, motion.t, column) for column in motion.q.T]).T
    measured = [kinematics.measure(row, t=time) for row, time in zip(q, t, strict=True)]
    outer = np.array([m.clearance.min(initial=np.inf) for m in measured])
    return t, outer, np.array([m.self_clearance.min(initial=np.inf) for m in measured])


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), speed=st.sampled_from([0.0, 0.5]))
def test_the_bound_holds_and_is_tight(seed: int, speed: float) -> None:
    """Of any motion, with steps far longer than a planner's."""
    robot, rng = load_robot(), np.random.default_rng(seed)
    scene = random_scene(rng, speed)
    start = random_q(robot, rng)
    steps = rng.normal(size=(8, robot.n)) * rng.choice([0.02, 0.1, 0.4])
    motion = Motion(np.cumsum(rng.uniform(0.01, 0.2, 9)), start + np.vstack([np.zeros(robot.n), np.cumsum(steps, 0)]))
    certificate = verify(robot, scene, motion)
    # Most of these motions leave the limits: then neighbours are checked away from their joint too.
    checked = robot_of_motion(robot, motion.t, motion.q, None)
    t, outer, inner = densely(checked, scene, motion)
    fine = min(outer.min(), inner.min())
    assert certificate.clearance_bound is not None
    assert certificate.clearance_bound <= fine + 1e-9
    if certificate.certified:
        assert fine > 0
        assert certificate.contact is None
        assert certificate.clearance_bound > 0
        found = min(certificate.min_clearance_obstacles, certificate.min_clearance_self)
        assert certificate.clearance_bound >= found - 1.1e-3
        # What was looked at includes all samples.
        at_samples = min(outer[::100].min(), inner[::100].min())
        assert found <= at_samples + 1e-9
        assert found >= fine - 1e-3
    else:
        assert fine < 1e-3
        first = t[(np.minimum(outer, inner) < 0)]
        assert certificate.contact is not None
        if len(first):
            assert certificate.contact.t <= first[0] + 1e-9
            earlier = t < certificate.contact.t - 1e-9
            assert (np.minimum(outer, inner)[earlier] > -1e-9).all()


def test_contact_between_samples_is_found(robot: Robot) -> None:
    """A motion through a thin board whose samples are all free."""
    board = Box(center=(-1.0, 3.0, 3.0), size=(4.0, 0.005, 4.0))
    q = np.tile(robot.initial, (2, 1))
    q[1, 0] += 5.5
    clear = Kinematics(robot, (board,)).along(q).clearance
    assert (clear > 0.05).all()
    certificate = verify(robot, scene_of(board), Motion(np.array([0.0, 10.0]), q))
    assert not certificate.certified
    # The right hand, at y = 2.232, goes first: its ball of 5 cm touches the board at 2.9975.
    assert certificate.contact.link == "right_forearm"
    assert certificate.contact.other == "obstacles[0] (box)"
    assert certificate.contact.t == pytest.approx(10.0 * (3.0 - 0.0025 - 0.05 - 2.2320508) / 5.5, abs=1e-5)
    assert certificate.contact.point[1] == pytest.approx(2.9975, abs=1e-4)
    assert certificate.clearance_bound < 0


@pytest.mark.parametrize("gap", [-0.001, -1e-5, 1e-5, 0.001, 0.1])
def test_near_misses(robot: Robot, gap: float) -> None:
    """A long slide past a wall, so near that only a close look tells."""
    q = np.linspace(robot.initial, robot.initial + np.eye(12)[0] * 3.0, 4)
    psi = Kinematics(robot, (HalfSpace(normal=(1.0, 0.0, 0.0), offset=0.0),)).along(q).clearance
    wall = HalfSpace(normal=(1.0, 0.0, 0.0), offset=float(psi.min()) - gap)
    certificate = verify(robot, scene_of(wall), Motion(np.arange(4.0), q))
    assert certificate.certified == (gap > 0)
    assert certificate.min_clearance_obstacles == pytest.approx(gap, abs=1e-9)
    if gap > 0:
        assert 0 < certificate.clearance_bound <= gap


def test_the_swing_of_an_arm_is_bounded_closely(robot: Robot) -> None:
    """Turning past a ball: the samples are nearly free, the arc between them bulges."""
    q = np.tile(robot.initial, (2, 1))
    q[0, 1], q[1, 1] = -0.5, 0.5
    kinematics = Kinematics(robot)
    tip = kinematics.hand_positions(np.mean(q, axis=0))[1]
    for gap in (-0.002, 0.002):
        ball = Sphere(center=tuple(tip + np.array([0.0, 0.05 + 0.1 + gap, 0.0])), radius=0.1)
        certificate = verify(robot, scene_of(ball), Motion(np.array([0.0, 1.0]), q))
        assert certificate.certified == (gap > 0)
        assert certificate.min_clearance_obstacles == pytest.approx(gap, abs=2e-3)


def test_links_that_fold_into_each_other(robot: Robot, folded_q: np.ndarray) -> None:
    """The SRDF's pairs are left out, and no others."""
    motion = Motion(np.linspace(0.0, 1.0, 20), np.linspace(robot.initial, folded_q, 20))
    certificate = verify(robot, scene_of(), motion)
    assert not certificate.certified
    assert certificate.min_clearance_obstacles is None
    assert certificate.min_clearance_self < -0.02
    assert {certificate.contact.link, certificate.contact.other} <= set(robot.link_names)
    alone = verify(replace(robot, self_collision_pairs=()), scene_of(), motion)
    assert alone.certified
    assert alone.clearance_bound is None
    assert alone.min_clearance_self is None


def test_moving_obstacles(robot: Robot) -> None:
    """A ball that flies into the resting robot: when is known in closed form."""
    hand = Kinematics(robot).hand_positions(robot.initial)[1]
    ball = Sphere(center=tuple(hand + np.array([0.0, 2.0, 0.0])), radius=0.1, velocity=(0.0, -0.8, 0.0))
    t = np.array([0.0, 1.0, 2.0, 3.0])
    certificate = verify(robot, scene_of(ball), Motion(t, np.tile(robot.initial, (4, 1))))
    assert certificate.contact.t == pytest.approx((2.0 - 0.1 - 0.05) / 0.8, abs=1e-5)
    assert certificate.contact.link == "right_forearm"
    away = ball.model_copy(update={"velocity": (0.0, 0.8, 0.0)})
    certificate = verify(robot, scene_of(away), Motion(t, np.tile(robot.initial, (4, 1))))
    assert certificate.certified
    assert certificate.min_clearance_obstacles == pytest.approx(1.85, abs=1e-6)


def test_meshes_are_looked_at_piece_by_piece(robot: Robot, cube_file: str) -> None:
    hand = Kinematics(robot).hand_positions(robot.initial)[1]
    q = np.linspace(robot.initial, robot.initial + np.eye(12)[0] * 1.5, 5)
    for height, free in ((-0.26, True), (-0.24, False)):
        center = tuple(hand + np.array([0.0, 1.2, height]))
        mesh = Mesh(file=cube_file, center=center, scale=0.4)
        certificate = verify(robot, scene_of(mesh), Motion(np.arange(5.0), q))
        assert certificate.certified == free


def test_what_was_written_is_verified_again(
    robot: Robot, scene: Scene, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("out")
    trajectory = plan_case(robot, 3, dt=0.05)
    write_trajectory(trajectory, folder)
    read = read_trajectory(folder)
    assert read.certificate == trajectory.certificate
    assert verify(robot, scene, read) == trajectory.certificate
    assert verify(robot, scene, Motion(read.t, read.q)) == trajectory.certificate


def test_case_1_hits_the_spheres_first_where_it_does(robot: Robot, scene: Scene) -> None:
    trajectory = plan_case(robot, 1)
    assert not trajectory.certified
    contact = trajectory.certificate.contact
    first = trajectory.t[(trajectory.clearance < 0).any(axis=1)][0]
    assert first - 0.01 <= contact.t <= first
    at = trajectory.configuration(contact.t)
    assert Kinematics(robot, scene.obstacles).measure(at).clearance.min() == pytest.approx(0.0, abs=1e-5)
    assert trajectory.min_clearance_obstacles == pytest.approx(trajectory.min_clearance, abs=1e-3)


@pytest.mark.parametrize(
    ("t", "q", "field"),
    [
        (np.array([0.0, 1.0]), np.zeros((2, 11)), "trajectory.q"),
        (np.array([0.0]), np.zeros((2, 12)), "trajectory.t"),
        (np.array([0.0, 0.0]), np.zeros((2, 12)), r"trajectory.t\[1\]"),
        (np.array([0.0, np.nan]), np.zeros((2, 12)), "trajectory.t"),
        (np.array([0.0, 1.0]), np.full((2, 12), np.inf), "trajectory.q"),
        (np.zeros(0), np.zeros((0, 12)), "trajectory.q"),
    ],
)
def test_motions_that_are_none(robot: Robot, scene: Scene, t: np.ndarray, q: np.ndarray, field: str) -> None:
    with pytest.raises(InvalidInput, match=field):
        verify(robot, scene, Motion(t, q))


def test_a_trajectory_of_another_robot(robot: Robot, scene: Scene) -> None:
    trajectory = plan_case(robot, 3, dt=0.5)
    backwards = changed(trajectory, joint_names=tuple(reversed(trajectory.joint_names)))
    with pytest.raises(InvalidInput, match="joint_names"):
        verify(robot, scene, backwards)


def test_a_motion_of_one_sample(robot: Robot, scene: Scene) -> None:
    certificate = verify(robot, scene, Motion(np.array([0.0]), robot.initial[None, :]))
    assert certificate.certified
    measured = Kinematics(robot, scene.obstacles).measure(robot.initial)
    assert certificate.min_clearance_obstacles == pytest.approx(measured.clearance.min())
    assert certificate.min_clearance_self == pytest.approx(measured.self_clearance.min())


def test_a_certificate_is_true_where_it_is_certified(robot: Robot, scene: Scene) -> None:
    assert plan_case(robot, 3, dt=0.1).certificate
    assert not plan_case(robot, 1, dt=0.1).certificate


@pytest.mark.parametrize("motion", [(np.zeros(1), np.zeros((1, 12))), None, "out", Motion(["a"], [["b"]])])
def test_what_is_no_motion_is_named(robot: Robot, scene: Scene, motion: object) -> None:
    with pytest.raises(InvalidInput, match="trajectory is"):
        verify(robot, scene, motion)
    with pytest.raises(InvalidInput, match="scene is"):
        verify(robot, "scene.yaml", Motion(np.zeros(1), np.zeros((1, 12))))


def test_nothing_is_bounded_where_all_pairs_have_distances_of_their_own(robot: Robot, tmp_path: Path) -> None:
    pairs = robot.self_collision_pairs
    own = replace(robot, pair_distances=dict.fromkeys(pairs, 0.001))
    free = scene_of()
    found = plan(own, free)
    proof = found.certificate
    assert proof is not None
    assert proof.certified
    assert proof.clearance_bound > 0.0
    assert (proof.others_bound, proof.kept_bound, proof.only_own_distances) == (None, None, True)
    assert "could not be kept" not in found.reason
    write_trajectory(found, tmp_path)
    assert "Infinity" not in (tmp_path / "summary.json").read_text(encoding="utf-8")
    assert read_trajectory(tmp_path).certificate == proof
    timed = retime(found, own, free)
    assert timed.certified
    assert timed.certificate.kept_bound is None
    # Where one keeps the safety distance, or there is an obstacle, or something touches, there is a bound.
    one = replace(robot, pair_distances=dict.fromkeys(pairs[1:], 0.001))
    bounded = verify(one, free, found)
    assert bounded.kept_bound == bounded.others_bound >= proof.clearance_bound
    ahead = verify(own, scene_of(Sphere(center=(30.0, 0.0, 0.0), radius=0.1)), found)
    assert ahead.kept_bound == ahead.others_bound > 10.0
    rng = np.random.default_rng(3)
    while Kinematics(own).measure(q := rng.uniform(own.lower, own.upper)).self_clearance.min() > -0.02:
        pass
    touching = verify(own, free, Motion(np.array([0.0, 1.0]), np.array([q, q])))
    assert not touching.certified
    assert touching.kept_bound == touching.clearance_bound < 0.0
