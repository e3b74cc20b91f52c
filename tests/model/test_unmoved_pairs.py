"""Bodies and obstacles neither of which ever moves: no motion is held up by them, and certificates name them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from arms import long_arm

from humanoid_rail import Box, Follower, HalfSpace, Kinematics, Robot, Scene, Sphere, load_robot, plan, verify
from humanoid_rail.cli.report import report_certificate
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.model.pairs import UncheckedPair

PEDESTAL = '<collision><origin xyz="0 0 -0.2"/><geometry><box size="0.1 0.1 0.2"/></geometry></collision>'
"""It stands on z = -0.3 m."""


@pytest.fixture(scope="module")
def standing() -> Robot:
    return load_robot(long_arm(links={"base": PEDESTAL}), hands={"hand": "l5"})


def floor(height: float, **more: object) -> HalfSpace:
    return HalfSpace(normal=(0.0, 0.0, 1.0), offset=height, **more)


def still(robot: Robot) -> SimpleNamespace:
    q = np.array([robot.initial, robot.initial])
    q[1, 0] += 0.1
    return SimpleNamespace(t=np.array([0.0, 1.0]), q=q)


@pytest.mark.parametrize(
    ("height", "said"),
    [(-0.3, "they touch"), (-0.296, "they touch by 0.004 m"), (-0.305, "they are 0.005 m apart")],
)
def test_a_robot_that_stands_on_a_floor_plans_and_the_certificate_says_so(
    standing: Robot, height: float, said: str
) -> None:
    q = standing.initial.copy()
    q[0] += 0.4
    target = Kinematics(standing).hand_positions(q)[0]
    scene = Scene(name="floor", targets={"hand": tuple(target)}, obstacles=(floor(height),))
    trajectory = plan(standing, scene)
    assert trajectory.status == "reached"
    certificate = trajectory.certificate
    assert certificate is not None
    assert certificate.certified
    assert "safety distance" not in trajectory.reason
    [pair] = [pair for pair in certificate.unchecked_pairs if "obstacles" in pair.other]
    assert (pair.link, pair.other) == ("base", "obstacles[0] (halfspace)")
    assert pair.why == f"neither moves; {said}"
    # What moves is proven to stay away from the floor.
    assert certificate.clearance_bound is not None
    assert 0.009 < certificate.clearance_bound < 0.3 + 0.02
    assert certificate.min_clearance_obstacles is not None
    assert certificate.min_clearance_obstacles > 0.2


def test_what_never_moves_and_is_far_away_is_not_named(standing: Robot) -> None:
    scene = Scene(name="far", targets={"hand": (0, 0, 0)}, obstacles=(floor(-1.0),))
    certificate = verify(standing, scene, still(standing))
    assert certificate.unchecked_pairs == standing.unchecked_pairs


def test_obstacles_that_move_are_checked_against_all(standing: Robot) -> None:
    rising = floor(-0.4, velocity=(0.0, 0.0, 0.2))
    certificate = verify(standing, Scene(name="up", targets={"hand": (0, 0, 0)}, obstacles=(rising,)), still(standing))
    assert not certificate.certified
    assert certificate.contact is not None
    assert certificate.contact.link == "base"
    assert certificate.contact.t == pytest.approx(0.5, abs=0.01)


def test_a_body_deep_in_an_obstacle_is_warned_of_and_named(standing: Robot, capsys: pytest.CaptureFixture[str]) -> None:
    box_there = Box(center=(0.0, 0.0, -0.3), size=(0.2, 0.2, 0.1))
    scene = Scene(name="in", targets={"hand": (1.1, 0.1, 0.0)}, obstacles=(box_there,))
    with pytest.warns(UserWarning, match=r"base is 0\.05 m inside obstacles\[0\] \(box\), and neither moves"):
        plan(standing, scene)
    with pytest.warns(UserWarning, match=r"base is 0\.05 m inside") as warned:
        Follower(standing, scene, acceleration_limit=2.0)
    assert warned[0].filename == __file__
    with pytest.warns(UserWarning, match=r"base is 0\.05 m inside obstacles\[0\] \(box\), and neither moves"):
        certificate = verify(standing, scene, still(standing))
    # However many pairs are left out, the command names this one.
    left_out = tuple(UncheckedPair(f"a{i}", f"b{i}", "disabled by the SRDF") for i in range(40))
    more = replace(certificate, unchecked_pairs=(*left_out, *certificate.unchecked_pairs))
    report_certificate("s", more, np.array([0.0, 1.0]))
    said = " ".join(capsys.readouterr().out.split())
    assert "fixed, left out │ base and obstacles[0] (box): they touch by 0.05 m" in said
    assert "a39" not in said


def test_links_that_are_locked_do_not_move_either() -> None:
    urdf = long_arm(links={"base": PEDESTAL})
    robot = load_robot(urdf, hands={"hand": "l5"}, locked={"j0": 0.3})
    moving = dict(zip(robot.link_names, robot.moving_bodies, strict=True))
    assert moving == {"base": False, "l0": False, **{f"l{i}": True for i in range(1, 6)}}


def test_the_engine_leaves_out_the_same_pairs_as_the_reference(standing: Robot, rng: np.random.Generator) -> None:
    obstacles = (
        floor(-0.3),
        Sphere(center=(0.5, 0.4, 0.0), radius=0.1),
        Sphere(center=(0.2, 0.5, 0.0), radius=0.1, velocity=(0.0, -0.1, 0.0)),
    )
    reference, native = Kinematics(standing, obstacles), NativeKinematics(standing, obstacles)
    for _ in range(5):
        q = rng.uniform(standing.lower, standing.upper)
        one, other = reference.state(q, 0.5), native.state(q, 0.5)
        base = standing.link_names.index("base")
        assert np.isinf(one.clearance[base]).tolist() == [True, True, False]
        np.testing.assert_allclose(other.clearance, one.clearance, atol=1e-9)
        np.testing.assert_allclose(other.clearance_gradient, one.clearance_gradient, atol=1e-6)
        np.testing.assert_allclose(native.measure(q, t=0.5).clearance, reference.measure(q, t=0.5).clearance, atol=1e-9)


def test_a_robot_whose_moving_links_have_no_bodies_has_nothing_to_touch() -> None:
    robot = load_robot(long_arm(links={"base": PEDESTAL, **{f"l{i}": "" for i in range(6)}}), hands={"hand": "l5"})
    near = (floor(-0.3),)
    assert NativeKinematics(robot, near).measure(robot.initial).clearance.tolist() == [[np.inf]]
    certificate = verify(robot, Scene(name="s", targets={"hand": (0, 0, 0)}, obstacles=near), still(robot))
    assert certificate.certified
    assert certificate.clearance_bound is None
    assert [pair.why for pair in certificate.unchecked_pairs] == ["neither moves; they touch"]
