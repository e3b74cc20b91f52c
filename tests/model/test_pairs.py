"""What is checked of neighbours that an SRDF leaves out, against points on their bones; what certificates say."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from arms import arm, box, capsule

from humanoid_rail import (
    Kinematics,
    Robot,
    SafeVelocity,
    Scene,
    load_robot,
    plan,
    read_trajectory,
    verify,
    write_trajectory,
)

NOTHING = Scene(name="nothing", targets={"left": (0, 0, 0), "right": (0, 0, 0)})
ELBOW = 7
"""The column of the left elbow."""


def certificate_at(robot: Robot, elbow: float) -> object:
    """Return the certificate of the paper's robot at rest, but for the rail, with its left elbow bent."""
    q = np.array([robot.initial, robot.initial])
    q[:, ELBOW], q[1, 0] = elbow, 0.1
    return verify(robot, NOTHING, SimpleNamespace(t=np.array([0.0, 1.0]), q=q))


def test_within_the_nominal_limits_no_neighbours_meet_away_from_their_joint(robot: Robot) -> None:
    assert robot.collision_model.ngeoms == 9
    why = {frozenset((pair.link, pair.other)): pair.why for pair in robot.unchecked_pairs}
    assert len(why) == 9
    rigid = why.pop(frozenset(("left_clavicle", "right_clavicle")))
    assert "no joint moves them" in rigid
    assert all("within the limits they do not meet farther than" in reason for reason in why.values())


@pytest.mark.parametrize("upper", [1.6, 3.0, 6.2])
def test_a_forearm_folded_onto_its_upper_arm_is_no_longer_certified(upper: float) -> None:
    robot = load_robot(elbow_upper=upper)
    assert certificate_at(robot, np.radians(60))
    folded = certificate_at(robot, 1.45)
    assert not folded
    assert {folded.contact.link, folded.contact.other} == {"left_upper_arm", "left_forearm"}


@pytest.mark.parametrize("cubic", [False, True])
def test_beyond_its_limits_a_folded_forearm_is_not_certified(robot: Robot, cubic: bool) -> None:
    """The nominal limits keep it from folding, so the robot itself does not check it; a motion may leave them."""
    q = np.tile(robot.initial, (2, 1))
    q[1, ELBOW] = -1.2
    still, fast = np.zeros_like(q), np.zeros_like(q)
    fast[0, ELBOW] = 12.0  # swings up to 1.5 rad between the samples
    t = np.array([0.0, 1.0])
    within = verify(robot, NOTHING, SimpleNamespace(t=t, q=q, timing=SimpleNamespace(velocity=still)))
    assert within.certified
    assert within.unchecked_pairs == robot.unchecked_pairs
    if cubic:
        beyond = verify(robot, NOTHING, SimpleNamespace(t=t, q=q, timing=SimpleNamespace(velocity=fast)))
    else:
        q[1, ELBOW] = 1.45
        beyond = verify(robot, NOTHING, SimpleNamespace(t=t, q=q))
    assert not beyond.certified
    assert {beyond.contact.link, beyond.contact.other} == {"left_upper_arm", "left_forearm"}
    why = {frozenset((pair.link, pair.other)): pair.why for pair in beyond.unchecked_pairs}
    assert "checked only farther than 0.525 m" in why[frozenset(("left_upper_arm", "left_forearm"))]


def test_limits_that_have_nothing_to_do_with_neighbours_change_nothing(robot: Robot) -> None:
    q = np.tile(robot.initial, (2, 1))
    q[1, 0] = robot.upper[0] + 1.0  # along the rail
    certificate = verify(robot, NOTHING, SimpleNamespace(t=np.array([0.0, 1.0]), q=q))
    assert certificate.certified
    assert certificate.unchecked_pairs == robot.unchecked_pairs


def test_what_limits_keep_apart_is_apart_whatever_the_dimensions() -> None:
    """The parts of two bones at an angle of a, begun at b from the elbow, are 2 b sin(a/2) apart, less their radii."""
    rng, seen = np.random.default_rng(7), set()
    for _ in range(16):
        upper, radius = float(rng.uniform(0.9, 1.7)), float(rng.uniform(0.01, 0.08))
        lengths = {name: float(rng.uniform(0.3, 1.5)) for name in ("l_l2", "l_l3")}
        robot = load_robot(elbow_lower=-0.5, elbow_upper=upper, link_radius=radius, **lengths)
        why = {frozenset((pair.link, pair.other)): pair.why for pair in robot.unchecked_pairs}
        begins = np.sqrt((0.5 * (min(lengths.values()) + radius)) ** 2 - radius**2)
        apart = 2 * begins * np.sin(max(np.pi / 2 - upper, 0.0) / 2) - 2 * radius
        if abs(apart) > 2e-3:
            kept = "within the limits they do not meet" in why[frozenset(("left_upper_arm", "left_forearm"))]
            assert kept == (apart > 0)
            seen.add(kept)
    assert seen == {True, False}


