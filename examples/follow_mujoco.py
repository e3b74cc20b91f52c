"""Drives a simulated robot in MuJoCo with a follower: 1 kHz, a hand that follows a circle, a ball that comes and goes.

python examples/follow_mujoco.py              the viewer (mjpython instead of python on macOS)
python examples/follow_mujoco.py --headless   needs no display: simulates once and prints how well the robot follows

Needs the package and `python -m pip install 'mujoco>=3.3'`. The robot is moved by actuators with gravity, not placed.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from humanoid_rail import Follower, FollowerState, Pose, Robot, Scene, Sphere, export, load_robot, plan, retime

try:
    import mujoco
except ModuleNotFoundError:
    sys.exit(f"error: this example needs MuJoCo, which is not installed: {sys.executable} -m pip install 'mujoco>=3.3'")

BALL = Sphere(center=(-1.0, 2.6, 3.4), radius=0.15)
BALL_SPEED = 0.3
"""The ball is no faster, m/s."""


@dataclass(frozen=True)
class Followed:
    """What came of a simulation."""

    seconds: float
    """How long it was, s."""
    largest_error: float
    """How far a joint was at most from where the follower had it, m and rad."""
    touches: int
    """In how many steps of the simulation the robot touched the ball."""
    unproven: int
    """In how many cycles no stop was proven."""


class Simulation:
    """The robot and the ball in MuJoCo, in step with a follower."""

    def __init__(self, robot: Robot, follower: Follower, folder: Path) -> None:
        self.robot, self.follower = robot, follower
        self.model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
        self.model.opt.timestep = follower.dt
        self.data, self.reference = mujoco.MjData(self.model), mujoco.MjData(self.model)
        names = list(robot.model.names)[1:]
        self.joints = np.array([self.model.joint(name).id for name in names])
        self.actuated = self.model.actuator_trnid[:, 0]
        self.columns = [robot.joint_names.index(self.model.joint(i).name) for i in self.actuated]
        self.put(self.data, follower.state.q, np.zeros(robot.n))

    def put(self, data: Any, q: np.ndarray, velocity: np.ndarray) -> None:
        """Put the robot of some data to a configuration (n,), m and rad, and a velocity (n,)."""
        data.qpos[self.model.jnt_qposadr[self.joints]] = self.robot.coupling @ q + self.robot.offset
        data.qvel[self.model.jnt_dofadr[self.joints]] = self.robot.coupling @ velocity
        mujoco.mj_forward(self.model, data)

    def step(self, state: FollowerState, ball: np.ndarray) -> None:
        """Simulate a cycle: each actuator is given what makes up for gravity and for its own damping."""
        self.put(self.reference, state.q, state.velocity)
        load = self.robot.coupling.T @ self.reference.qfrc_bias[self.model.jnt_dofadr[self.joints]]
        kp, kv = -self.model.actuator_biasprm[:, 1], -self.model.actuator_biasprm[:, 2]
        self.data.ctrl[:] = state.q[self.columns] + (kv * state.velocity[self.columns] + load[self.columns]) / kp
        self.data.mocap_pos[0] = ball
        mujoco.mj_step(self.model, self.data)

    def error(self, state: FollowerState) -> float:
        """Return how far a joint is at most from where the follower has it, m and rad."""
        return float(abs(self.data.qpos[self.model.jnt_qposadr[self.actuated]] - state.q[self.columns]).max())

    def touches(self) -> bool:
        """Return whether anything of the robot touches the ball."""
        bodies = (self.model.geom_bodyid[pair] for pair in self.data.contact.geom)
        return any((self.model.body_mocapid[pair] >= 0).any() for pair in bodies)


def run(seconds: float, *, headless: bool) -> Followed:
    """Follow for so long, s."""
    robot = load_robot()
    scene = Scene(name="following", targets=targets(0.0), obstacles=(BALL,))
    with TemporaryDirectory() as folder:
        export(retime(plan(robot, moving(scene)), robot, moving(scene)), robot, moving(scene), "mujoco", folder)
        follower = Follower(robot, scene, obstacle_speed=BALL_SPEED)
        simulation = Simulation(robot, follower, Path(folder))
        errors, touches, unproven = [0.0], 0, 0
        with viewer(simulation, headless) as show:
            for cycle in range(round(seconds / follower.dt)):
                t = cycle * follower.dt
                center = ball_at(t)
                follower.set_targets(targets(t))
                follower.move_obstacle(0, center)
                state = follower.step()
                simulation.step(state, center)
                errors.append(simulation.error(state))
                touches += simulation.touches()
                unproven += not state.proven
                show()
    return Followed(seconds, max(errors), touches, unproven)


def moving(scene: Scene) -> Scene:
    """Return a scene with a ball that moves, away from everything: so it can be moved in the exported model, too."""
    away = Sphere(center=(3.0, 8.0, 3.0), radius=BALL.radius, velocity=(0.01, 0.0, 0.0))
    return scene.model_copy(update={"obstacles": (away,)})


def targets(t: float) -> dict[str, tuple[float, float, float] | Pose | None]:
    """Return where the hands have to be at a time in s: the left one on a circle of 0.3 m, once in 6 s."""
    angle = 2.0 * np.pi * t / 6.0
    return {
        "left": (-1.6, 0.9 + 0.3 * float(np.cos(angle)), 3.2 + 0.3 * float(np.sin(angle))),
        "right": (-1.6, 2.2, 3.4),
    }


def ball_at(t: float) -> np.ndarray:
    """Return where the ball is at a time in s: to and fro between the hands."""
    return np.add(BALL.center, (-0.5 * np.sin(0.5 * t), 0.0, 0.0))


@contextlib.contextmanager
def viewer(simulation: Simulation, headless: bool) -> Iterator[Any]:
    """Yield what shows the simulation in real time, or does nothing."""
    if headless:
        yield lambda: None
        return
    import mujoco.viewer

    with mujoco.viewer.launch_passive(simulation.model, simulation.data) as window:
        began = time.perf_counter()

        def show() -> None:
            if round(simulation.data.time / simulation.follower.dt) % 16 == 0:
                window.sync()
            time.sleep(max(0.0, simulation.data.time - (time.perf_counter() - began)))

        yield show


def main() -> None:
    """Run and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--headless", action="store_true", help="simulate once, without a window")
    parser.add_argument("--seconds", type=float, default=12.0, help="how long, s")
    arguments = parser.parse_args()
    done = run(arguments.seconds, headless=arguments.headless)
    print(f"{done.seconds:g} s: joints at most {done.largest_error:.3g} m or rad from where the follower had them,")
    print(f"the ball touched in {done.touches} steps, no stop proven in {done.unproven} cycles")


if __name__ == "__main__":
    main()
