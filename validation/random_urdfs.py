"""Random URDFs: of robots that are right, and of such in which something was spoiled as people and programs spoil it.

The seed and a URDF's number determine it.
"""

from __future__ import annotations

from collections.abc import Callable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

TEXTS = (
    *("", " ", "nan", "inf", "-inf", "1e400", "1e-400", "1e300", "-1", "0", "-0.0", "0,3", "0.3 m", "0x1p-2", "1_0"),
    *("½", "True", "${r}", "&amp;", "1 2", "1 2 3 4", "1\n2\t3", " 0.3 ", "+.3", "3.", "1e-3", "b", "l0", "universe"),
)
"""What attributes are replaced by."""
TAGS = (
    *("Collision", "colision", "u:collision", "collision", "visual", "link", "joint", "gazebo", "collision_checking"),
    *("geometry", "sphere", "cone", "mesh", "capsule", "origin", "orign", "axis", "limit", "mimic", "inertial"),
)
"""What elements are renamed to, or added."""
KINDS = ("revolute", "prismatic", "fixed")
"""The types of joints."""


def random_urdf(seed: int, index: int) -> str:
    """Return the URDF of a number: whole one time in four, otherwise with one to three things spoiled."""
    rng = np.random.default_rng([seed, index])
    root = robot(rng)
    if rng.random() < 0.75:
        for _ in range(rng.integers(1, 4)):
            spoils[rng.integers(len(spoils))](rng, root)
    text = ElementTree.tostring(root, encoding="unicode")
    if rng.random() < 0.03:
        cut = int(rng.integers(len(text)))
        text = text[:cut] + str(rng.choice(["<", "&", '"', "\x00", "<!--", "]]>", "é", ""])) + text[cut + 1 :]
    if rng.random() < 0.03:
        text = f'<?xml version="1.0"?><!DOCTYPE robot [<!ENTITY r "0.3">]>{text}'
    return text


def robot(rng: np.random.Generator) -> Element:
    """Return a robot that is right: an arm of three joints, and more links that hang anywhere."""
    root = Element("robot", name="r", version=str(rng.choice(["1.0", "1.1", "1.2"])))
    if root.get("version") == "1.0" and rng.random() < 0.7:
        del root.attrib["version"]
    for i in range(4 + int(rng.integers(4))):
        link(rng, root, i)
        if i:
            parent = i - 1 if i < 4 else int(rng.integers(i))
            joint(rng, root, i, parent, "revolute" if i < 4 else str(rng.choice(KINDS)))
    return root


def link(rng: np.random.Generator, root: Element, i: int) -> None:
    """Add a link with any number of bodies; the first has one at least."""
    element = SubElement(root, "link", name=f"l{i}")
    if rng.random() < 0.3:
        inertial = SubElement(element, "inertial")
        SubElement(inertial, "mass", value="1")
        moments = {"ixx": "1", "iyy": "1", "izz": "1", "ixy": "0", "ixz": "0", "iyz": "0"}
        SubElement(inertial, "inertia", moments)
        origin(rng, inertial, root)
    for k in range(int(rng.integers(3)) + (i == 0)):
        body(rng, SubElement(element, "collision", name=f"c{k}"), root)
    if rng.random() < 0.3:
        body(rng, SubElement(element, "visual"), root)
    cylinders = [c for c in element.findall("collision") if c.find("geometry/cylinder") is not None]
    if cylinders and rng.random() < 0.5:
        SubElement(SubElement(element, "collision_checking"), "capsule", name=cylinders[0].get("name", ""))


def body(rng: np.random.Generator, element: Element, root: Element) -> None:
    """Fill a `<collision>` or `<visual>`."""
    origin(rng, element, root)
    geometry = SubElement(element, "geometry")
    radius, length, *size = (repr(x) for x in rng.uniform(0.01, 2.0, 5).tolist())
    kinds = ["sphere", "box", "cylinder"] + ["capsule"] * (root.get("version", "1.0") > "1.0")
    match str(rng.choice(kinds)):
        case "sphere":
            SubElement(geometry, "sphere", radius=radius)
        case "box":
            SubElement(geometry, "box", size=" ".join(size))
        case kind:
            SubElement(geometry, kind, radius=radius, length=length)


