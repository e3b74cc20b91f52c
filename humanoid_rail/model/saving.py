"""Saves a robot as a folder that loads anywhere: a robot file, a URDF, an SRDF and meshes."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from itertools import combinations
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import coal

from humanoid_rail._files import write_files
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.pairs import reason_of
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.robot_file import NAME
from humanoid_rail.model.saved_meshes import SavedMeshes
from humanoid_rail.model.urdf import read_urdf
from humanoid_rail.model.urdf_elements import parse_xml
from humanoid_rail.model.urdf_link import Link, MeshFile

_HEAD = """\
# A robot as humanoid_rail saved it: load_robot(FOLDER) finds nothing anew. Metres, radians and seconds.
# Its URDF has convex bodies for collision meshes, and limits, locked joints and base as they were chosen.
"""


def save_robot(robot: Robot, folder: str | Path) -> tuple[Path, ...]:
    """Write a robot to a folder; :meth:`Robot.save` describes it."""
    return write_files(folder, robot_files(robot))


def robot_files(robot: Robot) -> dict[str, bytes]:
    """Return what is in the folder of a robot, by the names of the files in it.

    Raises:
        InvalidInput: If a mesh file is gone, or the robot has other bodies or pairs than its URDF and the links that
            are left out say.
    """
    stem = re.sub(r"[^\w.-]", "_", robot.name) or "robot"
    left_out = {frozenset((pair.link, pair.other)): reason_of(pair) for pair in robot.unchecked_pairs}
    _check_pairs(robot, left_out)
    meshes = SavedMeshes(robot)
    urdf = _urdf(robot, meshes)
    files = {NAME: _robot_file(robot, f"{stem}.urdf", left_out), f"{stem}.urdf": urdf, **meshes.files}
    if left_out:
        files[f"{stem}.srdf"] = _srdf(robot.name, left_out)
    return files


def _urdf(robot: Robot, meshes: SavedMeshes) -> bytes:
    """Return the URDF with the names of the meshes that are saved."""
    root, links = parse_xml("urdf", robot.urdf), read_urdf(robot.urdf).links
    bodies = _bodies(robot, links)
    for element in root.findall("link"):
        link = links[element.get("name", "")]
        for visual, body in zip(element.findall("visual"), link.visuals, strict=True):
            if isinstance(body.shape, MeshFile) and body.shape.filename in robot.meshes:
                _mesh(visual).set("filename", meshes.visual(body.where, body.shape.filename))
        for i, collision in enumerate(element.findall("collision")):
            if isinstance(link.collisions[i].shape, MeshFile):
                _cut(
                    element,
                    collision,
                    [meshes.piece(robot.collision_model.geometryObjects[k]) for k in bodies[link.name, i]],
                )
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))


def _bodies(robot: Robot, links: Mapping[str, Link]) -> dict[tuple[str, int], list[int]]:
    """Return the bodies of each `<collision>`, by its link and its number there.

    Raises:
        InvalidInput: If there are others than the URDF says.
    """
    found: dict[tuple[str, int], list[int]] = {
        (name, i): [] for name, link in links.items() for i in range(len(link.collisions))
    }
    for index, (body, link) in enumerate(zip(robot.collision_model.geometryObjects, robot.link_names, strict=True)):
        number, _, parts = body.name.removeprefix(f"{link}_").partition(" ")
        if parts:  # a far part, which is made when the robot is loaded
            continue
        number = number.partition(".")[0]
        key = (link, int(number) if number.isdecimal() else -1)
        shape = links[link].collisions[key[1]].shape if key in found else None
        if shape is None or not (isinstance(shape, MeshFile) or _size(shape) == _size(body.geometry)):
            raise InvalidInput("robot.collision_model", body.name, "the bodies that the robot was loaded with")
        found[key].append(index)
    for (link, i), indices in found.items():
        if not indices:
            raise InvalidInput(
                "robot.collision_model", f"{link}_{i} missing", "the bodies that the robot was loaded with"
            )
    return found


def _size(shape: coal.ShapeBase) -> tuple[object, ...]:
    """Return kind and size of a primitive shape."""
    half = shape.halfSide.tolist() if isinstance(shape, coal.Box) else getattr(shape, "halfLength", None)
    return type(shape), getattr(shape, "radius", None), half


def _cut(link: Element, collision: Element, names: list[str]) -> None:
    """Put a `<collision>` for each piece in the place of one."""
    place = list(link).index(collision)
    for k, name in enumerate(names):
        one = ElementTree.fromstring(ElementTree.tostring(collision))
        if k > 0 and "name" in one.attrib:
            del one.attrib["name"]
        mesh = _mesh(one)
        mesh.attrib.clear()
        mesh.set("filename", name)
        link.insert(place + k, one)
    link.remove(collision)


def _mesh(body: Element) -> Element:
    found = body.find("geometry/mesh")
    assert found is not None
    return found


def _robot_file(robot: Robot, urdf: str, left_out: Mapping[frozenset[str], str]) -> bytes:
    from ruamel.yaml import YAML

    def positions(q: Any) -> dict[str, float]:
        return dict(zip(robot.joint_names, map(float, q), strict=True))

    links = robot.link_names
    numbers = [links[:i].count(link) for i, link in enumerate(links)]
    data: dict[str, Any] = {
        "name": robot.name,
        "urdf": urdf,
        "as_written": True,
        "hands": {
            hand.name: {
                "frame": hand.frame,
                "arm": list(hand.arm),
                "pointing": None if hand.pointing is None else list(map(float, hand.pointing)),
                **({} if hand.links is None else {"links": list(hand.links)}),
            }
            for hand in robot.hands
        },
        "joints": list(robot.joint_names),
        "initial": positions(robot.initial),
        "postures": {name: positions(q) for name, q in robot.postures.items()},
        "locked_already": {name: float(x) for name, x in robot.locked.items()},
        "decomposed": [],
        "pairs": {
            "complete": True,
            "left_out": [{"links": sorted(pair), "why": why} for pair, why in left_out.items()],
            "distances": [
                {"links": [links[i], links[j]], "bodies": [numbers[i], numbers[j]], "distance": float(d)}
                for (i, j), d in robot.pair_distances.items()
            ],
        },
        "assumed": list(robot.assumed),
    }
    yaml: Any
    yaml, text = YAML(typ="safe", pure=True), io.StringIO()
    yaml.default_flow_style, yaml.sort_base_mapping_type_on_output, yaml.width = None, False, 120
    yaml.allow_unicode = True
    yaml.dump(data, text)
    return (_HEAD + text.getvalue()).encode()


def _srdf(name: str, left_out: Mapping[frozenset[str], str]) -> bytes:
    root = Element("robot", name=name)
    for pair, why in left_out.items():
        link, other = sorted(pair)
        SubElement(root, "disable_collisions", link1=link, link2=other, reason=why)
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def _check_pairs(robot: Robot, left_out: Mapping[frozenset[str], str]) -> None:
    """Check that all pairs of bodies are checked whose links are not left out.

    Raises:
        InvalidInput: If not.
    """
    links, bodies = robot.link_names, robot.collision_model.geometryObjects
    whole = [i for i, body in enumerate(bodies) if " " not in body.name.removeprefix(f"{links[i]}_")]
    every = {(i, j) for i, j in combinations(whole, 2) if links[i] != links[j]}
    wanted = {(i, j) for i, j in every if frozenset((links[i], links[j])) not in left_out}
    if wanted != every & {(min(pair), max(pair)) for pair in robot.self_collision_pairs}:
        valid = "all pairs of bodies, but those of links that are left out; others cannot be saved"
        raise InvalidInput("robot.self_collision_pairs", robot.self_collision_pairs, valid)
