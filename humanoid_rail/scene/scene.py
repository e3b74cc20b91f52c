"""Scenes: where a motion starts, what it has to reach and what is in the way; the file format and its checks."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, Field, ValidationError, field_validator, model_validator

from humanoid_rail._arrays import Array, frozen
from humanoid_rail._resources import resource
from humanoid_rail._validation import Frozen, invalid_input, plain
from humanoid_rail._yaml import parse_yaml
from humanoid_rail.errors import MISSING, InvalidInput, did_you_mean
from humanoid_rail.model.position_limits import within_position_limits
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.robot_file import Start
from humanoid_rail.scene.frames import in_base
from humanoid_rail.scene.groups import SceneObstacles
from humanoid_rail.scene.joint_targets import check_joint_targets
from humanoid_rail.scene.keep import check_keep
from humanoid_rail.scene.objects import check_holding, check_objects, check_straight, held_targets
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.scene.robot_of_scene import SceneRobot, load_named_robot
from humanoid_rail.scene.targets import AnyOf, Step, Targets, alternatives, position

MOST_COMBINATIONS = 64
"""The alternatives of the hands may be combined in so many ways in a step."""
OWN = "scenes"
"""The scenes that come with the package are in a folder of this name."""


class Scene(Frozen):
    """A planning problem. Metres and radians, in the base frame.

    Raises:
        InvalidInput: If a field is not valid.
    """

    name: Annotated[str, Field(min_length=1, max_length=200)] = "scene"
    """What the scene is called; by default that of its file."""
    robot: SceneRobot | None = None
    """The robot it is for: a name, a path relative to the scene file, or the fields of a robot file; the paper's if not
    given. In Python :func:`load_robot_of_scene` loads it."""
    initial: Start | None = None
    """The start, m and rad: one number for each actuated joint (n,), the name of a posture of the robot, or positions
    by joint, where the others stand at the robot's own start, as all do if it is not given."""
    targets: Targets
    """What each hand has to reach, by the hand's name: a point [x, y, z], a :class:`Pose`, or None for a hand that may
    stay wherever is convenient; and where joints have to be, as `joints` by their names, or as the name of a `posture`.
    Or a list of these, to be reached one after the other."""
    obstacles: SceneObstacles = ()
    """What the links have to keep clear of. Groups and shelves are what they are made of once the scene is made."""
    objects: Annotated[tuple[Obstacle, ...], BeforeValidator(plain)] = ()
    """What hands can grasp: shapes with a name each. Where they stand the links keep clear of them, but for the hand
    that grasps one."""
    expect: Any = None
    """A remark: what should come of it. Planning takes no notice."""
    checked: Any = None
    """A remark: how that is known. Planning takes no notice."""

    @field_validator("objects")
    @classmethod
    def _can_be_held(cls, objects: tuple[Obstacle, ...]) -> tuple[Obstacle, ...]:
        check_objects(objects)
        return objects

    @property
    def steps(self) -> tuple[Step, ...]:
        """The targets, as those of one step after the other, all in the base frame."""
        given = self.targets if isinstance(self.targets, tuple) else (self.targets,)
        shapes = (*self.obstacles, *self.objects)
        return tuple(in_base(step, shapes, field_of_step(self, number)) for number, step in enumerate(given))

    @model_validator(mode="after")
    def _knows_frames(self) -> Self:
        """Check that the targets are in frames of the scene."""
        assert self.steps
        return self


def load_scene(path: str | Path) -> Scene:
    """Return the scene in a YAML (or JSON, which is YAML) file.

    Where there is no such file, `scenes/picks.yaml` and its like are those that come with the package.

    Raises:
        InvalidInput: If the file is missing, is not YAML or is not a scene; the error names the field.
    """
    path = _with_own(Path(path))
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InvalidInput("scene", str(path), "an existing file") from None
    except (OSError, ValueError) as error:
        raise InvalidInput("scene", str(path), f"a readable UTF-8 text file ({error})") from None
    data = parse_yaml("scene", text, str(path))
    if isinstance(data, dict):
        # Where file names are taken for ASCII, Python has other characters of them as half a surrogate pair each.
        stem = os.fsencode(path.stem).decode("utf-8", errors="replace")
        data.setdefault("name", stem or "scene")
    return make_scene(data, folder=path.parent, source=str(path))


def _with_own(path: Path) -> Path:
    """Return a path, or that of the scene of the package which it names where there is no such file."""
    if path.parts[:1] == (OWN,) and not path.exists():
        with suppress(FileNotFoundError):
            return resource(OWN, str(Path(*path.parts[1:])))
    return path


def make_scene(data: object, folder: str | Path | None = None, source: str | None = None) -> Scene:
    """Return a scene from plain data, as a scene file holds it.

    Args:
        data: Mapping with the keys of :class:`Scene`.
        folder: Folder that mesh files are relative to; the working directory if not given.
        source: Name for error messages.

    Raises:
        InvalidInput: If the data are not a scene; the error names the first field that is not valid.
    """
    if not isinstance(data, Mapping):
        raise InvalidInput("scene", data, f"a mapping with the keys {', '.join(Scene.model_fields)}", source)
    try:
        return Scene.model_validate(dict(data), context={"folder": Path(folder) if folder else Path.cwd()})
    except ValidationError as error:
        raise invalid_input(error, source) from None


