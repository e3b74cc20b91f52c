"""Plans scenes by roboplan for `compare_motions.py`: inverse kinematics, RRT-Connect, shortcuts and TOPP-RA.

Each with its default options, except where a constant below says otherwise. In a process of its own, since
`getVelocityLimitVectors()` without a group writes beyond its memory (roboplan 0.7).
"""

from __future__ import annotations

import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from roboplan import core, optimal_ik, rrt, toppra

from benchmarks.worker import serve
from humanoid_rail import Box, InvalidInput, Robot, Scene, Sphere, load_robot, load_scene
from humanoid_rail._arrays import Array
from humanoid_rail.scene.scene import start_of_scene, target_points
from humanoid_rail.scene.shapes import placed_shapes

GROUP = "planned"
"""The group of the joints that are planned for."""
WORLD = "universe"
"""Pinocchio's name of the frame that obstacles rest in."""
COLOUR = np.ones(4)
GOALS, GOAL_TIME, MAX_NODES = 10, 1.0, 100_000
"""RRT-Connect tries so many goals one after the other, for so long each, s, and with so many nodes at the most."""
STARTS, ITERATIONS = 2000, 60
"""Inverse kinematics begins at so many random configurations at the most, and takes so many steps from each."""
ARRIVED = 1e-3
"""A hand is at its target if it is this near, m: the default of roboplan's other solver, which wants whole poses."""
DAMPING, LONGEST_ERROR, REGULARISATION = 0.01, 0.5, 1e-6
"""Of inverse kinematics: Levenberg-Marquardt's damping, the longest error that a step works on, m, and Tikhonov's."""
MODE = toppra.SplineFittingMode.LinearBlend
"""How TOPP-RA makes a path of corners one that can be followed: the default stops at every corner."""
FINE = 1e-3
"""The motion is handed over with this time between its samples, s, which counts as no planning time."""


def make_scene(robot: Robot, scene: Scene) -> core.Scene:
    """Return a scene as roboplan has it, with the robot in it.

    Raises:
        InvalidInput: If there is an obstacle that moves, or is no sphere or box.
    """
    made = core.Scene("scene", core.loadUrdfSceneDescriptionFromXml(robot.urdf))
    made.addGroup(GROUP, list(robot.joint_names))
    limits = zip(robot.joint_names, robot.acceleration_limit, strict=True)
    with TemporaryDirectory() as folder:
        file = Path(folder) / "limits.yaml"
        lines = [f"  {name}: {{max_acceleration: [{limit}]}}\n" for name, limit in limits]
        file.write_text("joint_limits:\n" + "".join(lines), encoding="utf-8")
        made.importJointLimitsFromConfig(core.loadJointLimitsConfig(file))
    names = [f"obstacle {k}" for k in range(len(scene.obstacles))]
    for name, obstacle in zip(names, scene.obstacles, strict=True):
        if not isinstance(obstacle, Sphere | Box) or any(obstacle.velocity):
            raise InvalidInput("obstacles", obstacle, "a Sphere or a Box at rest, for roboplan")
        placement = np.eye(4)
        [(_, placed)] = placed_shapes(obstacle)
        placement[:3, :3], placement[:3, 3] = placed.getRotation(), placed.getTranslation()
        if isinstance(obstacle, Sphere):
            made.addSphereGeometry(name, WORLD, core.Sphere(obstacle.radius), placement, COLOUR)
        else:
            made.addBoxGeometry(name, WORLD, core.Box(*obstacle.size), placement, COLOUR)
    # Obstacles collide with each other unless that is allowed.
    allowed = [(one, other) for k, one in enumerate(names) for other in names[:k]]
    made.setCollisions([*allowed, *((pair.link, pair.other) for pair in robot.unchecked_pairs)], False)
    return made


