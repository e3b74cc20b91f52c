"""A follower in a world that is changed by hand."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.following.follower import Follower
from humanoid_rail.following.state import CycleTimes, FollowerState, FollowerStatus
from humanoid_rail.kinematics.task import ConfigurationTask
from humanoid_rail.live.triangles import radius
from humanoid_rail.live.world import World, nearer, placed
from humanoid_rail.resolution.velocity import Gains
from humanoid_rail.scene.obstacles import HalfSpace
from humanoid_rail.scene.placing import placement_of
from humanoid_rail.trajectory import Trajectory

GAIN = 4.0
"""The gain K of what is followed, 1/s."""
LATENCY = 0.05
"""No place of an obstacle is known later than this, s: some thirty times a second it is told."""
SHARE = 0.9
"""Obstacles move at this share of the speed that the follower is told."""
LEAD = 0.3
"""What is followed along a route is at most this far ahead, in the time that the joints need at their limits, s."""
PATIENCE = 1.0
"""A robot that gets no farther along its route for this long is stuck, s."""


class Chase:
    """A robot that follows the targets of a world, or a route through it, while obstacles go to where they were put.

    An obstacle does not jump to where it was put: it goes there no faster than obstacles may.
    """

    def __init__(self, world: World, speed: float) -> None:
        """Start the follower's thread.

        Args:
            world: The robot, its first targets and the obstacles.
            speed: No point of an obstacle is faster, m/s.

        Raises:
            InvalidInput: If the robot touches something where it stands, or has no limits of acceleration.
        """
        scene = world.scene.model_copy(update={"targets": world.scene.steps[0]})
        limits = [0.0 if isinstance(obstacle, HalfSpace) else speed for obstacle in scene.obstacles]
        self.follower = Follower(
            world.robot,
            scene,
            start=world.q,
            gains=Gains(GAIN),
            obstacle_speed=limits,
            obstacle_latency=LATENCY,
        )
        self.places = [placement_of(obstacle) for obstacle in scene.obstacles]
        self._radii = [radius(obstacle) for obstacle in scene.obstacles]
        self._targets, self._speed = scene.steps[0], speed
        self._route: Trajectory | None = None
        self._along = self._waited = 0.0
        self.follower.start()

    @property
    def is_stuck(self) -> bool:
        """Whether the robot has got no farther along its route for a while."""
        return self._route is not None and self._waited > PATIENCE

    @property
    def is_on_route(self) -> bool:
        """Whether there is a route whose end was not reached."""
        return self._route is not None

    @property
    def times(self) -> CycleTimes:
        """How long the cycles took."""
        return self.follower.cycle_times

    def take(self, route: Trajectory | None) -> None:
        """Follow a motion from its beginning, or the targets."""
        self._route, self._along, self._waited = route, 0.0, 0.0
        if route is None:
            self.follower.set_targets(self._targets)

    def tick(self, world: World, dt: float) -> FollowerState:
        """Tell the follower what has changed in the world, after a time in s, and return where the robot is."""
        for i, obstacle in enumerate(world.scene.obstacles):
            if isinstance(obstacle, HalfSpace):
                continue
            wanted, there = placement_of(obstacle), self.places[i]
            if not there.isApprox(wanted, 1e-9):
                self.places[i] = nearer(there, wanted, self._radii[i], SHARE * self._speed * min(dt, LATENCY))
                angles = pin.rpy.matrixToRpy(self.places[i].rotation)
                self.follower.move_obstacle(i, self.places[i].translation, angles)
        if (targets := world.scene.steps[0]) != self._targets:
            self._targets = targets
            if self._route is None:
                self.follower.set_targets(targets)
        state = self.follower.state
        if self._route is not None:
            self._follow_route(world, state, dt)
        return state

    def world_now(self, world: World) -> World:
        """Return a world with robot and obstacles where they are."""
        for i, (obstacle, there) in enumerate(zip(world.scene.obstacles, self.places, strict=True)):
            world = world.with_obstacle(i, placed(obstacle, there.translation, there.rotation))
        return world.at(np.array(self.follower.state.q))

    def close(self) -> Array:
        """Brake, end the thread, and return where the robot is at rest (n,), m and rad."""
        return np.array(self.follower.stop().q)

    def _follow_route(self, world: World, state: FollowerState, dt: float) -> None:
        """Move what is followed along the route as far as the robot keeps up, at the end go back to the targets."""
        assert self._route is not None
        ahead = self._route.configuration(self._along)
        if (abs(ahead - state.q) <= LEAD * world.robot.velocity_limit).all():
            self._along += dt
        is_moving = state.status in (FollowerStatus.FOLLOWING, FollowerStatus.REACHED)
        self._waited = 0.0 if is_moving else self._waited + dt
        if self._along >= self._route.duration and abs(ahead - state.q).max() < 0.05:
            self.take(None)
            return
        joints, now = tuple(world.robot.joint_names), self._route.configuration(self._along)
        self.follower.set_tasks([ConfigurationTask(joints, tuple(now.tolist()))])
