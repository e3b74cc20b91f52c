"""URDFs as people have them: read as a whole, or refused by name. Independent: bodies by hand, placements by SciPy."""

from __future__ import annotations

from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest
from conftest import ROOT
from scipy.spatial.transform import Rotation
from test_robot_from_urdf import ARM, LIMIT, TIP

from humanoid_rail import Hand, InvalidInput, Motion, Robot, Scene, Sphere, build_urdf, robot_from_urdf, verify
from humanoid_rail.model.humanoid import paper_robot

SPHERE = '<sphere radius="0.1"/>'
COLLISION = f'<collision name="x"><geometry>{SPHERE}</geometry></collision>'
BODY = "link f.collision[0]"
JOINT = '<axis xyz="0 1 0"/>'


def of(urdf: str) -> Robot:
    return robot_from_urdf(urdf, None, TIP)


def version(number: str, urdf: str = ARM) -> str:
    return urdf.replace('<robot name="r"', f'<robot name="r" version="{number}"')


def shaped(shape: str) -> str:
    """The arm with another shape at its tip."""
    return ARM.replace(SPHERE, shape)


def placed(origin: str) -> str:
    """The arm with its shape elsewhere."""
    return ARM.replace("<geometry>", f"{origin}<geometry>")


def limited(limit: str, count: int = 1) -> str:
    """The arm with another limit of its first joint."""
    return ARM.replace(LIMIT, limit, count)


def in_tip(elements: str) -> str:
    """The arm with more in its last link, before its collision."""
    return ARM.replace(COLLISION, elements + COLLISION)


def beside(elements: str) -> str:
    """The arm with more in the robot."""
    return ARM.replace("<transmission", f"{elements}<transmission")


