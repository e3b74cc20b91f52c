"""The check of certificates: its distances by brute force, its motions, and that it finds what is wrong."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import random_q
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from humanoid_rail import Box, Capsule, Certificate, Contact, HalfSpace, InvalidInput, Robot, Sphere, verify
from humanoid_rail._native import why_no_engine
from validation import check_certificates, plain_geometry, random_motions
from validation.check_certificates import check_all, clearances, judge, main, summary
from validation.plain_geometry import RADIUS, STEP, clearance, follow, point_segment, segment_box, segment_segment
from validation.random_motions import KINDS, MISS, Motion, make_motion, scene_of

SEED = 2019
# On a grid segments are often parallel, of no length or in the planes of a box's faces.
coordinate = st.one_of(st.integers(-3, 3).map(float), st.floats(-3.0, 3.0, allow_subnormal=False))
NOWHERE = Contact(0.0, "carriage", "left_forearm", (0.0, 0.0, 0.0))
segments = st.lists(coordinate, min_size=6, max_size=6).map(lambda x: np.array(x).reshape(2, 3))

needs_native = pytest.mark.skipif(why_no_engine() is not None, reason="so many motions take the native engine")


def points(segment: np.ndarray, count: int = 401) -> np.ndarray:
    """Return points (count, 3) along a segment (2, 3)."""
    return segment[0] + np.linspace(0.0, 1.0, count)[:, None] * (segment[1] - segment[0])


def spacing(segment: np.ndarray, count: int = 401) -> float:
    return float(np.linalg.norm(segment[1] - segment[0])) / (count - 1)


@settings(deadline=None)  # a busy machine fails no test
@given(segments, segments)
def test_segments_are_as_far_apart_as_their_points(one: np.ndarray, other: np.ndarray) -> None:
    brute = np.linalg.norm(points(one)[:, None] - points(other), axis=-1).min()
    found = segment_segment(one, other)
    assert found <= brute + 1e-7
    assert found >= brute - 0.5 * (spacing(one) + spacing(other)) - 1e-9
    assert segment_segment(other, one) == pytest.approx(found, abs=1e-7)


@settings(deadline=None)  # a busy machine fails no test
@given(segments, st.lists(coordinate, min_size=3, max_size=3).map(np.array))
def test_points_are_as_far_from_segments_as_from_their_points(segment: np.ndarray, point: np.ndarray) -> None:
    brute = np.linalg.norm(points(segment) - point, axis=-1).min()
    assert brute - 0.5 * spacing(segment) - 1e-9 <= point_segment(point, segment) <= brute + 1e-9


@settings(deadline=None)  # a busy machine fails no test
@given(segments, st.lists(st.sampled_from([0.01, 0.3, 1.0, 2.0]), min_size=3, max_size=3).map(np.array))
def test_boxes_are_as_far_from_segments_as_from_their_points(segment: np.ndarray, half: np.ndarray) -> None:
    along = points(segment)
    brute = np.linalg.norm(along - np.clip(along, -half, half), axis=-1).min()
    assert brute - 0.5 * spacing(segment) - 1e-9 <= segment_box(segment, half) <= brute + 1e-9


def test_many_at_once_are_as_one_by_one(rng: np.random.Generator) -> None:
    one, other = rng.normal(size=(2, 4, 5, 2, 3))
    half = np.array([0.2, 0.5, 1.0])
    for i, j in np.ndindex(4, 5):
        assert segment_segment(one, other)[i, j] == pytest.approx(segment_segment(one[i, j], other[i, j]), abs=1e-14)
        assert segment_box(one, half)[i, j] == pytest.approx(segment_box(one[i, j], half), abs=1e-14)


def test_turns_are_those_of_urdf(rng: np.random.Generator) -> None:
    for rpy in rng.uniform(-np.pi, np.pi, (20, 3)):
        np.testing.assert_allclose(plain_geometry.rotation(tuple(rpy)), Rotation.from_euler("xyz", rpy).as_matrix())


def test_clearances_from_obstacles_that_move(rng: np.random.Generator) -> None:
    for _ in range(20):
        center, rpy, velocity = (tuple(rng.normal(size=3).tolist()) for _ in range(3))
        turned, t, segment = Rotation.from_euler("xyz", rpy), float(rng.uniform(0.0, 3.0)), rng.normal(size=(2, 3))
        at, along = np.add(center, np.multiply(t, velocity)), points(segment)
        local = turned.inv().apply(along - at)
        half = np.array([0.3, 0.05, 0.6])
        axis = points(at + turned.apply([[0.0, 0.0, -0.4], [0.0, 0.0, 0.4]]))
        expected = {
            Sphere(center=center, radius=0.2, velocity=velocity): np.linalg.norm(along - at, axis=-1).min() - 0.2,
            Box(center=center, size=tuple(2 * half), rpy=rpy, velocity=velocity): np.linalg.norm(
                local - np.clip(local, -half, half), axis=-1
            ).min(),
            Capsule(center=center, radius=0.1, length=0.8, rpy=rpy, velocity=velocity): np.linalg.norm(
                along[:, None] - axis, axis=-1
            ).min()
            - 0.1,
            HalfSpace(normal=rpy, offset=0.3, velocity=velocity): ((along - np.multiply(t, velocity)) @ rpy - 0.3).min()
            / np.linalg.norm(rpy),
        }
        for obstacle, distance in expected.items():
            error = 0.5 * spacing(segment) + 0.001
            assert clearance(obstacle, t, segment) == pytest.approx(distance - RADIUS, abs=error), obstacle


def test_the_bones_and_their_pairs_are_the_robot_s(robot: Robot) -> None:
    assert robot.link_names == plain_geometry.LINKS
    assert robot.self_collision_pairs == plain_geometry.PAIRS


def test_only_what_does_not_matter_is_a_lower_bound(robot: Robot, rng: np.random.Generator) -> None:
    for near in (-np.inf, 1e-3, 0.3):
        q = random_q(robot, rng) + np.cumsum(rng.normal(0.0, 0.05, (6, 12)), axis=0)
        course = follow(np.arange(6.0), q, 100, 0.5)
        place = course.bones[50, 4].mean(axis=0) + 0.4
        obstacles = [
            Sphere(center=tuple(place), radius=0.1, velocity=(0.0, 0.3, -0.4)),
            Box(center=tuple(place), size=(0.1, 0.3, 0.2), rpy=(0.1, 0.2, 0.3)),
        ]
        one, other = np.array(plain_geometry.PAIRS).T
        exact = [clearance(obstacle, course.t[:, None], course.bones) for obstacle in obstacles]
        exact.append(segment_segment(course.bones[:, one], course.bones[:, other]) - 2 * RADIUS)
        found = [course.from_obstacle(obstacle, near) for obstacle in obstacles] + [course.between_links(near)]
        for all_of_them, those in zip(exact, found, strict=True):
            assert (those <= all_of_them + 1e-12).all()
            assert those.min() == pytest.approx(all_of_them.min(), abs=1e-12)
            np.testing.assert_allclose(those[all_of_them < near], all_of_them[all_of_them < near], atol=1e-12)
            assert (those < all_of_them - 1e-9).any(), "everything was measured"


def test_courses_are_linear_and_as_fine_as_they_should_be(robot: Robot, rng: np.random.Generator) -> None:
    t, q = np.array([0.0, 0.5, 2.0]), random_q(robot, rng) + np.array([[0.0], [1e-4], [1.0]])
    course = follow(t, q, 100)
    first = (course.t < 0.5).sum()
    assert first == 100
    assert (len(course.t) - 1 - first) % 100 == 0
    assert set(t) <= set(course.t)
    assert np.linalg.norm(np.diff(course.bones, axis=0), axis=-1).max() <= 1.01 * STEP
    between = plain_geometry.configuration(t, q, 0.75)
    np.testing.assert_allclose(between, q[1] + (q[2] - q[1]) / 6, atol=1e-12)
    assert len(follow(t[:1], q[:1], 100).t) == 1


@pytest.fixture(scope="module")
def motions() -> list[Motion]:
    if why_no_engine() is not None:
        pytest.skip("so many motions take the native engine")
    return [make_motion(SEED, index) for index in range(36)]


@needs_native
def test_certificates_hold() -> None:
    outcomes = check_all(range(36), SEED, 100, jobs=1)
    assert [outcome.broken for outcome in outcomes] == 36 * [()]
    assert [outcome.index for outcome in outcomes] == list(range(36))
    # Of each there are enough for the check to mean something.
    rows = {name: values for name, *values in summary(outcomes)}
    assert rows["motions"] == ["36", "9", "9", "9", "9"]
    assert rows["wrong"] == 5 * ["0"]
    assert min(int(rows["certified"][0]), int(rows["touching"][0])) > 8
    assert int(rows["free by up to 1 mm"][0]) > 0
    for outcome in outcomes:
        assert outcome.bound <= outcome.clearance + 1e-6


@needs_native
def test_the_processes_do_not_matter() -> None:
    assert check_all(range(20, 28), SEED, 20, jobs=2) == check_all(range(20, 28), SEED, 20, jobs=1)


def test_motions_are_a_mixture_and_depend_on_their_number_alone(motions: list[Motion]) -> None:
    assert [motion.kind for motion in motions] == 9 * list(KINDS)
    again = make_motion(SEED, 7)
    np.testing.assert_array_equal(again.q, motions[7].q)
    assert again.obstacles == motions[7].obstacles
    obstacles = [obstacle for motion in motions for obstacle in motion.obstacles]
    assert {obstacle.type for obstacle in obstacles} == {"sphere", "box", "capsule", "halfspace"}
    assert 0.1 < np.mean([any(obstacle.velocity) for obstacle in obstacles]) < 0.5
    assert max(len(motion.t) for motion in motions) <= 152


def test_near_misses_are_near(motions: list[Motion]) -> None:
    for motion in motions:
        if motion.kind == random_motions.NEAR:
            least = clearances(motion.follow(100), motion.obstacles).min()
            assert 0.5 * MISS[0] < abs(least) < 1.1 * MISS[1]


def of_contact(**fields: Any) -> Callable[[Certificate], Certificate]:
    """Return what changes fields of a certificate's contact."""

    def spoil(certificate: Certificate) -> Certificate:
        assert certificate.contact is not None
        return replace(certificate, contact=replace(certificate.contact, **fields))

    return spoil


