"""Loads any robot: what its files say, what is found by itself, and what had to be assumed."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin
from packaging.requirements import InvalidRequirement, Requirement

from humanoid_rail.errors import MISSING, InvalidInput, did_you_mean
from humanoid_rail.geometry.mesh_names import find_mesh
from humanoid_rail.model.added_bodies import with_hand_bodies
from humanoid_rail.model.building import Mechanism, build_robot, check_hands, checked_start, read_mechanism
from humanoid_rail.model.examination import examine
from humanoid_rail.model.hand_links import mounted_links
from humanoid_rail.model.hand_shape import hands_by_shape
from humanoid_rail.model.hands import FoundHand, arm_of, find_hands, moving_before, with_leaders
from humanoid_rail.model.pairs import choose_pairs
from humanoid_rail.model.postures import MovingJoints, named_postures, starts
from humanoid_rail.model.robot import Hand, Robot, called
from humanoid_rail.model.robot_file import FULL_TURN, RobotFile
from humanoid_rail.model.sources import SUFFIXES, Source, find_source, is_there, package_root
from humanoid_rail.model.srdf_checks import read_srdf
from humanoid_rail.model.urdf import Urdf, read_urdf
from humanoid_rail.model.urdf_changes import Changes, changed_urdf, resting_place
from humanoid_rail.model.urdf_joint import Joint
from humanoid_rail.model.urdf_link import MeshFile


def robot_of(file: RobotFile, folder: Path) -> Robot:
    """Return the robot that a robot file describes.

    Args:
        file: The robot file.
        folder: Where it is: relative names begin there.

    Raises:
        InvalidInput: If a file that is named is not there or cannot be read, or something does not go together.
    """
    source = _source(file, folder)
    written = read_urdf(source.urdf)
    srdf = None if source.srdf is None else read_srdf(source.srdf, written, file.pairs.complete)
    entries = _hands(file, written, srdf)
    original, made = with_hand_bodies(written, file.hands or {})
    locked = _locked(file, original, [entry.frame for entry in entries])
    text, more = changed_urdf(original, _changes(file, original, locked))
    mechanism = read_mechanism(text)
    if not mechanism.joint_names:
        raise InvalidInput("joints", MISSING, "at least one joint that moves")
    meshes = _meshes(mechanism.urdf, source)
    joints = MovingJoints(mechanism.joint_names, mechanism.limits.lower, mechanism.limits.upper)
    postures = named_postures(joints, list(original.joints), srdf, file)
    places = list(starts(joints, postures, file))
    examined = examine(mechanism, srdf, file, meshes, places)
    start = checked_start(mechanism, examined.start)
    bodies = examined.bodies
    hands = [_hand(entry, mechanism, made, [other.frame for other in entries]) for entry in entries]
    check_hands(mechanism.model, mechanism.joint_names, hands)
    hands, said = hands_by_shape(hands, [entry.why for entry in entries], mechanism, bodies, original, file.as_written)
    pairs = choose_pairs(mechanism.model, bodies, examined.pairs.left_out, mechanism.full_configuration(start))
    robot = build_robot(
        mechanism,
        text,
        bodies,
        pairs,
        hands,
        start,
        pair_distances={pair: apart for pair, apart in examined.pairs.distances.items() if pair in pairs.checked},
        meshes=meshes,
        postures={name: tuple(joints.filled(start, posture).tolist()) for name, posture in postures.able.items()},
        locked={**file.locked_already, **locked},
        assumed=(
            *file.assumed,
            *source.found,
            *said,
            *more,
            *_resting(file, original, locked),
            *(
                f"The posture {name} is left out, as the robot cannot have it: {why}."
                for name, why in postures.unable.items()
            ),
            *examined.found,
        ),
    )
    _warn_of_links(robot, mechanism.urdf)
    return robot


def _source(file: RobotFile, folder: Path) -> Source:
    """Return the texts that a robot file names."""
    root = folder if file.package is None else _package(file.package)
    urdf, srdf = (_path_or_text(text, root) for text in (file.urdf, file.srdf))
    assert urdf is not None
    return find_source(urdf, srdf, [folder / place for place in file.packages], file.xacro)


def _package(wanted: str) -> Path:
    """Return where the models of a package are.

    Raises:
        InvalidInput: If it is not there, or in a version outside the range wanted. Another version than the one that is
            named by == is warned of: models seldom change, and the motion is proven for those that are there.
    """
    package: Requirement | None
    try:
        package = Requirement(wanted)
    except InvalidRequirement:
        package = None
    if package is None or package.url or package.extras or package.marker:
        raise InvalidInput("package", wanted, "the name of a Python package, such as example-robot-data>=5")
    root, there = package_root(package.name), metadata.version(package.name)
    if not package.specifier.contains(there, prereleases=True):
        if all(part.operator == "==" for part in package.specifier):
            warnings.warn(f"package is {wanted!r}; its models are those of {package.name} {there} here", stacklevel=2)
            return root
        raise InvalidInput("package", wanted, f"a version that is installed; there is {package.name} {there}")
    return root


def _path_or_text(said: str | None, root: Path) -> str | Path | None:
    """Return a path, unless what a robot file says is a text or the name of a robot."""
    if said is None or "<" in said:
        return said
    is_file = (Path(said).suffix in (*SUFFIXES, ".srdf") and ":" not in said) or is_there(root / said)
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
        for k, link in enumerate(entry.links or ()):
            if link not in urdf.links:
                near = did_you_mean(link, list(urdf.links))
                raise InvalidInput(f"hands.{name}.links[{k}]", link, f"a link of the URDF{near}")
    frames = [entry.frame for entry in file.hands.values()]
    return tuple(
        FoundHand(
            name,
            entry.frame,
            entry.arm or arm_of(urdf, entry.frame, [f for f in frames if f != entry.frame]),
            entry.pointing,
            "",
            is_arm_given=entry.arm is not None,
            links=entry.links,
        )
        for name, entry in file.hands.items()
    )


def _hand(entry: FoundHand, mechanism: Mechanism, made: Mapping[str, str], frames: Sequence[str]) -> Hand:
    """Return a hand.

    Args:
        entry: What is known of it.
        mechanism: How the joints move; of an arm that was found, only joints that move count.
        made: The links that were made of the bodies of hands, by hand.
        frames: The frames of all hands.
    """
    known = entry.arm if entry.is_arm_given else [name for name in entry.arm if name in mechanism.joint_names]
    links = entry.links
    if entry.name in made:
        own = mounted_links(mechanism.urdf, entry.frame, frames)[1]
        links = own if links is None else (*links, made[entry.name])
    return Hand(entry.name, entry.frame, tuple(known), entry.pointing, links)


def _locked(file: RobotFile, urdf: Urdf, frames: Sequence[str]) -> dict[str, float]:
    """Return where joints stand that do not move: all that no hand needs, unless others are named."""
    able = {joint.name for joint in urdf.joints.values() if joint.kind != "fixed"}
    for field, names in (("joints", file.joints or ()), ("locked_joints", file.locked_joints)):
        for name in names:
            if name not in able:
                valid = f"joints of the URDF that move{did_you_mean(name, sorted(able))}: {', '.join(sorted(able))}"
                raise InvalidInput(field, name, valid)
    for name in (file.joints or ()) if file.locked or file.locked_joints else ():
        if name in file.locked or name in file.locked_joints:
            raise InvalidInput("joints", name, "joints that move; this one is locked, too")
    if file.joints is not None:
        moving = {joint for name in file.joints for joint in with_leaders(urdf, name)}
    else:
        moving = {joint for frame in frames for joint in moving_before(urdf, frame)}
    moving -= {*file.locked, *file.locked_joints, *_without_range(urdf)}
    locked: dict[str, float] = {}

    def place(name: str) -> float | None:
        """Return where a joint stands; None if it moves."""
        joint = urdf.joints[name]
        if name in file.locked:
            return _checked_place(joint, file.locked[name])
        if joint.mimic is not None:
            if (leader := place(joint.mimic.joint)) is not None:
                return joint.mimic.multiplier * leader + joint.mimic.offset
            return resting_place(joint, file.limits.get(name)) if name in file.locked_joints else None
        return None if name in moving else resting_place(joint, file.limits.get(name))

    for name, joint in urdf.joints.items():
        if joint.kind != "fixed" and (at := place(name)) is not None:
            locked[name] = at
    return locked


def _without_range(urdf: Urdf) -> list[str]:
    """Return the joints whose limits leave them no way to move."""
    kinds = ("revolute", "prismatic")
    return [j.name for j in urdf.joints.values() if j.kind in kinds and j.limit and j.limit.lower == j.limit.upper]


def _checked_place(joint: Joint, place: float) -> float:
    """Return where a joint is locked, m or rad.

    Raises:
        InvalidInput: If it is an angle beyond a full turn, where none is needed.
    """
    if joint.kind != "prismatic" and abs(place) > FULL_TURN:
        valid = f"rad, within a full turn of 0; {place:g} degrees would be {np.radians(place):.6g}"
        raise InvalidInput(f"locked.{joint.name}", place, valid)
    return place


def _resting(file: RobotFile, urdf: Urdf, locked: Mapping[str, float]) -> Iterator[str]:
    """Yield what is said of joints that are locked without a position of their own."""
    others = "no hand needs them" if file.joints is None else "they are not among those that are to move"
    own = [name for name in locked if name not in file.locked]
    asked = [name for name in own if name in file.locked_joints]
    held = [name for name in own if name in _without_range(urdf) and name not in asked]
    rest = [name for name in own if name not in asked and name not in held]
    for names, why in ((asked, "as asked for"), (held, "as their limits leave them no range"), (rest, f"as {others}")):
        if names:
            places = ", ".join(f"{name} at {locked[name]:.4g}" for name in names)
            yield f"These joints are locked, {why}: {places}."


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


def _warn_of_links(robot: Robot, urdf: Urdf) -> None:
    """Warn of links that are seen and have no body, as nothing is known of what they touch."""
    bodied = set(robot.link_names)
    if bare := [name for name, link in urdf.links.items() if link.visuals and name not in bodied]:
        warnings.warn(f"no collision body: {', '.join(bare)}; nothing is known of what they touch", stacklevel=2)
    for hand in robot.hands:
        joint = robot.model.frames[robot.model.getFrameId(hand.frame)].parentJoint
        if all(body.parentJoint != joint for body in robot.collision_model.geometryObjects):
            warnings.warn(f"{called(hand.name)} has no collision body: nothing on its last joint has one", stacklevel=2)
