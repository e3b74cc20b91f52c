"""The check of certificates of motions with objects: its distances, its motions, and that it finds what is wrong."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from humanoid_rail import Box, Capsule, Certificate, Contact, InvalidInput, Mesh, Sphere, verify
from humanoid_rail._native import why_no_engine
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.scene.shapes import distance_between, placed_shapes
from validation import check_holding
from validation.check_holding import check_all, judge, look, main, summary
from validation.held_course import parts
from validation.held_geometry import body_of, distance
from validation.held_motions import KINDS, make_motion, mesh_file
from validation.plain_geometry import STEP
from validation.random_motions import robot

SEED = 2019
needs_native = pytest.mark.skipif(why_no_engine() is not None, reason="certificates take the native engine")


def shape(kind: str, rng: np.random.Generator) -> Obstacle:
    place = {"center": tuple(rng.normal(0.0, 0.6, 3).tolist())}
    turned = {**place, "rpy": tuple(rng.uniform(-3.0, 3.0, 3).tolist())}
    size = tuple(rng.uniform(0.05, 0.5, 3).tolist())
    match kind:
        case "sphere":
            return Sphere(**place, radius=size[0])
        case "capsule":
            return Capsule(**turned, radius=size[0], length=size[1])
        case "box":
            return Box(**turned, size=size)
    return Mesh(**turned, file=mesh_file(int(rng.integers(12))), scale=size)


@pytest.mark.parametrize("one", ["sphere", "capsule", "box", "mesh"])
@pytest.mark.parametrize("other", ["capsule", "box", "mesh"])
def test_plain_distances_are_those_of_coal_where_bodies_are_apart(
    one: str, other: str, rng: np.random.Generator
) -> None:
    apart = 0
    for _ in range(40):
        pair = [shape(one, rng), shape(other, rng)]
        bodies = []
        for each in pair:
            turned = Rotation.from_euler("xyz", getattr(each, "rpy", (0.0, 0.0, 0.0))).as_matrix()
            bodies.append(body_of(each, turned[None], np.array(each.center)[None]))  # type: ignore[union-attr]
        found = float(distance(*bodies)[0])
        expected = min(distance_between(a, b) for a in placed_shapes(pair[0]) for b in placed_shapes(pair[1]))
        if expected > 1e-4:
            apart += 1
            assert found == pytest.approx(expected, abs=2e-6)
        elif expected < -1e-4:
            assert found <= 0.0
    assert apart > 10


def test_courses_are_fine_and_events_are_between_parts() -> None:
    motion = make_motion(SEED, 1)
    found = list(parts(motion, 50))
    assert found[0].t[0] == motion.t[0]
    assert found[-1].t[-1] == motion.t[-1]
    assert {event.t for event in motion.events} <= {float(t) for part in found for t in part.t[[0, -1]]}
    for part in found:
        for body in part.bodies.values():
            if len(body.edges) > 1:
                assert np.linalg.norm(np.diff(body.edges, axis=0), axis=-1).max() <= 1.1 * STEP


@needs_native
def test_certificates_hold() -> None:
    outcomes = check_all(range(24), SEED, 100, jobs=1)
    assert [outcome.broken for outcome in outcomes] == 24 * [()]
    rows = {name: values for name, *values in summary(outcomes)}
    assert rows["motions"] == ["24", *len(KINDS) * ["6"]]
    assert min(int(rows["certified"][0]), int(rows["touching"][0]), int(rows["an object nearest"][0])) > 5


def bound_too_large(certificate: Certificate) -> Certificate:
    assert certificate.clearance_bound is not None
    return replace(certificate, clearance_bound=certificate.clearance_bound + 2e-3)


@needs_native
@pytest.mark.parametrize(
    ("certified", "spoil", "finding"),
    [
        (False, lambda c: replace(c, certified=True), "certified, but"),
        (False, lambda c: replace(c, contact=None), "no contact, but"),
        (False, lambda c: replace(c, contact=replace(c.contact, other="part 7")), "mm off"),
        (False, lambda c: replace(c, contact=replace(c.contact, point=(0.0, 0.0, 9.0))), "mm off"),
        (True, bound_too_large, "the bound is"),
        (True, lambda c: replace(c, certified=False), "not certified, but"),
        (True, lambda c: replace(c, contact=Contact(0.0, "carriage", "part 0", (0.0, 0.0, 0.0))), "mm off"),
        (True, lambda c: replace(c, unchecked_pairs=()), "which the certificate does not say"),
    ],
)
def test_a_wrong_certificate_is_found(
    certified: bool, spoil: Callable[[Certificate], Certificate], finding: str
) -> None:
    for index in range(40):
        motion = make_motion(SEED, index)
        certificate = verify(robot(), motion.scene(), motion)
        looked = look(motion, 20)
        deep = min(one.least for one in looked)
        if certificate.certified == certified and abs(deep) > 2e-3:
            break
    assert judge(looked, certificate) == ()
    assert finding in "; ".join(judge(looked, spoil(certificate)))


@needs_native
@pytest.mark.parametrize("wrong", [False, True])
def test_the_exit_code_says_whether_all_hold(
    wrong: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if wrong:
        monkeypatch.setattr(
            check_holding, "verify", lambda *motion: replace(verify(*motion), clearance_bound=0.9, certified=True)
        )
    file = tmp_path / "new" / "check.json"
    options = ["--first", "3", "--motions", "1", "--jobs", "1", "--finer", "20", "--json", str(file)]
    assert main.main(options, standalone_mode=False) == int(wrong)
    out, report = capsys.readouterr().out, json.loads(file.read_text())
    assert f"hold of {1 - wrong} motions out of 1" in out
    assert [found["index"] for found in report["broken"]] == ([3] if wrong else [])


@pytest.mark.parametrize(
    "options", [["--motions", "0"], ["--first", "-1"], ["--seed", "-1"], ["--jobs", "0"], ["--finer", "0"]]
)
def test_bad_options_are_refused(options: list[str]) -> None:
    with pytest.raises(InvalidInput, match=options[0][2:]):
        main.main(options, standalone_mode=False)
