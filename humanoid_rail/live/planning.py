"""A plan for the world as it is: planned, timed and certified."""

from __future__ import annotations

import time
from dataclasses import dataclass

from humanoid_rail._arrays import Array
from humanoid_rail.errors import HumanoidRailError
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.methods import METHODS, Auto
from humanoid_rail.planning.planner import plan
from humanoid_rail.result import Status
from humanoid_rail.retiming.retiming import retime
from humanoid_rail.scene.scene import Scene
from humanoid_rail.trajectory import Trajectory

MAX_PLANNING_TIME = 10.0
"""`auto` gives up after this time, s: whoever drags something wants to go on."""


@dataclass(frozen=True, eq=False)
class Planned:
    """What came of a world."""

    trajectory: Trajectory | None
    """The plan; None where the world is not valid."""
    motion: Trajectory | None
    """The plan with a timing for drives; None where there is none."""
    seconds: float
    """How long planning, timing and certifying took, s."""
    error: str = ""
    """Why there is no plan or no timing."""

    @property
    def certified(self) -> bool:
        """Whether the motion that is shown reaches the targets and is certified."""
        return self.motion is not None and self.motion.status is Status.REACHED and self.motion.certified

    def described(self) -> str:
        """Return what came of it, in lines of Markdown."""
        if self.trajectory is None:
            return f"**not planned**: {plain(self.error)}"
        lines = [f"**{self.trajectory.status}**, {'certified' if self.certified else '**not certified**'}"]
        shown = self.motion or self.trajectory
        if (certificate := shown.certificate) is not None and certificate.clearance_bound is not None:
            lines.append(f"clearance at least {1000 * certificate.clearance_bound:.1f} mm")
        lines.append(f"{shown.duration:.2f} s of motion, {1000 * self.seconds:.0f} ms to plan, time and certify")
        if self.trajectory.status is not Status.REACHED:
            lines.append(plain(self.trajectory.reason))
        if self.error:
            lines.append(plain(self.error))
        return "\n\n".join(lines)


def plain(text: str) -> str:
    """Return a text so that Markdown shows it as it is, names of files and scenes included."""
    return "".join(f"\\{c}" if c in "\\`*_{}[]<>#|~" else c for c in text)


def planned(robot: Robot, scene: Scene, start: Array, method: str) -> Planned:
    """Plan from a configuration (n,), m and rad, by a method of this name, and time the motion."""
    began = time.perf_counter()
    there = scene.model_copy(update={"initial": tuple(start.tolist())})
    chosen = Auto(max_planning_time=MAX_PLANNING_TIME) if method == Auto.name else METHODS[method]()
    trajectory, motion, error = None, None, ""
    try:
        trajectory = plan(robot, there, chosen)
        if trajectory.status is Status.REACHED:
            motion = trajectory if trajectory.timing is not None else retime(trajectory, robot, there)
    except HumanoidRailError as refused:
        error = str(refused)
    return Planned(trajectory, motion, time.perf_counter() - began, error)