INERTIA = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
FAR = "1e5"
REFUSED = {
    # Shapes.
    shaped('<capsule radius="0.3" length="0.1"/>'): f"{BODY}.geometry.capsule.<capsule>",
    shaped('<sphere radius="0,3"/>'): f"{BODY}.geometry.sphere.radius",
    shaped('<sphere radius="0.3 m"/>'): f"{BODY}.geometry.sphere.radius",
    shaped('<sphere radius="nan"/>'): f"{BODY}.geometry.sphere.radius",
    shaped('<sphere radius="1e999"/>'): f"{BODY}.geometry.sphere.radius",
    shaped(f'<sphere radius="{FAR}"/>'): f"{BODY}.geometry.sphere.radius",
    placed(f'<origin xyz="{FAR} 0 0"/>'): f"{BODY}.origin.xyz",
    shaped('<sphere radius="0"/>'): f"{BODY}.geometry.sphere.radius",
    shaped('<sphere radius="-0.3"/>'): f"{BODY}.geometry.sphere.radius",
    shaped("<sphere/>"): f"{BODY}.geometry.sphere.radius",
    shaped('<sphere raduis="0.3"/>'): f"{BODY}.geometry.sphere.raduis",
    shaped(""): f"{BODY}.geometry",
    shaped(2 * SPHERE): f"{BODY}.geometry",
    shaped('<cone radius="1" length="1"/>'): f"{BODY}.geometry",
    shaped('<box size="1 1"/>'): f"{BODY}.geometry.box.size",
    shaped('<box size="-0.6 -0.6 -0.6"/>'): f"{BODY}.geometry.box.size",
    shaped('<cylinder radius="0.1"/>'): f"{BODY}.geometry.cylinder.length",
    shaped('<cylinder radius="0.1" length="-1"/>'): f"{BODY}.geometry.cylinder.length",
    shaped('<cylinder radius="0" length="1"/>'): f"{BODY}.geometry.cylinder.radius",
    shaped('<mesh filename="a.stl" scale="1 1"/>'): f"{BODY}.geometry.mesh.scale",
    ARM.replace(f"<geometry>{SPHERE}</geometry>", ""): f"{BODY}.geometry",
    ARM.replace("<geometry>", f"<geometry>{SPHERE}</geometry><geometry>"): f"{BODY}.geometry",
    ARM.replace("geometry", "Geometry"): f"{BODY}.Geometry",
    ARM.replace("collision", "Collision"): "link f.Collision",
    ARM.replace("collision", "colision"): "link f.colision",
    ARM.replace("collision", "u:collision"): "link f.u:collision",
    # One that cannot be read takes the others of its link with it in URDF readers.
    in_tip("<collision><geometry/></collision>"): f"{BODY}.geometry",
    in_tip("<visual/>"): "link f.visual[0].geometry",
    in_tip(f"<visual><geometry>{SPHERE}</geometry><material/></visual>"): "link f.visual[0].material.name",
    in_tip(f"<inertial>{INERTIA}</inertial>"): "link f.inertial.mass",
    in_tip(f'<inertial><mass value="1kg"/>{INERTIA}</inertial>'): "link f.inertial.mass.value",
    in_tip('<inertial><mass value="1"/><inertia ixx="1"/></inertial>'): "link f.inertial.inertia.ixy",
    in_tip('<collision_checking><capsule name="x"/></collision_checking>'): "link f.collision_checking.capsule[0].name",
    in_tip("<collision_checking><capsule/></collision_checking>"): "link f.collision_checking.capsule[0].name",
    in_tip("<collision_checking/><collision_checking/>"): "link f.collision_checking",
    # Placements.
    placed('<origin xyz="1 2"/>'): f"{BODY}.origin.xyz",
    placed('<origin xyz="1,2,3"/>'): f"{BODY}.origin.xyz",
    placed('<origin xyz="1 2 nan"/>'): f"{BODY}.origin.xyz",
    placed('<origin rpy="90deg 0 0"/>'): f"{BODY}.origin.rpy",
    placed('<origin xzy="1 2 3"/>'): f"{BODY}.origin.xzy",
    placed('<orign xyz="1 2 3"/>'): f"{BODY}.orign",
    placed('<origin xyz="1 2 3"/><origin xyz="3 2 1"/>'): f"{BODY}.origin",
    placed('<origin quat_xyzw="0 0 0 1"/>'): f"{BODY}.origin.quat_xyzw",
    version("1.1", placed('<origin quat_xyzw="0 0 0 0"/>')): f"{BODY}.origin.quat_xyzw",
    version("1.1", placed('<origin quat_xyzw="0 0 0 1" rpy="0 0 1"/>')): f"{BODY}.origin.quat_xyzw",
    # Joints.
    version("1.2", limited(LIMIT.replace('lower="-1"', ""))): "joint one.limit.lower",
    limited(LIMIT.replace("upper", "uper")): "joint one.limit.uper",
    ARM.replace(JOINT, '<axis xyz="0 1e-9 0"/>', 1): "joint two.axis.xyz",
    ARM.replace('<origin xyz="1 0 0"/>', '<origin xyz="1 0"/>', 1): "joint two.origin.xyz",
    ARM.replace(JOINT, '<axis xyz="0 0 0"/>', 1): "joint two.axis.xyz",
    ARM.replace(JOINT, '<axis xyz="0 1"/>', 1): "joint two.axis.xyz",
    ARM.replace(JOINT, "<axis/>", 1): "joint two.axis.xyz",
    ARM.replace(JOINT, '<axes xyz="0 0 1"/>', 1): "joint two.axes",
    ARM.replace('"prismatic"', '"Prismatic"'): "joint five.type",
    ARM.replace(' type="prismatic"', ""): "joint five.type",
    ARM.replace('<child link="f"/>', '<child link="F"/>'): "joint five.child.link",
    ARM.replace('<parent link="e"/>', ""): "joint five.parent",
    ARM.replace('name="five"', 'name="four"'): "urdf.joint[4].name",
    ARM.replace('name="five"', 'name="universe"'): "urdf.joint[4].name",
    ARM.replace('<link name="e"/>', '<link name="d"/>'): "urdf.link[4].name",
    beside("<link/>"): "urdf.link[6].name",
    beside('<link name="loose"/>'): "urdf",
    beside('<joint name="j" type="fixed"><parent link="a"/><child link="f"/></joint>'): "joint j.child.link",
    beside('<link name="z"/><joint name="j" type="fixed"><parent link="z"/><child link="z"/></joint>'): "link z",
    limited(""): "joint one.limit",
    limited(2 * LIMIT): "joint one.limit",
    limited(LIMIT.replace('"-1"', '"nan"')): "joint one.limit.lower",
    limited(LIMIT.replace('"-1"', '"3"')): "joint one.limit",
    limited('<limit velocity="1" effort="1"/>'): "joint one.limit",
    limited('<limit lower="-1" upper="2" effort="1"/>'): "joint one.limit.velocity",
    limited(LIMIT.replace('velocity="1"', 'velocity="-1"')): "joint one.limit.velocity",
    limited(LIMIT.replace("/>", ' acceleration="-1"/>')): "joint one.limit.acceleration",
    limited(LIMIT.replace("/>", ' drake:acceleration="3 rad"/>')): "joint one.limit.drake:acceleration",
    limited(LIMIT.replace("/>", ' drake:acceleration="-3"/>')): "joint one.limit.drake:acceleration",
    limited(LIMIT.replace("/>", ' jerk="0"/>')): "joint one.limit.jerk",
    limited(LIMIT + "<dynamics/>"): "joint one.dynamics",
    limited(LIMIT + '<safety_controller k_velocity="high"/>'): "joint one.safety_controller.k_velocity",
    ARM.replace('joint="one"', 'joint="nobody"'): "joint two.mimic.joint",
    ARM.replace('joint="one"', 'joint="two"'): "joint two.mimic.joint",
    ARM.replace('joint="one"', 'joint="three"'): "joint three.mimic.joint",
    ARM.replace('"2" offset', '"twice" offset'): "joint two.mimic.multiplier",
    ARM.replace("mimic ", "Mimic ").replace("</mimic", "</Mimic"): "joint two.Mimic",
    # Files.
    beside(COLLISION): "urdf",
    in_tip(f"<visual>{COLLISION}<geometry>{SPHERE}</geometry></visual>"): "urdf",
    limited(LIMIT + COLLISION): "urdf",
    ARM.replace('<link name="a"/>', '<link name="a"><link name="z"/></link>'): "urdf",
    version("1.3"): "urdf.version",
    version("1"): "urdf.version",
    ARM.replace('<robot name="r"', "<robot"): "urdf.name",
    "<sdf/>": "urdf",
    "<robot name='r'/>": "urdf",
    ARM.replace("</robot>", "<xacro:arm/></robot>"): "urdf",
    f'<!DOCTYPE robot [<!ENTITY r "0.1">]>{shaped("<sphere radius=" + chr(34) + "&r;" + chr(34) + "/>")}': "urdf",
    "robots/humanoid_rail.urdf": "urdf",
}


