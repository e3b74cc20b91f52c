"""The moves of a motion: what its steps say, one rest after the other.

A step is one move to its targets. Where a target has a straight approach, it is a move to where that begins and a
straight one; a retreat is another straight move, after hands have grasped and released what the step says.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest

import numpy as np

from humanoid_rail._arrays import triple
from humanoid_rail.errors import InvalidInput
from humanoid_rail.events import EventKind
from humanoid_rail.scene.objects import by_object, held_after
from humanoid_rail.scene.obstacles import name_of
from humanoid_rail.scene.scene import Scene, field_of_step
from humanoid_rail.scene.targets import Line, Pose, Step, Straight, Target, position

WHY_REST = "objects are grasped or released there, or a hand moves straight to them or from them"
"""Why a motion rests at targets where it should not."""


@dataclass(frozen=True)
class Happening:
    """An event that is to be: where and when is known once the motion to it is planned."""

    kind: EventKind
    object: str
    hands: tuple[str, ...]
    contacts: tuple[str, ...] = ()
    """What the object may touch from then on, by name; what it stands on comes to that where it is grasped."""


@dataclass(frozen=True)
class Move:
    """A part of a motion, from rest to rest, or to and from targets that are passed without stopping."""

    step: int
    """The step of the scene that it belongs to, from 0."""
    targets: Step
    """What the hands have to reach."""
    straight: tuple[str, ...] = ()
    """The hands that move straight to their targets."""
    turned: tuple[str, ...] = ()
    """Those of them that keep their orientation meanwhile, whatever their targets ask for."""
    begins: tuple[Happening, ...] = ()
    """What happens before it."""
    ends: tuple[Happening, ...] = ()
    """What happens after it."""
    arrives: bool = True
    """Whether the targets of the step are reached at its end."""
    said: str = ""
    """What messages call it, such as `step 2 of 3, the retreat`."""
    choices: tuple[Step, ...] = ()
    """What the hands have to reach with each combination of their alternatives, if they have some. The first is that of
    `targets`."""
    stated: Step | None = None
    """The step as it is stated, with the alternatives, if there are some."""
    passes: bool = False
    """Whether the motion goes on to the next move without a rest."""

    @property
    def has_to_rest(self) -> bool:
        """Whether it rests at targets of a step that asks to pass them."""
        return self.arrives and not self.targets.stop and not self.passes


def moves_of(scene: Scene) -> tuple[Move, ...]:
    """Return the moves of a scene whose steps were checked."""
    found, held, touching = list[Move](), dict[str, tuple[str, ...]](), dict[str, tuple[str, ...]]()
    for number, step in enumerate(scene.steps):
        combinations = [_moves_of_step(scene, number, one, held, touching) for one in step.combinations]
        found += _merged(field_of_step(scene, number), step, [moves for moves, _, _ in combinations])
        _, held, touching = combinations[0]
    return tuple(
        replace(move, said=f"step {move.step + 1} of {len(scene.steps)}{move.said}", passes=_passes(move, after))
        for move, after in zip_longest(found, found[1:])
    )


def _merged(where: str, step: Step, combinations: Sequence[Sequence[Move]]) -> Sequence[Move]:
    """Return the moves of a step whose hands have alternatives, from those with each combination.

    Raises:
        InvalidInput: If one alternative of a hand has a straight way and another has none.
    """
    first, *others = combinations
    for moves in others:
        if [(move.straight, move.said) for move in moves] != [(move.straight, move.said) for move in first]:
            raise InvalidInput(
                where, step, "alternatives that all have a straight approach or retreat, or none of them"
            )
    if not others:
        return first
    return [
        replace(moves[0], choices=tuple(move.targets for move in moves), stated=step)
        for moves in zip(*combinations, strict=True)
    ]


def _passes(move: Move, after: Move | None) -> bool:
    """Return whether a motion passes the targets of a move: if its step says so, and nothing happens there.

    A straight way begins and ends at rest.
    """
    if after is None or move.targets.stop or not move.arrives:
        return False
    return not (move.ends or after.begins or move.straight or after.straight)


def _moves_of_step(
    scene: Scene, number: int, step: Step, held: Mapping[str, tuple[str, ...]], touching: Mapping[str, tuple[str, ...]]
) -> tuple[list[Move], dict[str, tuple[str, ...]], dict[str, tuple[str, ...]]]:
    """Return the moves of a step, what is held after it, and what may touch something then, both by object."""
    grasps, releases = by_object(step.grasp), by_object(step.release)
    coming = [Happening(EventKind.APPROACH, name, hands, hands) for name, hands in grasps.items()]
    coming += [
        Happening(EventKind.APPROACH, name, held[name], obstacle_names(scene, step.contacts[name]))
        for name in step.contacts
        if name in held
    ]
    # What a step before had touch something is clear once the next move is made.
    clearing = [Happening(EventKind.CLEAR, name, hands) for name, hands in touching.items()]
    doing = [Happening(EventKind.RELEASE, name, hands, hands) for name, hands in releases.items()]
    doing += [
        Happening(EventKind.GRASP, name, hands, obstacle_names(scene, step.contacts.get(name, ())))
        for name, hands in grasps.items()
    ]
    left = {**{happening.object: happening.hands for happening in coming}, **releases, **grasps}
    moves = list[Move]()
    before = {name: _before(target) for name, target in step.items()}
    if any(before[name] not in (None, target) for name, target in step.items()):
        said = ", to where the approach begins"
        moves.append(Move(number, step.with_targets(before), ends=tuple(clearing), arrives=False, said=said))
        clearing = []
    moves.append(
        Move(
            number,
            step.with_targets({name: _end(target) for name, target in step.items()}),
            straight=tuple(name for name, target in step.items() if _is_straight(target)),
            turned=tuple(name for name, target in step.items() if isinstance(target, Line)),
            begins=tuple(coming),
            ends=(*clearing, *doing),
        )
    )
    away = {name: target for name, end in step.items() if (target := _after(end)) is not None}
    if away:
        cleared = tuple(Happening(EventKind.CLEAR, name, hands) for name, hands in left.items())
        there = step.with_targets({name: away.get(name) for name in step})
        moves.append(Move(number, there, tuple(away), ends=cleared, arrives=False, said=", the retreat"))
        left = {}
    return moves, held_after(step, held), left


def obstacle_names(scene: Scene, names: Sequence[str]) -> tuple[str, ...]:
    """Return names of obstacles and objects, obstacles as errors call them, with their numbers."""
    found = list[str]()
    for name in names:
        numbers = [i for i, obstacle in enumerate(scene.obstacles) if obstacle.name == name]
        found += [name_of(scene.obstacles, i) for i in numbers] or [name]
    return tuple(found)


def _is_straight(target: Target) -> bool:
    return isinstance(target, Line) or (isinstance(target, Pose) and isinstance(target.approach, Straight))


def _end(target: Target) -> Target:
    return target.end if isinstance(target, Line) else target


def _before(target: Target) -> Target:
    """Return where the straight approach to a target begins; the target itself if it has none."""
    match target:
        case Line(start=None):
            return None
        case Line():
            return target.start
        case Pose(approach=Straight() as approach):
            return target.model_copy(update={"position": _shifted(target, approach, -1.0)})
    return target


def _after(target: Target) -> Target:
    """Return where the straight retreat from a target ends; None if it has none."""
    if isinstance(target, Pose) and target.retreat is not None:
        return target.model_copy(update={"position": _shifted(target, target.retreat, 1.0)})
    return None


def _shifted(target: Pose, straight: Straight, sign: float) -> tuple[float, float, float]:
    along = np.array(straight.direction) / np.linalg.norm(straight.direction)
    return triple(np.array(position(target)) + sign * straight.distance * along)
