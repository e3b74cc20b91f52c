"""Loads any robot: what its files say, what is found by itself, and what had to be assumed."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from importlib import metadata
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from humanoid_rail.errors import MISSING, InvalidInput, did_you_mean
from humanoid_rail.geometry.mesh_names import find_mesh
from humanoid_rail.model.building import Mechanism, build_robot, check_hands, checked_start, read_mechanism
from humanoid_rail.model.examination import examine
from humanoid_rail.model.hand_shape import AHEAD, HandShape, hand_shape
from humanoid_rail.model.hands import TOOL, FoundHand, arm_of, find_hands, moving_before
from humanoid_rail.model.pairs import choose_pairs
from humanoid_rail.model.postures import configuration, named_postures, starts
from humanoid_rail.model.robot import Hand, Robot
from humanoid_rail.model.robot_file import RobotFile
from humanoid_rail.model.sources import SUFFIXES, Source, find_source, package_root
from humanoid_rail.model.urdf import Urdf, read_urdf
from humanoid_rail.model.urdf_changes import Changes, changed_urdf, resting_place
from humanoid_rail.model.urdf_elements import parse_xml
from humanoid_rail.model.urdf_link import MeshFile

_PACKAGE = re.compile(r"([\w.-]+?)\s*(?:(==|>=|~=)\s*([\w.]+))?")


def robot_of(file: RobotFile, folder: Path) -> Robot:
    """Return the robot that a robot file describes.

    Args:
        file: The robot file.
        folder: Where it is: relative names begin there.

    Raises:
        InvalidInput: If a file that is named is not there or cannot be read, or something does not go together.
    """
    source, assumed = _source(file, folder)
    original = read_urdf(source.urdf)
    srdf = parse_xml("srdf", source.srdf) if source.srdf is not None else None
    entries = _hands(file, original, srdf)
    locked = _locked(file, original, [entry.frame for entry in entries])
    text, more = changed_urdf(original, _changes(file, original, locked))
    mechanism = read_mechanism(text)
    if not mechanism.joint_names:
        raise InvalidInput("joints", MISSING, "at least one joint that moves")
    meshes, joints = _meshes(mechanism.urdf, source), mechanism.joint_names
    postures = named_postures(joints, list(original.joints), srdf, file)
    places = list(starts(joints, mechanism.limits.lower, mechanism.limits.upper, postures, file))
    examined = examine(mechanism, srdf, file, meshes, places)
    start = checked_start(mechanism, examined.start)
    bodies = examined.bodies
    hands, said = _hands_by_shape(entries, mechanism, bodies, original, file)
    pairs = choose_pairs(mechanism.model, bodies, examined.pairs.left_out, mechanism.full_configuration(start))
    robot = build_robot(
        mechanism,
        text,
        bodies,
        pairs,
        hands,
        start,
        pair_distances=_distances(mechanism, bodies, pairs.checked, examined.pairs.distances),
        meshes=meshes,
        postures={name: configuration(joints, start, posture) for name, posture in postures.items()},
        locked={**file.locked_already, **locked},
        assumed=(
            *file.assumed,
            *source.found,
            *assumed,
            *said,
            *more,
            *_resting(file, original, locked),
            *examined.found,
        ),
    )
    _warn_of_links(robot, mechanism.urdf)
    return robot


def _source(file: RobotFile, folder: Path) -> tuple[Source, tuple[str, ...]]:
    """Return the texts that a robot file names, and what was assumed."""
    root, places = folder, [folder / place for place in file.packages]
    assumed: tuple[str, ...] = ()
    if file.package is not None:
        match = _PACKAGE.fullmatch(file.package.strip())
        if match is None:
            raise InvalidInput("package", file.package, "the name of a Python package, such as example-robot-data>=5")
        name, how, wanted = match.groups()
        root = package_root(name)
        there = metadata.version(name)
        if how == "==" and there != wanted:
            assumed = (f"{name} {there} stands for the {wanted} that is asked for.",)
            warnings.warn(assumed[0], stacklevel=2)
    urdf, srdf = (_path_or_text(text, root) for text in (file.urdf, file.srdf))
    assert urdf is not None
    return find_source(urdf, srdf, places, file.xacro), assumed


def _path_or_text(said: str | None, root: Path) -> str | Path | None:
    """Return a path, unless what a robot file says is a text or the name of a robot."""
    if said is None or "<" in said:
        return said
    is_file = (Path(said).suffix in (*SUFFIXES, ".srdf") and ":" not in said) or (root / said).is_file()
    return root / said if is_file else said


def _hands(file: RobotFile, urdf: Urdf, srdf: Element | None) -> tuple[FoundHand, ...]:
    """Return the hands that are given, or those that are found."""
    if file.hands is None:
        return find_hands(urdf, srdf)
    if not file.hands:
        raise InvalidInput("hands", MISSING, "at least one hand")
    for name, entry in file.hands.items():
        if entry.frame not in urdf.links and entry.frame not in urdf.joints:
            near = did_you_mean(entry.frame, [*urdf.links, *urdf.joints])
            raise InvalidInput(f"hands.{name}.frame", entry.frame, f"a link or joint of the URDF{near}")
    frames = [entry.frame for entry in file.hands.values()]
    return tuple(
        FoundHand(
            name,
            entry.frame,
            entry.arm or arm_of(urdf, entry.frame, [f for f in frames if f != entry.frame]),
            entry.pointing,
            "",
        )
        for name, entry in file.hands.items()
    )


def _pointing(hand: Hand, shape: HandShape) -> Iterator[str]:
    """Yield in which direction a hand was found to point, and why."""
    if hand.pointing is not None:
        along = " ".join(f"{x:g}" for x in hand.pointing)
        why = "as its fingers do" if shape.pointing else "by custom, as no fingers say otherwise"
        yield f"The hand {hand.name} points along {along} of {hand.frame}, {why}."


def _hands_by_shape(
    entries: Sequence[FoundHand], mechanism: Mechanism, bodies: pin.GeometryModel, original: Urdf, file: RobotFile
) -> tuple[list[Hand], list[str]]:
    """Return the hands, and what was found of them by their bodies."""
    hands, said = [], []
    check_hands(mechanism.model, mechanism.joint_names, [_hand(entry, mechanism) for entry in entries])
    for entry in entries:
        if entry.why:
            said.append(f"The hand {entry.name} is {entry.frame}, {entry.why}.")
        shape = hand_shape(mechanism, bodies, original, entry.frame)
        hand = _hand(entry, mechanism)
        if not file.as_written:
            if hand.pointing is None:
                hand = replace(hand, pointing=shape.pointing or ((0.0, 0.0, 1.0) if TOOL.search(hand.frame) else None))
                said += _pointing(hand, shape)
            if shape.ahead > AHEAD and shape.pointing == hand.pointing:
                said.append(f"The fingers of the hand {hand.name} end {shape.ahead:.2f} m in front of {hand.frame}.")
            if shape.around and entry.why:
                bodies_around = ", ".join(shape.around)
                said.append(
                    f"The point of the hand {hand.name}, {hand.frame}, is inside of the body of {bodies_around}."
                )
        hands.append(hand)
    return hands, said


def _hand(entry: FoundHand, mechanism: Mechanism) -> Hand:
    """Return a hand; of an arm that was found, the joints that move."""
    known = entry.arm if not entry.why else [name for name in entry.arm if name in mechanism.joint_names]
    return Hand(entry.name, entry.frame, tuple(known), entry.pointing)


def _locked(file: RobotFile, urdf: Urdf, frames: Sequence[str]) -> dict[str, float]:
    """Return where joints stand that do not move: all that no hand needs, unless others are named."""
    able = {joint.name for joint in urdf.joints.values() if joint.kind != "fixed"}
    for field, names in (("joints", file.joints or ()), ("locked_joints", file.locked_joints)):
        for name in names:
            if name not in able:
                valid = f"joints of the URDF that move{did_you_mean(name, sorted(able))}: {', '.join(sorted(able))}"
                raise InvalidInput(field, name, valid)
    needed = {joint for frame in frames for joint in moving_before(urdf, frame)}
    moving = set(file.joints) if file.joints is not None else needed
    moving -= {*file.locked, *file.locked_joints, *_without_range(urdf)}
    locked: dict[str, float] = {}

    def place(name: str) -> float | None:
        """Return where a joint stands; None if it moves."""
        joint = urdf.joints[name]
        if name in file.locked:
            return file.locked[name]
        if joint.mimic is not None:
            leader = place(joint.mimic.joint)
            return None if leader is None else joint.mimic.multiplier * leader + joint.mimic.offset
        return None if name in moving else resting_place(joint)

    for name, joint in urdf.joints.items():
        if joint.kind != "fixed" and (at := place(name)) is not None:
            locked[name] = at
    return locked


def _without_range(urdf: Urdf) -> list[str]:
    """Return the joints whose limits leave them no way to move."""
    kinds = ("revolute", "prismatic")
    return [j.name for j in urdf.joints.values() if j.kind in kinds and j.limit and j.limit.lower == j.limit.upper]


def _resting(file: RobotFile, urdf: Urdf, locked: Mapping[str, float]) -> Iterator[str]:
    """Yield what is said of joints that are locked without a position of their own."""
    held = [name for name in _without_range(urdf) if name in locked and name not in file.locked]
    if held:
        places = ", ".join(f"{name} at {locked[name]:.4g}" for name in held)
        yield f"These joints are locked, as their limits leave them no range: {places}."
    names = [name for name in locked if name not in file.locked and name not in held]
    if names:
        places = ", ".join(f"{name} at {locked[name]:.4g}" for name in names)
        yield f"These joints are locked, as no hand needs them: {places}."


def _changes(file: RobotFile, urdf: Urdf, locked: Mapping[str, float]) -> Changes:
    for name in file.locked:
        if name not in locked:
            raise InvalidInput("locked", name, f"a joint of the URDF that moves{did_you_mean(name, list(urdf.joints))}")
    base = pin.SE3(pin.rpy.rpyToMatrix(*file.base.rpy), np.array(file.base.xyz))
    return Changes(
        locked,
        file.limits,
        file.continuous_joints_within,
        file.acceleration_time,
        base,
        file.name,
        file.as_written,
    )


def _meshes(urdf: Urdf, source: Source) -> dict[str, Path]:
    """Return the files of all meshes; a visual one that is not there is warned of and left out.

    Raises:
        InvalidInput: If a collision mesh is not there.
    """
    found: dict[str, Path] = {}
    for link in urdf.links.values():
        for body in (*link.collisions, *link.visuals):
            if not isinstance(body.shape, MeshFile) or body.shape.filename in found:
                continue
            try:
                found[body.shape.filename] = find_mesh(
                    f"{body.where}.geometry.mesh.filename", body.shape.filename, source.folder, source.packages
                )
            except InvalidInput as error:
                if body in link.collisions:
                    raise
                warnings.warn(f"{error}; it is not shown", stacklevel=2)
    return found


def _distances(
    mechanism: Mechanism,
    bodies: pin.GeometryModel,
    checked: Sequence[tuple[int, int]],
    distances: Mapping[frozenset[str], float],
) -> dict[tuple[int, int], float]:
    """Return the distances of pairs of links as those of pairs of bodies."""
    links = [mechanism.model.frames[body.parentFrame].name for body in bodies.geometryObjects]
    found = {(i, j): distances.get(frozenset((links[i], links[j]))) for i, j in checked}
    return {pair: distance for pair, distance in found.items() if distance is not None}


def _warn_of_links(robot: Robot, urdf: Urdf) -> None:
    """Warn of links that are seen and have no body, as nothing is known of what they touch."""
    bodied = set(robot.link_names)
    if bare := [name for name, link in urdf.links.items() if link.visuals and name not in bodied]:
        warnings.warn(f"no collision body: {', '.join(bare)}; nothing is known of what they touch", stacklevel=2)
    for hand in robot.hands:
        joint = robot.model.frames[robot.model.getFrameId(hand.frame)].parentJoint
        if all(body.parentJoint != joint for body in robot.collision_model.geometryObjects):
            warnings.warn(
                f"the hand {hand.name} has no collision body: nothing on its last joint has one", stacklevel=2
            )