@pytest.mark.parametrize(("urdf", "field"), REFUSED.items(), ids=REFUSED.values())
def test_what_cannot_be_read_is_named(urdf: str, field: str) -> None:
    assert urdf != ARM
    with pytest.raises(InvalidInput) as caught:
        of(urdf)
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("shape", "kind", "sizes"),
    [
        ('<sphere radius=" .3 "/>', coal.Sphere, [0.3]),
        ('<box size="1\n 2.\t+3e-1"/>', coal.Box, [0.5, 1.0, 0.15]),
        ('<cylinder radius="0.1" length="2"/>', coal.Cylinder, [0.1, 1.0]),
        ('<capsule radius="0.1" length="2"/>', coal.Capsule, [0.1, 1.0]),
        ('<capsule radius="0" length="2"/>', coal.Capsule, [0.0, 1.0]),
    ],
)
def test_bodies_have_the_sizes_that_are_written(shape: str, kind: type, sizes: list[float]) -> None:
    """Also with blanks that URDF readers stumble over, and beside another body of the same name."""
    for namespace in ("", ' xmlns="http://cell"', ' xmlns:u="http://cell"'):
        urdf = version("1.1", in_tip(f"<collision name='x'><geometry>{shape}</geometry></collision>"))
        one, other = of(urdf.replace('name="r"', f'name="r"{namespace}')).collision_model.geometryObjects
        assert isinstance(one.geometry, kind)
        found = one.geometry.halfSide if kind is coal.Box else [one.geometry.radius]
        if kind in (coal.Cylinder, coal.Capsule):
            found = [*found, one.geometry.halfLength]
        np.testing.assert_allclose(found, sizes)
        assert (type(other.geometry), other.geometry.radius) == (coal.Sphere, 0.1)


def test_origins_by_quaternion(rng: np.random.Generator) -> None:
    for turn in Rotation.random(5, rng=rng):
        x, y, z, w = 3.0 * turn.as_quat()
        body = of(version("1.1", placed(f'<origin xyz="1 2 3" quat_xyzw="{x} {y} {z} {w}"/>')))
        joint = of(version("1.1", ARM.replace("<axis", f'<origin quat_xyzw="{x} {y} {z} {w}"/><axis', 1)))
        at = body.collision_model.geometryObjects[0].placement
        np.testing.assert_allclose(at.rotation, turn.as_matrix(), atol=1e-12)
        np.testing.assert_array_equal(at.translation, [1, 2, 3])
        np.testing.assert_allclose(joint.model.jointPlacements[1].rotation, turn.as_matrix(), atol=1e-12)


@pytest.mark.parametrize("urdf", [ARM, build_urdf()], ids=["arm", "paper"])
def test_bodies_are_those_of_pinocchios_reader(urdf: str) -> None:
    """As far as it reads them: that it leaves out what it cannot read is why it is not used."""
    robot = of(urdf) if urdf is ARM else paper_robot(urdf)
    expected = pin.buildGeomFromUrdfString(robot.model, urdf, pin.GeometryType.COLLISION).geometryObjects
    bodies = list(robot.collision_model.geometryObjects)[: len(expected)]
    for body, other in zip(bodies, expected, strict=True):
        assert (body.name, body.parentJoint, body.parentFrame) == (other.name, other.parentJoint, other.parentFrame)
        assert type(body.geometry) is type(other.geometry)
        assert body.geometry == other.geometry
        np.testing.assert_allclose(body.placement.homogeneous, other.placement.homogeneous, atol=1e-12)