def test_no_method_folds_an_arm(robot: Robot) -> None:
    folding = load_robot(elbow_upper=3.0)
    q = folding.initial.copy()
    q[ELBOW] = 1.45
    target = Kinematics(robot).hand_positions(q)[0]
    scene = Scene(name="fold", targets={"left": tuple(target), "right": None})
    for method in ("auto", SafeVelocity(c_kappa=0.0, c_mu=0.0)):
        trajectory = plan(folding, scene, method)
        assert trajectory.certified
        bones = [Kinematics(folding).bones(q) for q in trajectory.q[::5]]
        names = folding.link_names
        upper, lower = names.index("left_upper_arm"), names.index("left_forearm")
        for there in bones:
            away = np.linspace(0.0, 1.0, 101)[:, None]
            one, other = (there[i, 0] + away * (there[i, 1] - there[i, 0]) for i in (upper, lower))
            far = [points[np.linalg.norm(points - there[lower, 0], axis=1) > 0.53] for points in (one, other)]
            if len(far[0]) and len(far[1]):
                assert np.linalg.norm(far[0][:, None] - far[1][None], axis=2).min() > 0.1


@pytest.mark.parametrize("shape", [capsule, box])
def test_far_parts_are_checked_exactly_where_limits_let_them_meet(shape: object, rng: np.random.Generator) -> None:
    """The middles of two bones of length L at an angle of a are L sin(a/2) apart."""
    found = set()
    for bend in (*rng.uniform(1.5, 3.1, 6), 3.6):
        robot = arm(limits={"j1": f'lower="-1" upper="{bend}" velocity="1"'}, body=shape(0.5, 0.02))
        meets = 2 * 0.25 * np.sin(max(np.pi - bend, 0.0) / 2) < 2 * 0.02 * (1.0 if shape is capsule else 1.5)
        sure = bend < 2.8 or meets
        pairs = [{robot.link_names[i], robot.link_names[j]} for i, j in robot.self_collision_pairs]
        if sure:
            assert ({"b0", "b1"} in pairs) == meets, bend
            found.add(bool(meets))
        assert {"b1", "b2"} not in pairs  # +-2 rad
    assert found == {True, False}


def test_what_cannot_be_told_of_a_pair_is_said() -> None:
    sphere = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
    robot = arm(body=sphere)
    assert [pair.why for pair in robot.unchecked_pairs] == 2 * ["disabled by the SRDF; not checked anywhere"]


def test_certificates_list_what_they_leave_out(robot: Robot, tmp_path: Path) -> None:
    trajectory = plan(robot, Scene(name="s", targets={"left": (-1.6, 0.6, 3.4), "right": None}))
    certificate = trajectory.certificate
    assert certificate.unchecked_pairs == robot.unchecked_pairs
    assert {"left_hand", "right_hand", "base_link"} < set(certificate.links_without_body)
    assert "left_forearm" not in certificate.links_without_body
    assert trajectory.summary()["certificate"]["unchecked_pairs"][0] == asdict(robot.unchecked_pairs[0])
    write_trajectory(trajectory, tmp_path)
    assert read_trajectory(tmp_path).certificate == certificate


def test_a_bar_that_reaches_behind_its_joint_has_no_far_part() -> None:
    """b1 extends 0.2 m behind j1 and 0.3 m before it: where b0 touches it behind, that is far from the joint too."""
    long = '<collision><origin xyz="0.05 0 0"/><geometry><box size="0.5 0.04 0.04"/></geometry></collision>'
    robot = arm(limits={"j1": 'lower="1.4" upper="2.8" velocity="1"'}, body=long)
    assert [pair.why for pair in robot.unchecked_pairs] == 2 * ["disabled by the SRDF; not checked anywhere"]
    assert robot.collision_model.ngeoms == 3


def test_beyond_limits_it_is_said_what_is_still_not_checked() -> None:
    ball = '<collision><geometry><sphere radius="0.02"/></geometry></collision>'
    robot = arm(limits={"j1": 'lower="-1" upper="1" velocity="1"'}, body=capsule(0.5, 0.02) + ball)
    q = np.array([[0.0, 0.0, 0.0], [0.0, 1.5, 0.0]])
    nothing = Scene(name="nothing", targets={"tool": (0, 0, 0)})
    certificate = verify(robot, nothing, SimpleNamespace(t=np.array([0.0, 1.0]), q=q))
    known = {(pair.link, pair.other): pair.why for pair in certificate.unchecked_pairs}
    assert "checked only farther than" in known["b0", "b1"]
    assert "of others of their bodies: not checked anywhere" in known["b0", "b1"]


@pytest.mark.parametrize(("distance", "helps"), [(0.7, True), (0.505, False)])
def test_a_limit_that_keeps_neighbours_apart_is_only_opened_as_far_as_they_stay_clear(
    distance: float, helps: bool
) -> None:
    """A stiff bone of 1 m and a forearm of 0.5 m, which would have to fold to 0.1 rad to get to the nearer place."""
    limits = {"j1": 'lower="-0.001" upper="0.001" velocity="2"', "j2": 'lower="-1.5" upper="2" velocity="2"'}
    scene = Scene(name="folded", targets={"tool": (distance, 0.0, 0.0)})
    pairs = "".join(
        f'<disable_collisions link1="{a}" link2="{b}"/>' for a, b in (("b0", "b1"), ("b1", "b2"), ("b0", "b2"))
    )
    srdf = f"<robot>{pairs}</robot>"
    trajectory = plan(arm(limits=limits, srdf=srdf), scene)
    assert trajectory.status == "target_out_of_reach"
    opened = [one.limit for one in trajectory.diagnosis.remedies if one.limit is not None and one.limit[0] == "j2"]
    assert [side for _, side, _ in opened] == (["upper"] if helps else [])
    for _, _, value in opened:
        wider = arm(limits={**limits, "j2": f'lower="-1.5" upper="{value}" velocity="2"'}, srdf=srdf)
        again = plan(wider, scene)
        assert (again.status, again.certified) == ("reached", True)
