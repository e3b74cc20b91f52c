"""A URDF as frozen data, read strictly.

Readers of URDF drop what they cannot read and go on; a body that is dropped is missing from every proof. Here
everything that places, shapes or limits something can be read, or loading fails and says what is wrong where.

Source: the URDF specification up to version 1.2, https://wiki.ros.org/urdf/XML and https://github.com/ros/urdfdom.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeVar
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from humanoid_rail.errors import MISSING, InvalidInput, did_you_mean
from humanoid_rail.model.urdf_elements import Node, parse_xml
from humanoid_rail.model.urdf_joint import Joint, read_joint
from humanoid_rail.model.urdf_link import Link, read_colour, read_link

VERSIONS = ("1.0", "1.1", "1.2")
"""The versions of URDF that are read."""

_T = TypeVar("_T")


@dataclass(frozen=True, eq=False)
class Urdf:
    """A robot as its URDF describes it, a tree of links and joints."""

    name: str
    links: Mapping[str, Link]
    """By name, in the order of the file."""
    joints: Mapping[str, Joint]
    text: str
    """The same in a form in which every URDF reader reads the same numbers."""


def read_urdf(text: str) -> Urdf:
    """Return what a URDF describes.

    Raises:
        InvalidInput: If an element or attribute is missing, cannot be read, has a value that it cannot have, or is
            nearly called as one of URDF; names are not unique; or links and joints are no tree.
    """
    root = parse_xml("urdf", text)
    if root.tag != "robot":
        raise InvalidInput("urdf", f"<{root.tag}>", "<robot> as the outermost element")
    for element in root.iter():
        if element.tag.startswith("xacro:"):
            raise InvalidInput("urdf", f"<{element.tag}>", "a URDF; run xacro on this file first")
    version = root.get("version", VERSIONS[0])
    if version not in VERSIONS:
        raise InvalidInput("urdf.version", version, f"one of {', '.join(VERSIONS)}")
    robot = Node(root, "urdf", float(version))
    robot.check_children(("link", "joint", "material"))
    _check_nesting(root)
    colours = _by_name(robot, "material", read_colour)
    links = _by_name(robot, "link", lambda node: read_link(node, colours))
    joints = _by_name(robot, "joint", read_joint)
    _check_tree(links, joints)
    _check_mimics(joints)
    return Urdf(robot.text("name"), links, joints, ElementTree.tostring(root, encoding="unicode"))


def _by_name(robot: Node, tag: str, read: Callable[[Node], _T]) -> Mapping[str, _T]:
    """Read all elements with a tag, by their names."""
    found: dict[str, _T] = {}
    for node in robot.children(tag):
        name = node.text("name")
        # Pinocchio calls the world so.
        if name in found or name in ("", "universe"):
            raise InvalidInput(
                f"{node.where}.name", name, f"a name of its own, neither empty nor universe, for each {tag}"
            )
        found[name] = read(Node(node.element, f"{tag} {name}", robot.version))
    return MappingProxyType(found)


def _check_nesting(root: Element) -> None:
    """Check that bodies, links and joints are where readers look for them; extensions may hold what they like."""
    homes = {"visual": "link", "collision": "link", "link": "robot", "joint": "robot"}
    for home in (root, *(inner for child in root if child.tag in ("link", "joint") for inner in child.iter())):
        for child in home:
            right = homes.get(child.tag.rpartition(":")[2].lower(), home.tag)
            if right != home.tag:
                raise InvalidInput("urdf", f"<{child.tag}> in <{home.tag}>", f"one directly in a <{right}>")


def _check_tree(links: Mapping[str, Link], joints: Mapping[str, Joint]) -> None:
    """Check that every link hangs on one root, so that none is left out."""
    moved: dict[str, str] = {}
    for joint in joints.values():
        for end in ("parent", "child"):
            if (link := getattr(joint, end)) not in links:
                raise InvalidInput(f"joint {joint.name}.{end}.link", link, "a link of the URDF")
        if joint.child in moved:
            raise InvalidInput(f"joint {joint.name}.child.link", joint.child, f"no child of {moved[joint.child]} too")
        moved[joint.child] = joint.name
    roots = [name for name in links if name not in moved]
    if len(roots) != 1:
        raise InvalidInput("urdf", roots or MISSING, "one link that is no child of a joint, the root")
    reached, ahead = set[str](), roots
    while ahead:
        reached |= {*ahead}
        ahead = [joint.child for joint in joints.values() if joint.parent in ahead]
    for name in links:
        if name not in reached:
            raise InvalidInput(f"link {name}", "in a cycle of joints", f"a link that hangs on {roots[0]}")


def _check_mimics(joints: Mapping[str, Joint]) -> None:
    """Check that every joint that follows others follows, in the end, one that is moved by itself."""
    for name, joint in joints.items():
        chain = [name]
        while joint.mimic is not None:
            where, leader = f"joint {chain[-1]}.mimic.joint", joint.mimic.joint
            if leader not in joints or joints[leader].kind == "fixed":
                near = did_you_mean(leader, list(joints))
                raise InvalidInput(where, leader, f"a joint of the URDF that moves{near}")
            if leader in chain:
                raise InvalidInput(where, leader, "a joint that does not follow this one itself")
            chain.append(leader)
            joint = joints[leader]
