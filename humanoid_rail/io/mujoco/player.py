"""Plays a motion in MuJoCo. Needs only mujoco and numpy: a copy of this file, `play.py`, lies beside every export.

    python play.py              the viewer, in a loop
    python play.py --headless   simulates once; prints how well the robot follows and what it touches

The robot is moved by actuators, not placed: each actuated joint has a position actuator, whose force is
kp (ctrl - q) - kv q_dot. With ctrl = q_ref + (kv q_dot_ref + load) / kp that is
kp (q_ref - q) + kv (q_dot_ref - q_dot) + load: the damping does not hold back the motion, and the weight, which the
load bears, does not pull the robot down.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RESTING = 1e-3
"""An object that lies on something is at most this deep inside of it, which is no contact worth a word, m."""

HOLD = 1.5
"""How long the viewer rests at the end of the motion before it starts over, s."""
FRAMES_PER_SECOND = 50
"""The viewer shows this many frames a second."""


@dataclass(frozen=True)
class Touch:
    """Two bodies in contact."""

    time: float
    """When they are first, s."""
    one: str
    """A collision body of the robot or an obstacle."""
    other: str
    depth: float
    """How deep they are inside each other at worst, m."""


@dataclass(frozen=True)
class Tracking:
    """How well the simulated robot follows a motion."""

    largest_hand_error: float
    """Of any hand at any time, m."""
    final_hand_error: float
    """Of the worst hand at the end of the motion, m."""
    contacts: tuple[Touch, ...]
    """Each pair once, by time."""
    largest_forces: dict[str, float]
    """Of the actuators, by joint; N or N m."""
    objects_off: dict[str, float] = field(default_factory=dict)
    """How far objects end from where they were planned to be put, m; those that are held at the end are missing."""


@dataclass(frozen=True)
class ExportedMotion:
    """What `motion.npz` holds. N samples, nq joints, n actuated ones, h hands, k moving obstacles."""

    time: Array
    """(N,), s."""
    qpos: Array
    """(N, nq), m and rad; between the samples it is the cubic spline through qpos and qvel."""
    qvel: Array
    """(N, nq), m/s and rad/s."""
    load: Array
    """What holds the robot against gravity at the samples (N, n), N and N m."""
    ctrl: Array
    """What the actuators are given at the samples (N, n), m and rad."""
    hands: Array
    """Positions of the hands (N, h, 3), m."""
    mocap: Array
    """How far the moving obstacles have come (N, k, 3), m."""
    event_time: Array = field(default_factory=lambda: np.zeros(0))
    """When welds between hands and objects are switched (e,), s."""
    event_weld: NDArray[np.str_] = field(default_factory=lambda: np.zeros(0, np.str_))
    """Which ones (e,)."""
    event_active: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, np.bool_))
    """Whether they are switched on (e,)."""
    object_name: NDArray[np.str_] = field(default_factory=lambda: np.zeros(0, np.str_))
    """The objects (o,)."""
    object_end: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """Where they are to be at the end (o, 3), m; not a number of those that are held then."""

    def at(self, t: float) -> tuple[Array, Array]:
        """Return qpos and qvel (nq,) at a time in s; before the start and after the end it rests there."""
        if not self.time[0] <= t < self.time[-1]:
            end = 0 if t < self.time[0] else -1
            return self.qpos[end], np.zeros_like(self.qvel[end])
        i = int(np.searchsorted(self.time, t, side="right")) - 1
        h = self.time[i + 1] - self.time[i]
        s = (t - self.time[i]) / h
        (a, b), (u, v) = self.qpos[i : i + 2], self.qvel[i : i + 2] * h
        c, d = 3 * (b - a) - 2 * u - v, 2 * (a - b) + u + v
        return a + s * (u + s * (c + s * d)), (u + s * (2 * c + 3 * s * d)) / h

    def between(self, samples: Array, t: float) -> Array:
        """Return what is given at the samples (N, ...) at a time in s: linear between them."""
        flat = samples.reshape(len(self.time), -1)
        return np.array([np.interp(t, self.time, column) for column in flat.T]).reshape(samples.shape[1:])


def load(folder: str | Path) -> tuple[mujoco.MjModel, ExportedMotion]:
    """Return the model and the motion of an exported folder."""
    folder = Path(folder)
    with np.load(folder / "motion.npz") as arrays:
        motion = ExportedMotion(**arrays)
    return mujoco.MjModel.from_xml_path(str(folder / "scene.xml")), motion


def start(model: mujoco.MjModel, motion: ExportedMotion) -> mujoco.MjData:
    """Return the robot at the start of the motion."""
    data = mujoco.MjData(model)
    reset(model, data, motion)
    return data


def reset(model: mujoco.MjModel, data: mujoco.MjData, motion: ExportedMotion) -> None:
    """Put the robot to the start of the motion."""
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    data.qvel[: motion.qvel.shape[1]] = motion.qvel[0]


def control(model: mujoco.MjModel, motion: ExportedMotion, t: float) -> Array:
    """Return what the actuators are given (n,) at a time in s."""
    joints = model.actuator_trnid[:, 0]
    qpos, qvel = motion.at(t)
    kp, kv = -model.actuator_biasprm[:, 1], -model.actuator_biasprm[:, 2]
    forces = kv * qvel[model.jnt_dofadr[joints]] + motion.between(motion.load, t)
    return np.asarray(qpos[model.jnt_qposadr[joints]] + forces / kp)


def switch_welds(model: mujoco.MjModel, data: mujoco.MjData, motion: ExportedMotion) -> None:
    """Fix objects to the hands that have grasped them by now, where they are, and let go of those that are released."""
    events = zip(motion.event_time, motion.event_weld, motion.event_active, strict=True)
    now = data.time + model.opt.timestep / 2
    switched = {weld: active for t, weld, active in events if t <= now}
    for weld, active in switched.items():
        k = model.equality(weld).id
        if active and not data.eq_active[k]:
            mujoco.mj_kinematics(model, data)
            hand, held = model.eq_obj1id[k], model.eq_obj2id[k]
            back, turn, shift = np.zeros(4), np.zeros(4), np.zeros(3)
            mujoco.mju_negQuat(back, data.xquat[hand])
            mujoco.mju_mulQuat(turn, back, data.xquat[held])
            mujoco.mju_rotVecQuat(shift, data.xpos[held] - data.xpos[hand], back)
            # The anchor in the object, and the object's position and orientation in the hand.
            model.eq_data[k, :10] = np.concatenate([np.zeros(3), shift, turn])
        data.eq_active[k] = active


def step(model: mujoco.MjModel, data: mujoco.MjData, motion: ExportedMotion) -> None:
    """Simulate one step of the motion."""
    switch_welds(model, data, motion)
    data.ctrl[:] = control(model, motion, data.time)
    data.mocap_pos[:] = motion.between(motion.mocap, data.time)
    mujoco.mj_step(model, data)


def track(folder: str | Path) -> Tracking:
    """Simulate the motion of an exported folder once, and return how well the robot follows it."""
    model, motion = load(folder)
    data, reference = start(model, motion), mujoco.MjData(model)
    duration = motion.time[-1] - motion.time[0]
    steps = int(np.ceil(duration / model.opt.timestep))
    model.opt.timestep = duration / steps  # the last step ends with the motion
    hands = [i for i in range(model.nsite) if model.site(i).name.endswith("_hand")]
    touches: dict[tuple[int, int], Touch] = {}
    dofs, kv = model.jnt_dofadr[model.actuator_trnid[:, 0]], -model.actuator_biasprm[:, 2]
    joints = model.actuator_trnid[:, 0]
    limits = np.where(model.jnt_actfrclimited[joints], model.jnt_actfrcrange[joints, 1], np.inf)
    forces = np.zeros(model.nu)
    worst = error = 0.0
    for _ in range(steps):
        before = data.qvel[dofs]
        step(model, data, motion)
        # The integrator damps by the velocity at the end of the step; qfrc_actuator has that at its start.
        damped = data.qfrc_actuator[dofs] - kv * (data.qvel[dofs] - before)
        forces = np.maximum(forces, np.minimum(abs(damped), limits))
        _note_contacts(model, data, data.time - model.opt.timestep, touches)
        reference.qpos[: motion.qpos.shape[1]] = motion.at(data.time)[0]
        mujoco.mj_kinematics(model, reference)
        mujoco.mj_kinematics(model, data)
        error = float(np.linalg.norm(data.site_xpos[hands] - reference.site_xpos[hands], axis=1).max())
        worst = max(worst, error)
    mujoco.mj_forward(model, data)
    _note_contacts(model, data, data.time, touches)
    largest = {model.actuator(i).name: float(forces[i]) for i in range(model.nu)}
    off = {
        str(name): float(np.linalg.norm(data.body(name).xpos - end))
        for name, end in zip(motion.object_name, motion.object_end, strict=True)
        if np.isfinite(end).all()
    }
    return Tracking(worst, error, tuple(touches.values()), largest, off)


def _lies(model: mujoco.MjModel, pair: tuple[int, int]) -> bool:
    """Return whether two geoms are of an object and of what it may lie on: an obstacle or another object."""
    bodies = model.geom_bodyid[list(pair)]
    free = [bool((model.jnt_type[model.jnt_bodyid == body] == mujoco.mjtJoint.mjJNT_FREE).any()) for body in bodies]
    still = [body == 0 or model.body_mocapid[body] >= 0 for body in bodies]
    return any(free) and all(one or other for one, other in zip(free, still, strict=True))


def _note_contacts(
    model: mujoco.MjModel, data: mujoco.MjData, time: float, touches: dict[tuple[int, int], Touch]
) -> None:
    """Add the contacts of a state at a time in s to those known."""
    for i in range(data.ncon):
        pair, depth = (int(data.contact[i].geom1), int(data.contact[i].geom2)), -float(data.contact[i].dist)
        if depth <= RESTING and _lies(model, pair):
            continue
        known = touches.get(pair)
        if known is not None:
            touches[pair] = Touch(known.time, known.one, known.other, max(known.depth, depth))
        elif depth > 0:
            touches[pair] = Touch(time, model.geom(pair[0]).name, model.geom(pair[1]).name, depth)


def draw_paths(scene: mujoco.MjvScene, motion: ExportedMotion) -> None:
    """Add the planned paths of the hands to what is drawn."""
    shown = np.unique(np.linspace(0, len(motion.time) - 1, 150).round().astype(int))
    for path in motion.hands[shown].transpose(1, 0, 2):
        for one, other in pairwise(path):
            geom, rgba = scene.geoms[scene.ngeom], np.array([0.1, 0.1, 0.1, 0.5], np.float32)
            mujoco.mjv_initGeom(geom, mujoco.mjtGeom.mjGEOM_CAPSULE, np.zeros(3), np.zeros(3), np.zeros(9), rgba)
            mujoco.mjv_connector(geom, mujoco.mjtGeom.mjGEOM_CAPSULE, 0.006, one, other)
            scene.ngeom += 1


def play(folder: str | Path) -> None:
    """Play the motion of an exported folder in MuJoCo's viewer, in a loop, until its window is closed."""
    import mujoco.viewer

    model, motion = load(folder)
    data = start(model, motion)
    with mujoco.viewer.launch_passive(model, data, show_left_ui=False, show_right_ui=False) as viewer:
        with viewer.lock():
            draw_paths(viewer.user_scn, motion)
        while viewer.is_running():
            shown = time.monotonic()
            with viewer.lock():
                if data.time > motion.time[-1] + HOLD:
                    reset(model, data, motion)
                until = data.time + 1 / FRAMES_PER_SECOND
                while data.time < until:
                    step(model, data, motion)
            viewer.sync()
            time.sleep(max(0.0, shown + 1 / FRAMES_PER_SECOND - time.monotonic()))


def main() -> None:
    """Play or simulate the motion in this file's folder."""
    parser = argparse.ArgumentParser(description="Plays the motion beside this file in MuJoCo.")
    parser.add_argument(
        "--headless", action="store_true", help="simulate once, without a window, and print what came of it"
    )
    folder = Path(__file__).resolve().parent
    if not parser.parse_args().headless:
        play(folder)
        return
    tracking = track(folder)
    largest, final = 1e3 * tracking.largest_hand_error, 1e3 * tracking.final_hand_error
    print(f"largest error of a hand: {largest:.2f} mm, at the end {final:.2f} mm")
    for touch in tracking.contacts:
        print(f"contact: {touch.one} and {touch.other}, from {touch.time:.3f} s, up to {1e3 * touch.depth:.1f} mm deep")
    if not tracking.contacts:
        print("no contacts")
    for name, off in tracking.objects_off.items():
        print(f"{name}: {1e3 * off:.2f} mm from where it is to be")
    print("largest forces and torques of the actuators, N and N m:")
    for joint, force in tracking.largest_forces.items():
        print(f"  {joint}: {force:.1f}")


if __name__ == "__main__":
    main()