def origin(rng: np.random.Generator, element: Element, root: Element) -> None:
    """Add an `<origin>`, or none."""
    attributes = {"xyz": numbers(rng, 3), "rpy": numbers(rng, 3)}
    if root.get("version", "1.0") > "1.0" and rng.random() < 0.3:
        attributes = {"quat_xyzw": numbers(rng, 4)}
    if rng.random() < 0.7:
        SubElement(element, "origin", attributes)


def joint(rng: np.random.Generator, root: Element, i: int, parent: int, kind: str) -> None:
    """Add the joint that moves a link; from the fourth on it may mimic one of the first three."""
    element = SubElement(root, "joint", name=f"j{i}", type=kind)
    SubElement(element, "parent", link=f"l{parent}")
    SubElement(element, "child", link=f"l{i}")
    origin(rng, element, root)
    if kind != "fixed":
        SubElement(element, "axis", xyz=numbers(rng, 3))
        SubElement(element, "limit", lower="-1", upper="1", velocity="1", effort="1")
        if i > 3 and rng.random() < 0.5:
            SubElement(element, "mimic", joint=f"j{rng.integers(1, 4)}", multiplier=numbers(rng, 1))


def numbers(rng: np.random.Generator, count: int) -> str:
    """Return numbers with blanks between them."""
    return " ".join(repr(x) for x in rng.uniform(-1.5, 1.5, count).tolist())


def some(rng: np.random.Generator, root: Element) -> tuple[Element, Element]:
    """Return any element but the root, and its parent."""
    pairs = [(child, parent) for parent in root.iter() for child in parent]
    return pairs[rng.integers(len(pairs))] if pairs else (SubElement(root, "link"), root)


def spoil_attribute(rng: np.random.Generator, root: Element) -> None:
    """Replace the value of an attribute."""
    element = some(rng, root)[0]
    if element.attrib:
        element.set(str(rng.choice(list(element.attrib))), str(rng.choice(TEXTS)))


def drop_attribute(rng: np.random.Generator, root: Element) -> None:
    """Drop an attribute, or spell it otherwise."""
    element = some(rng, root)[0]
    if element.attrib:
        name = str(rng.choice(list(element.attrib)))
        value = element.attrib.pop(name)
        if rng.random() < 0.5:
            element.set(str(rng.choice([name.upper(), name[::-1], f"u:{name}"])), value)


def drop_element(rng: np.random.Generator, root: Element) -> None:
    """Drop an element."""
    child, parent = some(rng, root)
    parent.remove(child)


def rename_element(rng: np.random.Generator, root: Element) -> None:
    """Call an element otherwise."""
    child = some(rng, root)[0]
    child.tag = str(rng.choice([*TAGS, child.tag.capitalize()]))


def double_element(rng: np.random.Generator, root: Element) -> None:
    """Write an element twice, or into another one as well."""
    child, parent = some(rng, root)
    home = parent if rng.random() < 0.5 else some(rng, root)[0]
    home.append(ElementTree.fromstring(_text(child)))


def add_element(rng: np.random.Generator, root: Element) -> None:
    """Add an empty element anywhere."""
    SubElement(some(rng, root)[0], str(rng.choice(TAGS)))


def swap_names(rng: np.random.Generator, root: Element) -> None:
    """Have a joint, a link or a mimic name another one."""
    named = [element for element in root.iter() if {"link", "joint"} & element.attrib.keys()]
    if named:
        element = named[rng.integers(len(named))]
        name = "link" if "link" in element.attrib else "joint"
        element.set(name, f"{name[0]}{rng.integers(8)}")


def change_version(rng: np.random.Generator, root: Element) -> None:
    """Name another version, or a namespace."""
    root.set("version", str(rng.choice(["1.0", "1.1", "1.2", "1.3", "2", "", "1.1.0"])))
    if rng.random() < 0.3:
        root.set("xmlns", "http://cell")


def _text(element: Element) -> str:
    return ElementTree.tostring(element, encoding="unicode").replace("u:", "u_")


spoils: tuple[Callable[[np.random.Generator, Element], None], ...] = (
    spoil_attribute,
    spoil_attribute,
    drop_attribute,
    drop_element,
    rename_element,
    double_element,
    add_element,
    swap_names,
    change_version,
)
"""The ways in which a URDF is spoiled."""