def load_robot_of_scene(scene: Scene) -> Robot:
    """Return the robot that a scene names; the paper's if it names none.

    Raises:
        InvalidInput: If there is no such robot, or it cannot be loaded.
    """
    try:
        return load_named_robot(scene.robot)
    except InvalidInput as error:
        error.source = error.source or f"the robot of the scene {scene.name}"
        raise


def start_of_scene(robot: Robot, scene: Scene) -> Array:
    """Return the configuration (n,) at which a scene starts, m and rad.

    Raises:
        InvalidInput: If it names a posture or a joint that the robot does not have, or has the wrong size.
    """
    match scene.initial:
        case None:
            return robot.initial
        case str(posture):
            if posture not in robot.postures:
                known = ", ".join(robot.postures) or "none"
                valid = f"a posture of the robot{did_you_mean(posture, robot.postures)}; there are: {known}"
                raise InvalidInput("initial", posture, valid)
            return frozen(robot.postures[posture])
        case Mapping() as positions:
            for name in positions:
                if name not in robot.joint_names:
                    near = did_you_mean(name, robot.joint_names)
                    valid = f"a joint that moves{near}; there are: {_list(robot.joint_names)}"
                    raise InvalidInput(f"initial.{name}", positions[name], valid)
            own = zip(robot.joint_names, robot.initial.tolist(), strict=True)
            return frozen([positions.get(name, x) for name, x in own])
        case numbers:
            if len(numbers) != robot.n:
                valid = f"{robot.n} numbers, for {_list(robot.joint_names)}; there are {len(numbers)}"
                raise InvalidInput("initial", list(numbers), valid)
            return frozen(numbers)


def check_scene(robot: Robot, scene: Scene) -> None:
    """Check that a scene is one for this robot: targets for its hands, a start of the right size within the limits.

    Raises:
        InvalidInput: If it is not.
    """
    known = (*robot.hand_names, *(str(one.name) for one in scene.objects))
    for number, step in enumerate(scene.steps):
        where = field_of_step(scene, number)
        for hand, target in step.items():
            if hand not in known:
                valid = f"a target for {_list(robot.hand_names)}, the hands of the robot"
                valid += ", or for an object of the scene" if scene.objects else ""
                valid += did_you_mean(hand, known)
                raise InvalidInput(f"{where}.{hand}", target, valid)
            points = [(0.0, 0.0, 0.0) if one is None else position(one) for one in alternatives(target)]
            if not all(len(point) == 3 and all(math.isfinite(x) for x in point) for point in points):
                raise InvalidInput(f"{where}.{hand}", target, "three finite numbers")
            check_straight(robot, f"{where}.{hand}", target)
            if isinstance(target, AnyOf) and hand not in robot.hand_names:
                raise InvalidInput(f"{where}.{hand}", target, "one target: any_of is for hands, not for objects")
        _check_combinations(step, where)
        holding = {hand for hands in held_targets(scene.steps, number).values() for hand in hands}
        for hand in robot.hand_names:
            if hand not in step and hand not in holding and not step.has_joints:
                valid = f"a target [x, y, z] for each of {_list(robot.hand_names)}, null for a hand that has none"
                raise InvalidInput(f"{where}.{hand}", MISSING, valid)
        check_keep(robot.hand_names, step.keep, where)
        check_joint_targets(robot, step, where)
        if all(target is None for target in step.values()) and not step.has_joints:
            raise InvalidInput(where, step, "a target for one hand at least, or for joints")
    fields = [field_of_step(scene, number) for number in range(len(scene.steps))]
    check_holding(robot, scene.objects, scene.obstacles, scene.steps, fields)
    within_position_limits(robot, start_of_scene(robot, scene), "initial")


def _check_combinations(step: Step, where: str) -> None:
    """Check that there are not too many combinations of the hands' alternatives.

    Raises:
        InvalidInput: If there are.
    """
    sizes = {hand: len(target.any_of) for hand, target in step.items() if isinstance(target, AnyOf)}
    if (count := math.prod(sizes.values())) > MOST_COMBINATIONS:
        said = " times ".join(f"{size} for {hand}" for hand, size in sizes.items())
        valid = f"at most {MOST_COMBINATIONS} combinations of alternatives, not {count}: {said}"
        raise InvalidInput(where, list(sizes), valid)


def field_of_step(scene: Scene, number: int) -> str:
    """Return the path of a step in its scene, as errors name it."""
    return f"targets[{number}]" if isinstance(scene.targets, tuple) else "targets"


def target_points(robot: Robot, scene: Scene) -> Array:
    """Return the targets x_f (h, 3) in m of a scene that has one point for each hand.

    Raises:
        InvalidInput: If the scene asks for something else; not every method knows what to do then.
    """
    (step, *others) = scene.steps
    points = [step.get(name) for name in robot.hand_names]
    if others or step.has_joints or not all(isinstance(point, tuple) for point in points):
        raise InvalidInput("targets", scene.targets, "one point [x, y, z] for each hand, for this method")
    return np.array(points, float)


def is_of_a_scene(error: InvalidInput) -> bool:
    """Return whether an error is about a field of a scene, and not about another argument."""
    return error.field.split(".")[0].split("[")[0] in Scene.model_fields


def _list(names: tuple[str, ...]) -> str:
    return ", ".join(names)