def bound_too_large(certificate: Certificate) -> Certificate:
    assert certificate.clearance_bound is not None
    return replace(certificate, clearance_bound=certificate.clearance_bound + 2e-3)


def findings(robot: Robot, reach: float, spoil: Callable[[Certificate], Certificate]) -> str:
    """Return what is found of a spoiled certificate; the carriage moves for 1 s by `reach` (m) towards two spheres."""
    start = np.array(robot.initial)
    hand = plain_geometry.bones(start)[plain_geometry.LINKS.index("left_forearm"), 1]
    spheres = tuple(Sphere(center=(hand[0], hand[1] - away, hand[2]), radius=0.1) for away in (1.0, 1.2))
    q = start + np.outer([0.0, -reach], np.eye(12)[0])
    motion = Motion(random_motions.ELSEWHERE, np.array([0.0, 1.0]), q, spheres)
    certificate = verify(robot, scene_of(motion.obstacles), motion)
    course = motion.follow(100)
    apart = clearances(course, motion.obstacles)
    assert certificate.certified == (reach < 0.85)
    assert judge(motion, course, apart, certificate) == ()
    return "; ".join(judge(motion, course, apart, spoil(certificate)))


@pytest.mark.parametrize(
    ("spoil", "finding"),
    [
        pytest.param(lambda c: replace(c, certified=True), "certified, but", id="called certified"),
        pytest.param(lambda c: replace(c, certified=True, contact=None), "certified, but", id="certified, no contact"),
        pytest.param(bound_too_large, "the bound is", id="bound too large"),
        pytest.param(lambda c: replace(c, clearance_bound=None), "the bound is", id="no bound"),
        pytest.param(lambda c: replace(c, contact=None), "no contact, but", id="no contact"),
        pytest.param(of_contact(t=0.5), "mm off", id="contact too early"),
        pytest.param(of_contact(t=0.9), "but before there are", id="contact too late"),
        pytest.param(of_contact(link="left_clavicle"), "mm off", id="of another link"),
        pytest.param(of_contact(other="obstacles[1] (sphere)"), "mm off", id="with another obstacle"),
        pytest.param(of_contact(point=(0.0, 0.0, 9.0)), "mm off", id="elsewhere"),
    ],
)
def test_a_wrong_certificate_of_contact_is_found(
    robot: Robot, spoil: Callable[[Certificate], Certificate], finding: str
) -> None:
    assert finding in findings(robot, 1.2, spoil)


