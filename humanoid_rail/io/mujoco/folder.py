"""The folder of an export to MuJoCo: a model of robot and scene, the motion, and a program that plays it."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.io.mujoco.actuators import PositionActuator, gravity_load, needed_forces, position_actuators
from humanoid_rail.io.mujoco.mjcf import mjcf
from humanoid_rail.io.mujoco.objects import check_events, event_arrays, held_load
from humanoid_rail.io.mujoco.visual_meshes import visual_meshes
from humanoid_rail.io.robot_motion import all_joints
from humanoid_rail.model.robot import Robot
from humanoid_rail.result import Timing
from humanoid_rail.scene.obstacles import Obstacle, is_moving
from humanoid_rail.scene.scene import Scene
from humanoid_rail.trajectory import Trajectory


def mujoco_files(
    trajectory: Trajectory, robot: Robot, scene: Scene, objects: Sequence[Obstacle] | None = None
) -> dict[str, bytes]:
    """Return the files of an export: their contents by name, those of meshes in a folder.

    A warning names the joints whose limit of effort is less than the motion needs: MuJoCo keeps the limit, and the
    robot falls behind.

    Args:
        trajectory: The motion.
        robot: The robot that it was planned for.
        scene: The scene that it was planned in.
        objects: What the hands grasp and release; those of the scene if not given.

    Raises:
        InvalidInput: If the motion was not retimed or has fewer than two samples, or MuJoCo cannot have the robot,
            or an event names an object or a hand that is not there.
    """
    if trajectory.timing is None:
        valid = (
            "a retimed motion, by retime() or humanoid-rail plan --retime: actuators cannot follow one that starts at "
            "full speed"
        )
        raise InvalidInput("trajectory.timing", None, valid)
    if len(trajectory.t) < 2:
        raise InvalidInput("trajectory.t", trajectory.t, "a motion of two samples or more")
    objects = scene.objects if objects is None else objects
    check_events(robot, objects, trajectory)
    actuators, load = position_actuators(robot, trajectory.q), gravity_load(robot, trajectory.q)
    load = load + held_load(robot, objects, trajectory) if trajectory.events else load
    _warn_of_weakness(trajectory, trajectory.timing, robot, actuators, load)
    kp, kv = (np.array([getattr(actuator, gain) for actuator in actuators]) for gain in ("kp", "kv"))
    ctrl = trajectory.q + (kv * trajectory.timing.velocity + load) / kp
    qpos, qvel = all_joints(robot, [trajectory.q, trajectory.timing.velocity])
    velocities = np.array([obstacle.velocity for obstacle in scene.obstacles if is_moving(obstacle)]).reshape(-1, 3)
    arrays = {
        "time": trajectory.t,
        "qpos": qpos,
        "qvel": qvel,
        "load": load,
        "ctrl": ctrl,
        "hands": trajectory.hands,
        "mocap": trajectory.t[:, None, None] * velocities,
        **event_arrays(robot, objects, trajectory),
    }
    buffer = BytesIO()
    np.savez_compressed(buffer, **arrays)
    player = Path(__file__).with_name("player.py").read_bytes()
    meshes = visual_meshes(robot)
    model = mjcf(robot, scene, trajectory, actuators, ctrl[0], meshes, objects)
    return {**meshes.files, "scene.xml": model.encode(), "motion.npz": buffer.getvalue(), "play.py": player}


def _warn_of_weakness(
    trajectory: Trajectory, timing: Timing, robot: Robot, actuators: Sequence[PositionActuator], load: Array
) -> None:
    forces = abs(needed_forces(robot, trajectory.q, timing.velocity, timing.acceleration)).max(axis=0)
    limits = np.array([actuator.effort_limit for actuator in actuators])
    weak = [
        f"{actuator.joint} {force:.3g} of {actuator.effort_limit:.3g}"
        for actuator, force in zip(actuators, forces, strict=True)
        if force > actuator.effort_limit
    ]
    if weak:
        what = "the motion needs more than the limits of effort, N or N m, and will not be followed"
        how = "lower limits of acceleration make it slower, such as by load_robot(..., acceleration_time=1)"
        if (abs(load).max(axis=0) > limits).any():
            how = "the weight alone is more, as that of robots with springs or counterweights that the URDF has not"
        warnings.warn(f"{what}: {', '.join(weak)}; {how}", stacklevel=3)
