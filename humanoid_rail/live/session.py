"""What a user does to a world in the browser, and what comes of it. It knows nothing of the browser."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import HumanoidRailError
from humanoid_rail.following.state import FollowerState
from humanoid_rail.live.chase import Chase
from humanoid_rail.live.planning import Planned, plain, planned
from humanoid_rail.live.worker import Worker
from humanoid_rail.live.world import World
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.placing import placement_of

SPEED = 0.2
"""Obstacles are no faster than this when the robot follows, unless something else is said, m/s."""
REST = 1.0
"""A motion that is shown again and again rests so long at its end, s."""


class Mode(StrEnum):
    """What the robot does."""

    PLAN = "plan"
    """Each change is planned from where the robot stands, and the motion is shown again and again."""
    FOLLOW = "follow"
    """The robot follows its targets at 1 kHz."""
    DRIVE = "plan and follow"
    """The robot follows a plan at 1 kHz, to its end and then its targets; a change, or an obstacle in the way, leads to
    another plan from where it is."""


@dataclass(frozen=True, eq=False)
class Shown:
    """What there is to see at a moment."""

    q: Array
    """Where the robot is (n,), m and rad."""
    places: Sequence[pin.SE3]
    """Where the obstacles are."""
    status: str
    """What comes of it, in lines of Markdown."""


class Session:
    """A world that is changed by hand. Threads may share it."""

    def __init__(self, world: World, method: str = "auto", obstacle_speed: float = SPEED) -> None:
        self._lock = threading.RLock()
        self._world, self._method, self._speed = world, method, obstacle_speed
        self._mode = Mode.PLAN
        self._chase: Chase | None = None
        self._load: Callable[[], Robot] | None = None
        self._planned: Planned | None = None
        self._message, self._plans, self._asked = "", 0, 0
        self._began = time.monotonic()
        self._worker = Worker(self._plan_failed)
        self.replan()

    @property
    def world(self) -> World:
        """The world as it is."""
        return self._world

    @property
    def mode(self) -> Mode:
        """What the robot does."""
        return self._mode

    @property
    def plan(self) -> Planned | None:
        """The latest plan, of a world that may have changed since."""
        return self._planned

    @property
    def is_planning(self) -> bool:
        """Whether a plan of the world as it is is still to come."""
        return self._plans < self._asked

    def change(self, change: Callable[[World], World]) -> None:
        """Change the world, and plan again where plans are made."""
        with self._lock:
            self._world = change(self._world)
        if self._mode is not Mode.FOLLOW:
            self.replan()

    def set_method(self, method: str) -> None:
        """Plan by the method of this name from now on."""
        self._method = method
        self.replan()

    def set_obstacle_speed(self, speed: float) -> None:
        """Let obstacles be so fast, m/s, when the robot follows the next time."""
        self._speed = speed

    def load_robot(self, load: Callable[[], Robot]) -> None:
        """Have another robot of the same kind in the world; of those that wait only the latest is loaded."""
        with self._lock:
            self._load = load
        self.set_mode(Mode.PLAN)
        self.replan()

    def replan(self) -> None:
        """Plan the world as it is; plans that wait are given up."""
        with self._lock:
            self._asked += 1
            number = self._asked
        self._worker.ask(lambda: self._plan(number))

    def set_mode(self, mode: Mode) -> None:
        """Have the robot do something else; it begins where it is."""
        with self._lock:
            if mode is self._mode:
                return
            self._end_chase()
            self._begin(mode)
        if self._mode is not Mode.FOLLOW:
            self.replan()

    def _begin(self, mode: Mode) -> None:
        """Have the robot do something, where it has no follower."""
        self._mode, self._message = mode, ""
        if mode is not Mode.PLAN:
            try:
                self._chase = Chase(self._world, self._speed)
            except HumanoidRailError as refused:
                self._mode, self._message = Mode.PLAN, f"**not followed**: {plain(str(refused))}"

    def _end_chase(self) -> None:
        """End the follower, if there is one, and leave the robot where it is."""
        if self._chase is not None:
            self._world = self._world.at(self._chase.close())
            self._chase = None

    def tick(self, dt: float) -> Shown:
        """Go on by a time in s, and return what there is to see."""
        with self._lock:
            world = self._world
            places = [placement_of(obstacle) for obstacle in world.scene.obstacles]
            if self._chase is None:
                return Shown(self._of_plan(), places, self._said())
            try:
                state = self._chase.tick(world, dt)
            except RuntimeError as error:  # its thread has ended
                self._chase, self._mode = None, Mode.PLAN
                self.failed(error)
                return Shown(world.q, places, self._said())
            self._world = world.at(state.q)
            if self._mode is Mode.DRIVE and self._chase.is_stuck and not self.is_planning:
                self.replan()
            return Shown(state.q, self._chase.places, self._said_of(self._chase, state))

    def close(self) -> None:
        """End all threads."""
        self._worker.close()
        with self._lock:
            if self._chase is not None:
                self._chase.close()
                self._chase = None

    def _plan(self, number: int) -> None:
        """Plan in the worker's thread, with the robot that was asked for last, among the obstacles where they are."""
        self._take_robot()
        with self._lock:
            world, method = self._world, self._method
            there = world if self._chase is None else self._chase.world_now(world)
        result = planned(there.robot, there.scene, there.q, method)
        with self._lock:
            self._plans = max(self._plans, number)
            if number < self._asked:
                return  # the world has changed meanwhile
            self._planned, self._began, self._message = result, time.monotonic(), ""
            if self._chase is not None and self._mode is Mode.DRIVE:
                self._chase.take(result.motion if result.certified else None)

    def _take_robot(self) -> None:
        """Load the robot that waits, if one does, and have it in the world; a follower of the old one begins anew."""
        with self._lock:
            load, self._load = self._load, None
        if load is None:
            return
        robot = load()
        with self._lock:
            self._end_chase()
            self._world = self._world.with_robot(robot)
            self._begin(self._mode)

    def failed(self, error: Exception) -> None:
        """Show an error that nobody expected; whoever reads it may change what led to it."""
        with self._lock:
            self._message = f"**failed**: {plain(f'{type(error).__name__}: {error}')}"

    def _plan_failed(self, error: Exception) -> None:
        with self._lock:
            self._plans = self._asked
        self.failed(error)

    def _of_plan(self) -> Array:
        """Return where the robot is in the plan that is shown (n,); where it stands if there is none."""
        shown = None if self._planned is None else self._planned.motion or self._planned.trajectory
        if shown is None or len(shown.t) < 2 or shown.q.shape[1] != self._world.robot.n:
            return self._world.q
        t = (time.monotonic() - self._began) % (shown.duration + REST)
        return shown.configuration(t)

    def _said(self) -> str:
        parts = ["planning ..."] if self.is_planning else []
        if self._message:
            parts.append(self._message)
        elif self._planned is not None:
            parts.append(self._planned.described())
        return "\n\n".join(parts)

    def _said_of(self, chase: Chase, state: FollowerState) -> str:
        times = chase.times
        lines = [
            f"**{state.status}**{' along the plan' if chase.is_on_route else ''}, "
            f"{'stop proven' if state.proven else '**no stop proven**'}",
            plain(state.reason),
            f"cycle of 1 ms: median {1e6 * times.median:.0f} us, 99 % within {1e6 * times.percentile_99:.0f} us, "
            f"longest {1e3 * times.longest:.1f} ms, {times.overruns} of {times.cycles} late",
        ]
        return "\n\n".join([*lines, *([self._said()] if self._mode is Mode.DRIVE else [])])
