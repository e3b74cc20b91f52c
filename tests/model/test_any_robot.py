"""What is found and assumed of any robot: hands, joints that move, limits, starts, and what is said of them."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path

import numpy as np
import pytest
from arms import box, fixed, joint, long_arm

from humanoid_rail import InvalidInput, Robot, load_robot

HAND = {"hand": {"frame": "l5"}}
LEAD = f'<link name="side">{box(0.05, 0.01)}</link>' + joint(
    "lead", "base", "side", -0.3, 'lower="-1" upper="1" velocity="2" acceleration="30"'
)
"""A joint beside the arm, which one of the arm may follow."""


def following(leader: str, multiplier: float = 1.0) -> str:
    return f'<mimic joint="{leader}" multiplier="{multiplier}"/>'


def state(name: str, **positions: float) -> str:
    joints = "".join(f'<joint name="{joint}" value="{value}"/>' for joint, value in positions.items())
    return f'<group_state name="{name}" group="arm">{joints}</group_state>'


def srdf(text: str) -> str:
    return f'<robot name="long">{text}</robot>'


def said(robot: Robot, part: str) -> list[str]:
    return [sentence for sentence in robot.assumed if part in sentence]


@pytest.mark.parametrize("posture", [{"j0": 0.3, "j2": -0.4}, {"j4": 1.6}])
def test_a_posture_that_the_robot_cannot_have_is_left_out_and_it_is_said(posture: dict[str, float]) -> None:
    urdf = long_arm(joints={"j2": 'lower="0.3" upper="1.5" velocity="1"'})
    robot = load_robot(urdf, srdf=srdf(state("home", **posture) + state("bent", j2=0.5)))
    assert list(robot.postures) == ["bent"]
    assert robot.initial[2] == 0.5
    name, value = list(posture.items())[-1]
    [sentence] = said(robot, "home")
    assert f"{name} at {value:g} is not a position within" in sentence
    with pytest.raises(InvalidInput, match=rf"initial is 'home'.*{name} at {value:g}"):
        load_robot(urdf, srdf=srdf(state("home", **posture)), initial="home")
    known = load_robot(urdf, srdf=srdf(state("home", **posture)), postures={"home": {"j2": 0.6}}, initial="home")
    assert known.initial[2] == 0.6
    assert not said(known, "home")


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"initial": {"j1": 9.0}}, r"initial\.j1 is 9\.0; valid: a position within -1\.5 to 1\.5"),
        ({"initial": [0.0, 0.0, 0.0, 0.0, -1.6, 0.0]}, r"initial\.j4 is -1\.6"),
        ({"postures": {"far": {"j3": 2.0}}}, r"postures\.far\.j3 is 2\.0"),
    ],
)
def test_positions_that_are_given_are_within_the_limits(given: dict[str, object], field: str) -> None:
    with pytest.raises(InvalidInput, match=field):
        load_robot(long_arm(), **given)  # type: ignore[arg-type]


def test_rounding_beyond_a_limit_is_put_onto_it() -> None:
    robot = load_robot(long_arm(), initial={"j1": 1.5 + 1e-12})
    assert robot.initial[1] == 1.5


def test_a_start_that_is_given_and_touches_is_refused() -> None:
    post = fixed("stand", "base", "post", "0.1 0.1 0", box(0.05, 0.03))
    with pytest.raises(InvalidInput, match=r"initial .*l0 and post"):
        load_robot(long_arm(more=post), initial={"j0": 0.8, "j1": 0.3})
    assert load_robot(long_arm(more=post), initial={"j0": -0.8, "j1": 0.3}).initial[0] == -0.8


@pytest.mark.parametrize(
    "given", [{"locked": {"j2": 0.1}}, {"joints": ["j0", "j1", "j3", "j4", "j5"]}, {"locked_joints": ["j2"]}]
)
def test_a_hand_given_by_its_frame_may_have_locked_joints(given: dict[str, object]) -> None:
    robot = load_robot(long_arm(), hands=HAND, **given)  # type: ignore[arg-type]
    assert robot.hands[0].arm == robot.joint_names == ("j0", "j1", "j3", "j4", "j5")
    with pytest.raises(InvalidInput, match=r"hands\.hand\.arm is 'j2'"):
        load_robot(long_arm(), hands={"hand": {"frame": "l5", "arm": ["j1", "j2", "j3"]}}, **given)  # type: ignore[arg-type]


def test_a_follower_moves_with_its_leader_wherever_that_is() -> None:
    urdf = long_arm(joints={"j3": following("lead")}, more=LEAD)
    robot = load_robot(urdf, hands=HAND)
    assert robot.joint_names == ("j0", "j1", "j2", "j4", "j5", "lead")
    assert set(robot.hands[0].arm) == {"j0", "j1", "j2", "j4", "j5", "lead"}
    assert not robot.locked
    # The same where joints are named; and one that is not to move does not, whatever it follows.
    named = load_robot(urdf, hands=HAND, joints=["j0", "j1", "j2", "j3", "j4", "j5"])
    assert named.joint_names == robot.joint_names
    still = load_robot(urdf, hands=HAND, locked_joints=["j3"])
    assert dict(still.locked) == {"j3": 0.0}
    assert said(still, "as asked for: j3 at 0")
    assert not said(still, "no hand needs")


def test_joints_that_are_not_among_those_that_are_to_move_are_said_to_be_so() -> None:
    robot = load_robot(long_arm(), hands=HAND, joints=["j0", "j1", "j2", "j4"])
    assert said(robot, "not among those that are to move: j3 at 0, j5 at 0")


@pytest.mark.parametrize("multiplier", [2.0, -8.0])
def test_a_follower_without_limits_leaves_those_of_its_leader(multiplier: float) -> None:
    turns = f'<mimic joint="j1" multiplier="{multiplier}"/>'
    finger = (
        '<link name="f"/><joint name="follows" type="continuous"><parent link="l5"/><child link="f"/>'
        f'<axis xyz="0 0 1"/><limit effort="1" velocity="0"/>{turns}</joint>'
    )
    given = {"j1": {"acceleration": 11.0}}
    plain = load_robot(long_arm(), hands=HAND, limits=given)
    robot = load_robot(long_arm(more=finger), hands={"hand": {"frame": "f"}}, limits=given)
    for limit in ("lower", "upper", "velocity_limit", "acceleration_limit"):
        np.testing.assert_allclose(getattr(robot, limit), getattr(plain, limit), rtol=1e-9, err_msg=limit)
    # Its own limits count, and alone those.
    own = {"follows": {"velocity": 1.0, "upper": 4.0}}
    robot = load_robot(long_arm(more=finger), hands={"hand": {"frame": "f"}}, limits=given | own)
    assert robot.velocity_limit[1] == pytest.approx(1.0 / abs(multiplier))
    bound = robot.upper[1] if multiplier > 0 else robot.lower[1]
    assert bound == pytest.approx(min(1.5, 4.0 / abs(multiplier)) * np.sign(multiplier))
    assert robot.acceleration_limit[1] == 11.0


def test_names_in_an_srdf_that_the_urdf_does_not_have_are_warned_of() -> None:
    text = '<disable_collisions link1="l0" link2="l33"/><virtual_joint name="floor"/>' + state("up", floor=0, j=1)
    with pytest.warns(UserWarning, match="srdf") as warned:
        robot = load_robot(long_arm(), srdf=srdf(text))
    messages = "\n".join(str(warning.message) for warning in warned)
    assert "srdf.disable_collisions.link2: no link of the URDF, so of no effect; l33; did you mean l3?" in messages
    assert "srdf.group_state.joint.name: no joint of the URDF, so of no effect; j;" in messages
    assert "floor" not in messages
    assert frozenset(("l0", "l3")) in {
        frozenset((robot.link_names[i], robot.link_names[j])) for i, j in robot.self_collision_pairs
    }


@pytest.mark.parametrize("wanted", ["[more]>=1", " @ file:///x", "=>1", "; python_version > '3'"])
def test_what_is_no_package_is_refused(wanted: str) -> None:
    with pytest.raises(InvalidInput, match=r"package is .*; valid: the name of a Python package"):
        load_robot(long_arm(), package=f"example-robot-data{wanted}")


def test_a_version_of_a_package_that_is_not_there_is_refused() -> None:
    try:
        there = metadata.version("example-robot-data")
    except metadata.PackageNotFoundError:
        pytest.skip("needs the package example-robot-data: humanoid_rail[robots]")
    for wanted in (">=99", "~=0.1", "<1,>2"):
        with pytest.raises(InvalidInput, match=f"a version that is installed; there is example-robot-data {there}"):
            load_robot(long_arm(), package=f"example-robot-data{wanted}")
    assert load_robot(long_arm(), package=f"example-robot-data >= 1, == {there}").n == 6
    with pytest.warns(UserWarning, match=f"package is 'example-robot-data==0.0.1'; .* example-robot-data {there} here"):
        assert load_robot(long_arm(), package="example-robot-data==0.0.1").n == 6


def test_a_robot_with_a_link_world_gets_a_base() -> None:
    world = '<link name="world"/>'
    stand = '<joint name="world_to_base" type="fixed"><parent link="world"/><child link="base"/></joint>'
    other = '<joint name="world__to_world" type="fixed"><parent link="base"/><child link="extra"/></joint>'
    urdf = long_arm(more=f'{world}{stand}<link name="extra"/>{other}')
    robot = load_robot(urdf, hands=HAND, base={"xyz": [0.0, 0.0, 2.0]})
    assert robot.model.frames[robot.model.getFrameId("base")].placement.translation[2] == 2.0


@pytest.mark.parametrize("names", [["j3"], ["j3", "j4"]])
def test_an_arm_of_too_few_joints_that_move_is_refused(names: list[str]) -> None:
    with pytest.raises(InvalidInput, match=r"hands\.tool\.arm is .*three joints that move or more"):
        load_robot(long_arm(), hands={"tool": {"frame": "l5"}}, joints=names)


def test_a_saved_robot_can_have_joints_locked(tmp_path: Path) -> None:
    load_robot(long_arm(), hands=HAND, initial={"j0": 0.3, "j4": 0.2}).save(tmp_path)
    for given in ({"locked": {"j4": 0.5}}, {"locked_joints": ["j4"]}, {"joints": ["j0", "j1", "j2", "j3", "j5"]}):
        robot = load_robot(tmp_path, **given)
        assert robot.joint_names == ("j0", "j1", "j2", "j3", "j5")
        assert robot.hands[0].arm == robot.joint_names
        assert robot.initial[0] == 0.3
        assert robot.locked["j4"] == given.get("locked", {}).get("j4", 0.0)
    with pytest.warns(UserWarning, match=r"acceleration_time: of no effect"):
        load_robot(tmp_path, acceleration_time=1.0)


def test_a_joint_is_locked_or_moves() -> None:
    with pytest.raises(InvalidInput, match=r"joints is 'j5'; valid: joints that move; this one is locked"):
        load_robot(long_arm(), hands=HAND, joints=[f"j{i}" for i in range(6)], locked={"j5": 0.1})


def test_limits_that_are_given_are_those_of_locked_joints_too() -> None:
    hand = {"hand": {"frame": "l4"}}
    with pytest.warns(UserWarning, match=r"limits\.j5: of no effect on motions"):
        robot = load_robot(long_arm(), hands=hand, locked={"j5": 1.8}, limits={"j5": {"upper": 2.0}})
    assert robot.locked["j5"] == 1.8
    with pytest.raises(InvalidInput, match=r"locked\.j5 is 1\.2.*-1\.5 to 1\.0"):
        load_robot(long_arm(), hands=hand, locked={"j5": 1.2}, limits={"j5": {"upper": 1.0}})
    with pytest.warns(UserWarning, match=r"limits\.j5: of no effect on motions"):
        resting = load_robot(long_arm(), hands=hand, limits={"j5": {"lower": 0.4}})
    assert resting.locked["j5"] == 0.4


def test_an_acceleration_that_is_given_replaces_a_deceleration() -> None:
    urdf = long_arm(joints={"j1": 'lower="-1" upper="1" velocity="1" acceleration="3" deceleration="2"'})
    assert load_robot(urdf, hands=HAND).acceleration_limit[1] == 2.0
    assert load_robot(urdf, hands=HAND, limits={"j1": {"acceleration": 9.0}}).acceleration_limit[1] == 9.0


def test_soft_limits_that_are_not_used_are_said() -> None:
    soft = '<safety_controller soft_lower_limit="-1" soft_upper_limit="1" k_velocity="1"/>'
    robot = load_robot(long_arm(joints={"j1": soft}), hands=HAND)
    assert said(robot, "safety_controller") == [
        "The joints j1 have a safety_controller, whose soft limits are not used."
    ]


@pytest.mark.parametrize(
    ("text", "match"),
    [
        (
            '<disable_collision link1="l0" link2="l3"/>',
            r"srdf\.disable_collision: no element .* did you mean disable_c",
        ),
        ('<disable_default_collisions link="l3"/>', r"srdf\.disable_default_collisions is not followed"),
        ('<group name="g"><disable_collisions link1="l0" link2="l3"/></group>', r"1 disable_collisions inside"),
    ],
)
def test_what_an_srdf_says_in_vain_is_warned_of(text: str, match: str) -> None:
    with pytest.warns(UserWarning, match=match):
        robot = load_robot(long_arm(), hands=HAND, srdf=srdf(text))
    assert {"l0", "l3"} not in [{pair.link, pair.other} for pair in robot.left_out]


@pytest.mark.parametrize("text", ["<foo/>", long_arm()])
def test_what_is_no_srdf_is_refused(text: str) -> None:
    with pytest.raises(InvalidInput, match=r"srdf is .<.*; valid: an SRDF"):
        load_robot(long_arm(), hands=HAND, srdf=text)


def test_pairs_that_an_srdf_enables_again_are_checked() -> None:
    pair = 'link1="l0" link2="l3"'
    robot = load_robot(long_arm(), hands=HAND, srdf=srdf(f"<disable_collisions {pair}/><enable_collisions {pair}/>"))
    assert {"l0", "l3"} not in [{pair.link, pair.other} for pair in robot.left_out]