@pytest.mark.parametrize(
    ("spoil", "finding"),
    [
        pytest.param(lambda c: replace(c, certified=False), "not certified, but", id="not called certified"),
        pytest.param(bound_too_large, "the bound is", id="bound too large"),
        pytest.param(lambda c: replace(c, clearance_bound=None), "the bound is", id="no bound"),
        pytest.param(lambda c: replace(c, contact=NOWHERE), "mm off", id="a contact"),
    ],
)
def test_a_wrong_certificate_of_none_is_found(
    robot: Robot, spoil: Callable[[Certificate], Certificate], finding: str
) -> None:
    assert finding in findings(robot, 0.2, spoil)


@pytest.mark.parametrize("wrong", [False, True])
def test_the_exit_code_says_whether_all_hold(
    wrong: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if wrong:
        monkeypatch.setattr(
            check_certificates, "verify", lambda *motion: replace(verify(*motion), clearance_bound=0.5, certified=True)
        )
    file = tmp_path / "new" / "check.json"
    options = ["--first", "10", "--scenes", "1", "--jobs", "1", "--finer", "20", "--json", str(file)]
    assert main.main(options, standalone_mode=False) == int(wrong)
    out, report = capsys.readouterr().out, json.loads(file.read_text())
    assert ("motion 10 (elsewhere): " in out) == wrong
    assert f"hold of {1 - wrong} motions out of 1" in out
    assert [found["index"] for found in report["broken"]] == ([10] if wrong else [])
    assert report["table"]["motions"]["elsewhere"] == "1"


@pytest.mark.parametrize(
    "options", [["--scenes", "0"], ["--first", "-1"], ["--seed", "-1"], ["--jobs", "0"], ["--finer", "0"]]
)
def test_bad_options_are_refused(options: list[str]) -> None:
    with pytest.raises(InvalidInput, match=options[0][2:]):
        main.main(options, standalone_mode=False)