class Goals:
    """Configurations without collisions that have the hands at their targets, by roboplan's OInK."""

    def __init__(self, robot: Robot, scene: Scene, made: core.Scene) -> None:
        self._scene, self._oink = made, optimal_ik.Oink(made, GROUP)
        self._targets = list(zip((hand.frame for hand in robot.hands), target_points(robot, scene), strict=True))
        options = optimal_ik.FrameTaskOptions(
            orientation_cost=0.0, lm_damping=DAMPING, max_position_error=LONGEST_ERROR
        )
        base = robot.model.frames[1].name
        self._tasks = []
        for frame, point in self._targets:
            pose = np.eye(4)
            pose[:3, 3] = point
            target = core.CartesianConfiguration(base, frame, pose)
            self._tasks.append(optimal_ik.FrameTask(self._oink, made, target, options))
        self._limits = [optimal_ik.PositionLimit(self._oink)]

    def look(self) -> Array | None:
        """Return a goal (n,), or None if a random configuration leads to none."""
        scene, step = self._scene, np.zeros(self._oink.num_variables)
        q: Array = scene.randomPositions()
        for _ in range(ITERATIONS):
            try:
                self._oink.solveIk(q, self._tasks, self._limits, step, REGULARISATION)
            except RuntimeError:  # its quadratic program was not solved
                return None
            q = scene.clampToValidConfiguration(scene.integrate(q, scene.toFullJointVelocities(GROUP, step)))
            if all(self._error(q, frame, point) < ARRIVED for frame, point in self._targets):
                return None if scene.hasCollisions(q) else q
        return None

    def _error(self, q: Array, frame: str, point: Array) -> float:
        return float(np.linalg.norm(self._scene.forwardKinematics(q, frame)[:3, 3] - point))


def find_path(robot: Robot, scene: Scene, made: core.Scene, seed: int) -> core.JointPath | None:
    """Return a path from the start of a scene to its targets, with shortcuts, if one is found."""
    start = np.array(start_of_scene(robot, scene))
    made.setRngSeed(seed)
    made.setJointPositions(start)
    goals, names, tried = Goals(robot, scene, made), list(robot.joint_names), 0
    options = rrt.RRTOptions(group_name=GROUP, max_nodes=MAX_NODES, max_planning_time=GOAL_TIME, rrt_connect=True)
    for _ in range(STARTS):
        if tried == GOALS:
            return None
        goal = goals.look()
        if goal is None:
            continue
        tried += 1
        planner = rrt.RRT(made, options)
        planner.setRngSeed(seed + tried)
        try:
            path = planner.plan(core.JointConfiguration(names, start), core.JointConfiguration(names, goal))
        except RuntimeError:  # out of time or nodes, or the start collides
            continue
        return core.PathShortcutter(made, core.PathShortcuttingOptions(group_name=GROUP, seed=seed)).shortcut(path)
    return None


def answer(robot: Robot, request: dict[str, Any]) -> dict[str, Any]:
    """Return the motion for a scene, and the processor time that it took."""
    scene = load_scene(request["scene"])
    try:
        made = make_scene(robot, scene)
    except InvalidInput as error:
        return {"failed": str(error), "planning_time": 0.0}
    started = time.process_time()
    path = find_path(robot, scene, made, request["seed"])
    planned = time.process_time()
    if path is None:
        return {"failed": "no path was found", "planning_time": planned - started}
    timing = toppra.PathParameterizerTOPPRA(made, GROUP)
    timing.generate(path, toppra.TOPPRAOptions(mode=MODE))
    done = time.process_time()
    motion = timing.generate(path, toppra.TOPPRAOptions(mode=MODE, dt=FINE))
    return {
        "planning_time": planned - started,
        "time": done - started,
        "reason": f"a path with {len(path.positions)} corners was found",
        "t": list(motion.times),
        "q": np.array(motion.positions).tolist(),
        "velocity": np.array(motion.velocities).tolist(),
    }


def main() -> None:
    """Answer requests until stdin ends."""
    robot = load_robot()
    serve(lambda request: answer(robot, request))


if __name__ == "__main__":
    main()
