r"""Follows targets at a fixed rate with accelerations limited and a stop that is proven at all times.

The native engine does all of it (`engine/following/`). The state is a configuration q and the velocity v that was held
in the cycle before; a cycle takes dt. In each cycle

1. **The velocity** v' is that of `qp` (:mod:`humanoid_rail.resolution.qp`) with two constraints more,

       |v'_j - v_j|  <=  a_j dt                                      limits a of the acceleration
       (q_min - q_j) / T  <=  v'_j  <=  (q_max - q_j) / T            T = max_j v_max,j / a_j, the longest time to rest

   The rows of obstacles that ask for more than these allow are relaxed towards the velocity of braking, so that there
   is a solution in every cycle.

2. **The stop** after v': with m the least whole number with |v'_j| <= m a_j dt for all joints, the velocities
   v', (1 - 1/m) v', (1 - 2/m) v', ..., 0, each held for dt. It keeps the acceleration limits, and it is one straight
   edge in joint space, from q to

       q + v' dt (m + 1) / 2                                         m dt the time until rest

   That this edge keeps clear is proven by swept distances (:mod:`humanoid_rail.collision.swept_distance`), not sampled.
   An obstacle i, no point of which moves faster than s_i and whose place is known at most L too late, is within
   s_i (L + m dt) of where it is known to be until the robot is at rest. So each pair keeps, from where the obstacle is
   known to be now, on the whole edge

       max(s_i (L + m dt) + contact,  min(d_s, d))

   with the safety distance d_s and the pair's distance d now: nothing touches whatever the obstacles do within their
   speeds, and the safety distance is kept from where they are. A pair that is nearer already comes no nearer by the end
   of the edge (to 1e-6 m), and by no more than 0.1 mm on it. The end of the edge is within the position limits.

3. **The choice**: v' if its stop is proven; else velocities a half, a quarter and an eighth of the way from the
   velocity of braking to v'; else braking itself, the next velocity of the stop that was proven before.

By induction there is a proven stop at the end of every cycle: the robot starts at rest, where nothing has to be proven,
and braking goes along an edge that was proven already. All limits hold too: braking keeps them by construction.
This is passive motion safety (Macek et al. 2009; Bouraine, Fraichard and Salhi 2012): the robot is at rest before
anything can touch it. Nothing is said of what runs into a robot at rest, nor of bodies that the robot has not
(:class:`humanoid_rail.Certificate` names them for plans), nor of bodies that no joint moves, as a base: a stop cannot
help them. These and obstacles are not even measured while neither moves. What is proven of q is true of a robot whose
drives hold each velocity for dt.

An obstacle that gets farther from where it was when the stop was proven than s_i (L + time since then) voids the proof.
That is said in `jumped`, and `proven` is False from then on, until a stop is proven among the obstacles where they are
or the robot is at rest.
"""

from __future__ import annotations

import weakref
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Self

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from humanoid_rail._arrays import FARTHEST, Array, checked_array
from humanoid_rail._native import engine
from humanoid_rail.errors import InvalidInput, check_kind, checked_number
from humanoid_rail.following.arguments import (
    check_without_functions,
    checked_acceleration,
    checked_cycle,
    checked_obstacle,
    checked_speeds,
    no_state,
)
from humanoid_rail.following.state import CycleTimes, FollowerState, named_pair, state_of
from humanoid_rail.kinematics.native_tasks import NATIVE_TASKS, native_tasks
from humanoid_rail.kinematics.task import Task
from humanoid_rail.kinematics.within_task import nominal
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.model.position_limits import within_position_limits
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.start import warn_of_depth
from humanoid_rail.planning.target_tasks import tasks_of
from humanoid_rail.planning.units import warn_of_units
from humanoid_rail.resolution.native_options import native_gains, native_safety
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.resolution.velocity import Gains
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.scene.scene import Scene, check_scene, start_of_scene
from humanoid_rail.scene.standing import with_objects_standing
from humanoid_rail.scene.targets import Step, Target

if TYPE_CHECKING:
    from humanoid_rail import _engine


