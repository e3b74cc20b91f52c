"""Motions along which objects are held keep their events and phases when they are retimed."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from humanoid_rail import NativeKinematics, Scene, Trajectory, load_robot, load_scene, plan, retime, verify
from humanoid_rail.holding.holding import hand_placement
from humanoid_rail.resampling import evaluate
from humanoid_rail.scene.objects import object_named, placed_at
from humanoid_rail.scene.shapes import distance_between, placed_shapes

pytestmark = pytest.mark.filterwarnings("ignore:no collision body")


@pytest.fixture(scope="module")
def kit() -> tuple[Scene, Trajectory]:
    scene = load_scene("scenes/kit.yaml")
    return scene, plan(load_robot("human-sized"), scene)


def test_the_kitting_round_is_reached_and_certified(kit: tuple[Scene, Trajectory]) -> None:
    scene, trajectory = kit
    assert trajectory.status == "reached", trajectory.reason
    assert trajectory.certified
    assert trajectory.limits_ok
    assert [event.kind for event in trajectory.events].count("grasp") == 4
    assert {event.object for event in trajectory.events if event.kind == "release"} == {"bottle", "box", "can", "pack"}
    assert trajectory.robot is not None
    assert verify(trajectory.robot, scene, trajectory).certified


@pytest.mark.parametrize("dwell", [0.0, 0.5])
def test_a_retimed_round_has_its_events_at_rest(kit: tuple[Scene, Trajectory], dwell: float) -> None:
    scene, trajectory = kit
    slower = retime(trajectory, speed=0.5, dwell=dwell)
    assert slower.status == "reached", slower.reason
    assert slower.certified
    assert slower.duration > 1.8 * trajectory.duration
    assert [(e.kind, e.object) for e in slower.events] == [(e.kind, e.object) for e in trajectory.events]
    robot = trajectory.robot
    assert robot is not None
    for before, after in zip(trajectory.events, slower.events, strict=True):
        q, velocity, _ = evaluate(slower.motion, np.array([after.t]))
        np.testing.assert_allclose(velocity, 0.0, atol=1e-9)
        there, _, _ = evaluate(trajectory.motion, np.array([before.t]))
        np.testing.assert_allclose(q, there, atol=1e-6)
    assert verify(robot, scene, slower).certified


def test_parts_are_where_they_are_put(kit: tuple[Scene, Trajectory]) -> None:
    """Each part moves with its hand from its grasp to its release, by Pinocchio."""
    _, trajectory = kit
    robot = trajectory.robot
    assert robot is not None
    for name in ("bottle", "box", "can", "pack"):
        grasp, release = (
            next(e for e in trajectory.events if e.object == name and e.kind == kind) for kind in ("grasp", "release")
        )
        first, last = (
            hand_placement(robot, grasp.hands[0], evaluate(trajectory.motion, np.array([t]))[0][0])
            for t in (grasp.t, release.t)
        )
        moved = last.act(first.inverse().act(np.array(grasp.position)))
        np.testing.assert_allclose(moved, release.position, atol=1e-6)


def test_new_samples_measure_what_is_held(kit: tuple[Scene, Trajectory]) -> None:
    """At samples that resampling adds, each obstacle is as near as the robot alone, or what it holds, by coal."""
    scene, trajectory = kit
    robot, looked, nearer = trajectory.robot, 0, 0
    assert robot is not None
    clear, later = (next(e for e in trajectory.events if e.kind == kind) for kind in ("clear", "release"))
    fine = trajectory.resample(0.0033)
    # Between the first retreat and the next approach nothing may touch.
    approach = [e for e in trajectory.events if e.kind == "approach" and e.t < later.t][-1]
    new = np.flatnonzero(~np.isin(fine.t, trajectory.t) & (fine.t > clear.t) & (fine.t < approach.t))[::9]
    bare = NativeKinematics(robot, scene.obstacles).along(fine.q[new], np.inf, fine.t[new]).clearance
    for row, k in enumerate(new):
        for name, hand in (("bottle", "left"), ("box", "right")):
            grasp = next(e for e in trajectory.events if e.kind == "grasp" and e.object == name)
            first = hand_placement(robot, hand, evaluate(trajectory.motion, np.array([grasp.t]))[0][0])
            held = first.inverse() * pin.SE3(np.eye(3), np.array(grasp.position))
            there = hand_placement(robot, hand, fine.q[k]) * held
            part = placed_at(object_named(scene.objects, name), there)
            for number, obstacle in enumerate(scene.obstacles):
                far = min(distance_between(a, b) for a in part for b in placed_shapes(obstacle))
                nearer += far < bare[row, number]
                bare[row, number] = min(bare[row, number], far)
        found = fine.clearance[k]
        near = np.isfinite(found)
        np.testing.assert_allclose(found[near], bare[row][near], atol=1e-6)
        looked += int(near.sum())
    assert looked > 50
    assert nearer > 20
