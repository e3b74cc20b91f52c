"""Bodies of hands that a robot file gives: they become links of the URDF, fixed to the hands' frames."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.hand_links import link_of
from humanoid_rail.model.robot_file import BodyEntry, BoxEntry, CapsuleEntry, HandEntry
from humanoid_rail.model.urdf import Urdf, read_urdf
from humanoid_rail.model.urdf_elements import parse_xml

COLOUR = "0.35 0.38 0.42 1"
"""The bodies are seen in this colour: red, green, blue and opacity from 0 to 1."""


def with_hand_bodies(urdf: Urdf, hands: Mapping[str, HandEntry]) -> tuple[Urdf, dict[str, str]]:
    """Return a URDF with the bodies that hands are given, and the link that has them, by hand.

    The link is fixed to the hand's frame and has its axes. It has the bodies for collision and to be seen, and no mass.

    Args:
        urdf: The robot.
        hands: Its hands by name, with frames that are there.

    Raises:
        InvalidInput: If two bodies of a hand are the same.
    """
    given = {name: hand for name, hand in hands.items() if hand.bodies}
    if not given:
        return urdf, {}
    root, made = parse_xml("urdf", urdf.text), dict[str, str]()
    for name, hand in given.items():
        for k, body in enumerate(hand.bodies):
            if body in hand.bodies[:k]:
                raise InvalidInput(f"hands.{name}.bodies[{k}]", body, "a body that is not there already")
        made[name] = _free(f"{name}_hand_bodies", (*urdf.links, *made.values()))
        _add_link(root, made[name], hand.bodies)
        joint = SubElement(root, "joint", name=_free(f"{made[name]}_mount", urdf.joints), type="fixed")
        SubElement(joint, "parent", link=link_of(urdf, hand.frame))
        SubElement(joint, "child", link=made[name])
    return read_urdf(ElementTree.tostring(root, encoding="unicode")), made


def _free(name: str, taken: Iterable[str]) -> str:
    while name in taken:
        name += "_"
    return name


def _add_link(root: Element, name: str, bodies: Iterable[BodyEntry]) -> None:
    link, capsules = SubElement(root, "link", name=name), []
    for k, body in enumerate(bodies):
        visual, collision = SubElement(link, "visual"), SubElement(link, "collision", name=f"{name}_{k}")
        for element in (visual, collision):
            rpy = body.rpy if isinstance(body, BoxEntry | CapsuleEntry) else (0.0, 0.0, 0.0)
            SubElement(element, "origin", xyz=_text(body.center), rpy=_text(rpy))
            _add_shape(SubElement(element, "geometry"), body)
        material = SubElement(visual, "material", name=f"{name}_colour")
        SubElement(material, "color", rgba=COLOUR)
        if isinstance(body, CapsuleEntry):
            capsules.append(f"{name}_{k}")
    if capsules:
        checking = SubElement(link, "collision_checking")
        for capsule in capsules:
            SubElement(checking, "capsule", name=capsule)


def _add_shape(geometry: Element, body: BodyEntry) -> None:
    match body:
        case BoxEntry():
            SubElement(geometry, "box", size=_text(body.size))
        case CapsuleEntry():  # as a cylinder, which every tool reads; `collision_checking` adds the half spheres
            SubElement(geometry, "cylinder", radius=repr(body.radius), length=repr(body.length))
        case _:
            SubElement(geometry, "sphere", radius=repr(body.radius))


def _text(values: Iterable[float]) -> str:
    return " ".join(repr(float(x)) for x in values)