class Follower:
    """Moves a robot towards its targets cycle by cycle: targets in, q_dot out, within all limits and with proven stops.

    Targets and obstacles may be changed between cycles. The cycles are made by :meth:`step`, or by a thread of the
    engine's own, from :meth:`start` to :meth:`stop`, which needs no Python; `with follower:` does both. Python threads
    may share a follower; while its thread runs, a forked process may not, and all but `is_running` raises RuntimeError
    there. What is proven, and of what, says :mod:`humanoid_rail.following.follower`. A body that no joint moves and
    that is deep in an obstacle at rest gives a warning, as in :func:`humanoid_rail.plan`, and so does what looks as if
    it were in millimetres.

    Raises:
        InvalidInput: If an argument is not valid, a joint has no finite limit of speed or acceleration, or the start
            touches something or is beyond the position limits.
        EngineMissing: If there is no native engine.
    """

    def __init__(
        self,
        robot: Robot,
        scene: Scene,
        *,
        start: ArrayLike | None = None,
        dt: float = 0.001,
        gains: Gains | None = None,
        safety: Safety | None = None,
        tolerance: float = 0.01,
        acceleration_limit: ArrayLike | None = None,
        obstacle_speed: float | Sequence[float] | None = None,
        obstacle_latency: float = 0.0,
    ) -> None:
        """Set a robot at rest among obstacles.

        Args:
            robot: The robot.
            scene: Its first targets, where it starts, and the obstacles, which move at the velocities given there until
                they are moved otherwise.
            start: Configuration (n,), m and rad; that of the scene if not given.
            dt: How long a cycle takes, s, from 0.0001 to 0.1.
            gains: K, c_mu, c_kappa and the activation distance of eq. 4.9, without objectives.
            safety: Safety distance and gain of the dampers, without equalities.
            tolerance: The targets are reached where |e| falls to this, m.
            acceleration_limit: One for all joints or (n,), m/s^2 and rad/s^2; the robot's if not given.
            obstacle_speed: No point of an obstacle is ever faster, m/s: one number, or one for each. If not given, an
                obstacle is no faster than its velocity in the scene, and one at rest there stays at rest.
            obstacle_latency: No place of an obstacle is ever known later than this, s: 1/30 for one that is reported
                thirty times a second.
        """
        check_kind("robot", robot, Robot)
        check_kind("scene", scene, Scene)
        check_scene(robot, scene)
        self.robot, self.scene, self.dt = robot, (scene := with_objects_standing(scene)), checked_cycle(dt)
        self.gains, self.safety = Gains() if gains is None else gains, Safety() if safety is None else safety
        check_without_functions(self.gains, self.safety)
        warn_of_depth(robot, scene)
        warn_of_units(robot, scene)
        given = start_of_scene(robot, scene) if start is None else start
        first = within_position_limits(robot, checked_array("start", given, (robot.n,)), "start", said_from=0.0)
        self.acceleration_limit = checked_acceleration(robot, acceleration_limit)
        self.obstacle_speed = checked_speeds(scene, obstacle_speed)
        self._rotations = [np.array(getattr(obstacle, "rpy", (0.0, 0.0, 0.0))) for obstacle in scene.obstacles]
        self._native = self._made(
            first,
            tolerance=checked_number("tolerance", tolerance, above=0.0),
            latency=checked_number("obstacle_latency", obstacle_latency, least=0.0, most=FARTHEST),
        )
        if (touching := self._native.contact()) is not None:
            near = named_pair(robot, scene.obstacles, touching)
            raise InvalidInput("start", first.tolist(), f"a start at which nothing touches: {near}")
        # The thread ends with the follower, and before the interpreter does.
        weakref.finalize(self, self._native.end)

    def _made(self, start: Array, *, tolerance: float, latency: float) -> _engine.Follower:
        """Return the engine's own follower."""
        tasks, gains = self._goal(nominal(tasks_of(self.robot, self.scene.steps[0])))
        native: _engine.Follower = engine().Follower(
            native_robot(self.robot),
            native_obstacles(self.scene.obstacles),
            start,
            tasks,
            gains,
            native_safety(self.safety, no_state),
            dt=self.dt,
            tolerance=tolerance,
            acceleration=self.acceleration_limit,
            obstacle_speeds=self.obstacle_speed,
            latency=latency,
        )
        return native

    def set_targets(self, targets: Step | Mapping[str, Target]) -> None:
        """Set what the hands have to reach from the next cycle on.

        Args:
            targets: By the name of each hand a point in m, a :class:`humanoid_rail.Pose`, or None; or one step.

        Raises:
            InvalidInput: If they are not targets for this robot.
        """
        scene = Scene(name=self.scene.name, targets=targets if isinstance(targets, Step) else dict(targets))
        check_scene(self.robot, scene)
        self.set_tasks(nominal(tasks_of(self.robot, scene.steps[0])))

    def set_tasks(self, tasks: Sequence[Task]) -> None:
        """Set what has to be reached from the next cycle on.

        Args:
            tasks: Tasks that the engine knows itself: its thread never waits for Python.

        Raises:
            InvalidInput: If there are none, or one of them is of another kind or does not suit the robot.
        """
        self._native.set_goal(*self._goal(tasks))

    def move_obstacle(
        self,
        obstacle: int | str,
        center: ArrayLike,
        rpy: ArrayLike | None = None,
        velocity: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        """Say where an obstacle is at the beginning of the next cycle, and how fast it moves on.

        Args:
            obstacle: Its number in the scene, or its name if no other has the same.
            center: Where its centre (of a mesh its origin) is, m.
            rpy: How it is turned, as in the scene, rad; as before if not given.
            velocity: How fast it moves on, without turning, until something else is said, m/s.

        Raises:
            InvalidInput: If there is no such obstacle, it is a half-space, or a vector is not three finite numbers.
        """
        number = checked_obstacle(self.scene.obstacles, obstacle)
        place = checked_array("center", center, (3,), most=FARTHEST)
        angles = self._rotations[number] if rpy is None else checked_array("rpy", rpy, (3,))
        moves = checked_array("velocity", velocity, (3,), most=FARTHEST)
        self._rotations[number] = angles
        self._native.move_obstacle(number, place, pin.rpy.rpyToMatrix(*angles), moves)

    def step(self, *, brake: bool = False) -> FollowerState:
        """Make a cycle and return the state at its end.

        Args:
            brake: Whether to go on with the stop, whatever the targets are.

        Raises:
            RuntimeError: While the thread runs.
        """
        return self._state(self._native.step(brake))

    def start(self) -> None:
        """Start making cycles in a thread of the engine's own, each dt after the one before.

        A cycle that is late delays those after it: none is made up for, so that the robot is never faster than it
        should be.

        Raises:
            RuntimeError: If it runs already, here or in the process that this one was forked from.
        """
        self._native.start()

    def stop(self) -> FollowerState:
        """Brake, end the thread when the robot is at rest, and return the state there.

        Raises:
            RuntimeError: If the thread ended by an error.
        """
        self._native.stop()
        return self.state

    @property
    def is_running(self) -> bool:
        """Whether the thread runs; False in a process that was forked while it did."""
        running: bool = self._native.is_running
        return running

    @property
    def state(self) -> FollowerState:
        """The state at the end of the last cycle. Raises RuntimeError where the thread ended by an error."""
        return self._state(self._native.state())

    @property
    def cycle_times(self) -> CycleTimes:
        """How long the cycles of the thread took since it was started."""
        times = self._native.times()
        median, high = times.percentile(0.5), times.percentile(0.99)
        return CycleTimes(times.cycles, times.overruns, median, high, times.longest)

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Stop the thread; after an exception it ends at once."""
        if kind is None:
            self.stop()
        else:
            self._native.end()

    def _state(self, native: _engine.FollowerState) -> FollowerState:
        return state_of(self.robot, self.scene.obstacles, self.dt, native)

    def _goal(self, tasks: Sequence[Task]) -> tuple[_engine.TaskStack, _engine.Gains]:
        stack = native_tasks(self.robot, tasks, no_state)
        for i, task in enumerate(tasks):
            if type(task) not in NATIVE_TASKS:
                valid = f"a task that the engine knows itself: {', '.join(kind.__name__ for kind in NATIVE_TASKS)}"
                raise InvalidInput(f"tasks[{i}]", task, valid)
        return stack, native_gains(self.robot, self.gains, stack.rows, no_state)