@pytest.mark.parametrize("shape", ['<sphere radius="0.3"/>', '<capsule radius="0.3" length="0.1"/>'])
def test_a_body_that_is_written_is_in_the_proof(shape: str) -> None:
    """An obstacle at its centre, 0.4 m inside."""
    more = f'<link name="box"><collision><geometry>{shape}</geometry></collision></link>'
    more += '<joint name="mount" type="fixed"><parent link="carriage"/><child link="box"/></joint></robot>'
    robot = paper_robot(version("1.1", build_urdf().replace("humanoid_rail", "r")).replace("</robot>", more))
    at = tuple(np.array([0.0, robot.initial[0], 0.0]))
    scene = Scene(name="inside", targets={}, obstacles=(Sphere(center=at, radius=0.1),))
    certificate = verify(robot, scene, Motion(np.array([0.0, 1.0]), np.tile(robot.initial, (2, 1)), robot.joint_names))
    assert certificate.clearance_bound == pytest.approx(-0.4, abs=1e-3)
    assert not certificate.certified


@pytest.mark.parametrize(
    ("attributes", "acceleration", "jerk"),
    [
        ("", np.inf, np.inf),
        ('acceleration="3"', 3.0, np.inf),
        ('acceleration="3" deceleration="2" jerk="40"', 2.0, 40.0),
        ('drake:acceleration="4" acceleration="5"', 4.0, np.inf),
        ('d:acceleration="4" xmlns:d="http://drake.mit.edu"', 4.0, np.inf),
    ],
)
@pytest.mark.parametrize("number", ["1.0", "1.2"])
def test_limits_of_acceleration_and_jerk(attributes: str, acceleration: float, jerk: float, number: str) -> None:
    robot = of(version(number, limited(LIMIT.replace("/>", f" {attributes}/>"))))
    assert list(robot.acceleration_limit) == [acceleration, np.inf, np.inf]
    assert list(robot.jerk_limit) == [jerk, np.inf, np.inf]


def test_limits_that_may_be_in_degrees_are_warned_of(recwarn: pytest.WarningsRecorder) -> None:
    of(limited(LIMIT.replace('"-1"', '"-6.283185307"')))
    of(limited(LIMIT.replace('"-1"', '"0.25"').replace('upper="2"', 'upper="0.25"')))  # a joint that is held
    assert not recwarn.list
    with pytest.warns(UserWarning, match="joint one turns from -170 to 2 rad"):
        of(limited(LIMIT.replace('"-1"', '"-170"')))


def test_a_multiplier_of_0_holds_a_joint_at_its_offset() -> None:
    robot = of(ARM.replace('multiplier="2"', 'multiplier="0"'))
    np.testing.assert_allclose(robot.full_configuration([0.3, 1.0, 2.0]), [0.3, 0.5, -0.5, 1.0, 2.0])


def test_files_are_read_by_their_paths(robot: Robot, tmp_path: Path) -> None:
    folder = ROOT / "robots"
    read = robot_from_urdf(folder / "humanoid_rail.urdf", folder / "humanoid_rail.srdf", robot.hands)
    assert read.urdf == (folder / "humanoid_rail.urdf").read_text(encoding="utf-8")
    assert read.self_collision_pairs == robot.self_collision_pairs
    (tmp_path / "latin.urdf").write_bytes("<robot name='é'/>".encode("latin-1"))
    for path in (tmp_path, tmp_path / "nothing.urdf", tmp_path / "latin.urdf"):
        with pytest.raises(InvalidInput, match="a file that can be read"):
            robot_from_urdf(path, None, TIP)


@pytest.mark.parametrize(
    ("hands", "field"),
    [
        (TIP[0], "hands"),
        ("tip", "hands"),
        (["tip"], "hands"),
        (None, "hands"),
        ([Hand(1, "f", TIP[0].arm)], "hands.name"),
        ([Hand("tip", 5, TIP[0].arm)], "hands.tip.frame"),
        ([Hand("tip", "f", None)], "hands.tip.arm"),
        ([Hand("tip", "f", TIP[0].arm, (0.0, 0.0, 0.0))], "hands.tip.pointing"),
        ([Hand("tip", "f", TIP[0].arm, (0.0, np.nan, 1.0))], "hands.tip.pointing"),
        ([Hand("tip", "f", TIP[0].arm, "x")], "hands.tip.pointing"),
        ([Hand("tip", "f", TIP[0].arm, (1.0, 0.0))], "hands.tip.pointing"),
    ],
)
def test_hands_of_a_wrong_kind(hands: list[Hand], field: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        robot_from_urdf(ARM, None, hands)
    assert caught.value.field == field
