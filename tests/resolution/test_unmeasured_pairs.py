"""What is told of pairs that take long to measure without measuring them: bounds from boxes, and steps by these."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from conftest import points, random_q
from hulls import hulled

from humanoid_rail import Gains, NativeKinematics, Robot, Safety, load_robot
from humanoid_rail._native import engine
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.resolution.integrate import Settings
from humanoid_rail.resolution.native_velocity import constrained_velocity
from humanoid_rail.resolution.rollout import rollout

HORIZON = 0.5
DISTANCE = 0.01


@pytest.fixture(scope="module")
def of_hulls(robot: Robot) -> Robot:
    return hulled(robot)


@pytest.fixture(scope="module")
def thick() -> Robot:
    return hulled(load_robot(link_radius=0.15))


def test_bounds_from_boxes_hold(of_hulls: Robot, rng: np.random.Generator) -> None:
    """Of the distance, and of how fast it shrinks; and they say something."""
    boxes, at, h = engine().LinkBoxes(native_robot(of_hulls)), NativeKinematics(of_hulls), 1e-6
    pairs = len(of_hulls.self_collision_pairs)
    told, growing = 0, 0
    for _ in range(200):
        q = random_q(of_hulls, rng)
        velocity = of_hulls.velocity_limit * rng.uniform(-1.0, 1.0, of_hulls.n)
        number, distance, approach = map(np.array, zip(*boxes.bounds(q, velocity), strict=True))
        assert number.tolist() == list(range(pairs))
        before, now, after = (at.measure(q + s * velocity).self_clearance for s in (-h, 0.0, h))
        assert (distance <= now + 1e-9).all()
        # The distance may have a kink: both sides are held against the bound.
        shrinks = np.maximum(now - after, before - now) / h
        apart = now > 1e-3
        assert (shrinks[apart] <= approach[apart] + 1e-4).all()
        told += int((distance > 0.5 * now).sum())
        growing += int((approach < 0.0).sum())
    assert told > 100 * pairs
    assert growing > 5


def test_of_capsules_nothing_is_told(robot: Robot) -> None:
    """They are measured."""
    boxes = engine().LinkBoxes(native_robot(robot))
    assert boxes.bounds(robot.initial, np.zeros(robot.n)) == []


def test_steps_are_judged_as_by_measuring(thick: Robot, rng: np.random.Generator) -> None:
    """Safe: no pair is below the safety distance at the end, or nearer than it was; not blocked: nothing touches."""
    module = engine()
    judge, at = module.StepJudge(native_robot(thick), DISTANCE), NativeKinematics(thick)
    seen = dict.fromkeys((module.Step.SAFE, module.Step.FREE, module.Step.BLOCKED), 0)
    for _ in range(400):
        a, far = random_q(thick, rng), random_q(thick, rng)
        # Most steps begin where a pair is near.
        ways = [a + share * (far - a) for share in np.linspace(0.0, 1.0, 60)]
        least = np.array([at.measure(q).self_clearance.min() for q in ways])
        near = np.flatnonzero((least > 0.0) & (least < 4.0 * DISTANCE))
        a = ways[near[0]] if len(near) else a
        size = 10.0 ** rng.uniform(-3.5, -1.5)
        b = np.clip(a + size * rng.uniform(-1.0, 1.0, thick.n), thick.lower, thick.upper)
        step = judge.judge(a, b, HORIZON)
        seen[step] += 1
        along = np.array([at.measure(a + share * (b - a)).self_clearance for share in np.linspace(0.0, 1.0, 21)])
        keeps = bool((along[-1] >= np.minimum(DISTANCE, along[0]) - 1e-8).all())
        if step != module.Step.BLOCKED:
            assert along.min() > 0.0
            assert (step == module.Step.SAFE) == keeps
        else:  # it could not be proven, so something is nearer than the two could get: 12 joints, 4 m away at most
            assert along.min() < 2.0 * 12.0 * 4.0 * size
    assert min(seen.values()) > 20, seen


def test_a_step_is_halved_for_a_pair_that_was_not_measured(thick: Robot, rng: np.random.Generator) -> None:
    """Rows are linear: a step that may use up a distance at once goes too far, and only a shorter one keeps it."""
    dt, gains, safety = 0.1, Gains(c_mu=0.0, gain=2.0), Safety(safety_distance=DISTANCE, damper_gain=10.0)
    settings = Settings(tolerance=0.01, dt=dt, max_time=2.0, rtol=1e-6, atol=1e-6)
    at, halved = NativeKinematics(thick), 0
    for _ in range(25):
        q = random_q(thick, rng)
        if at.measure(q).self_clearance.min() < 2.0 * DISTANCE:
            continue
        targets = points(at.state(q).hands[::-1])  # each hand wants to be where the other one is
        found = rollout(NativeKinematics(thick), q, targets, gains, safety, settings)
        velocity = constrained_velocity(NativeKinematics(thick), targets, gains, safety, dt)
        for here, there in pairwise(found.q):
            kept = np.minimum(DISTANCE, at.measure(here).self_clearance)
            assert (at.measure(there).self_clearance >= kept - 1e-8).all()
            share = np.linalg.norm(there - here) / np.linalg.norm(dt * velocity(here))
            if share < 0.51:  # twice as much would have ended too near
                halved += int((at.measure(here + 2.0 * (there - here)).self_clearance < kept - 1e-6).any())
    assert halved > 3
