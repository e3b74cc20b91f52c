"""Figures 2 to 10 of the paper, the sweep of the activation distance, times of planning. All that needs matplotlib."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, MultipleLocator, NullFormatter, PercentFormatter, StrMethodFormatter
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.model.robot import Robot
from humanoid_rail.paper.cases import SweepPoint
from humanoid_rail.scene.obstacles import Box, Sphere
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.targets import alternatives, position
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.colours import hand_colour

TORSO, OBSTACLE = "#3b4252", "#d6453d"
LINES = (*(f"#{hand_colour(i):06x}" for i in range(4)), "#5b6470")
HANDS = LINES[:2]
DASHED = (0, (2, 0.6))
AT_ENDS: dict[str, Any] = {"linewidth": 3.2, "markersize": 3}
BETWEEN: dict[str, Any] = {"linewidth": 1.4, "markersize": 1.5, "alpha": 0.22}
OUTLINE: dict[str, Any] = {"edgecolor": "black", "linewidth": 0.6}


def motion_figure(robot: Robot, scene: Scene, trajectory: Trajectory, title: str) -> Figure:
    """Return a picture of the first and the last configuration, the way between and obstacles (Figs 2, 5, 8).

    Links of a robot of capsules are the axes of these; those of others are lines from joint to joint. Obstacles other
    than spheres and boxes are left out.
    """
    figure = Figure(figsize=(7.5, 6.5))
    # Room at the left for the label of z: layouts of matplotlib do not know of labels in space.
    axes: Any = figure.add_axes((0.06, 0.0, 0.94, 0.94), projection="3d", computed_zorder=False)
    kinematics = Kinematics(robot)
    times = np.linspace(0.0, trajectory.duration, 7)
    for k, t in enumerate(times):
        at_end = k in (0, len(times) - 1)
        for colour, bone in _bones(kinematics, trajectory.configuration(t)):
            style = AT_ENDS if at_end else BETWEEN
            axes.plot(*bone.T, color=colour, marker="o", linestyle="-" if k else DASHED, **style)
    for i, name in enumerate(trajectory.hand_names):
        hand, colour = trajectory.hands[:, i], HANDS[i % len(HANDS)]
        axes.plot(*hand.T, color=colour, linewidth=1.0)
        for step in scene.steps:
            for target in (one for one in alternatives(step.get(name)) if one is not None):
                axes.scatter(*position(target), color=colour, marker="*", s=140, **OUTLINE)
    for obstacle in scene.obstacles:
        if isinstance(obstacle, Sphere):
            axes.plot_surface(*_sphere(obstacle), color=OBSTACLE, alpha=0.6, linewidth=0, shade=False)
        elif isinstance(obstacle, Box):
            axes.add_collection3d(
                Poly3DCollection(_faces(obstacle), facecolor=OBSTACLE, edgecolor=OBSTACLE, alpha=0.15)
            )
    axes.zaxis.set_rotate_label(False)
    axes.set(title=title, xlabel="x [m]", ylabel="y [m]")
    axes.set_zlabel("z [m]", rotation=90)
    low, high = np.array(axes.get_w_lims()).reshape(3, 2).T
    axes.set_box_aspect(high - low, zoom=1.12)
    spacing = min((0.2, 0.5, 1.0), key=lambda apart: abs(apart - (high - low).max() / 6))
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_major_locator(MultipleLocator(spacing))
    faces_x = trajectory.hands[..., 0].mean() > kinematics.stick_figure(robot.initial)[0, 0]
    axes.view_init(elev=22, azim=-28 if faces_x else -152)  # from in front
    figure.legend(handles=_signs(trajectory.hand_names), loc="upper right", frameon=False, fontsize=9)
    return figure


def _signs(hand_names: Sequence[str]) -> list[Line2D]:
    """Return what the lines and marks of a picture of a motion mean."""
    hands = [
        Line2D([], [], color=HANDS[i % len(HANDS)], linewidth=3.2, label="arm" if name == "hand" else f"{name} arm")
        for i, name in enumerate(hand_names)
    ]
    return [
        *hands,
        Line2D([], [], color=TORSO, linestyle=DASHED, label="start", **AT_ENDS),
        Line2D([], [], color=TORSO, label="end", **AT_ENDS),
        Line2D([], [], color=TORSO, label="between", **BETWEEN),
        Line2D([], [], color=TORSO, linewidth=1.0, label="way of a hand"),
        Line2D([], [], color="white", marker="*", markersize=12, markeredgecolor="black", label="target", linewidth=0),
        Line2D([], [], color=OBSTACLE, marker="o", markersize=9, alpha=0.6, linewidth=0, label="obstacle"),
    ]


def clearance_figure(trajectory: Trajectory, title: str) -> Figure:
    """Return the clearance of every obstacle over time (Figs 3, 6, 9)."""
    figure = Figure(figsize=(6.5, 4), layout="constrained")
    axes = figure.add_subplot()
    for i, clearance in enumerate(trajectory.clearance.T):
        axes.plot(trajectory.t, clearance, color=LINES[i % len(LINES)], label=f"obstacle {i + 1}")
    axes.axhline(0.0, color="black", linewidth=0.8)
    if trajectory.clearance.size and trajectory.clearance.min() < 0:
        axes.axhspan(1.1 * float(trajectory.clearance.min()), 0.0, color=OBSTACLE, alpha=0.12, label="penetration")
    axes.set(title=title, xlabel="t [s]", ylabel="clearance of the nearest link [m]")
    _finish(axes, trajectory)
    return figure


def manipulability_figure(trajectory: Trajectory, title: str) -> Figure:
    """Return the manipulability of the arms over time (Figs 4, 7, 10)."""
    figure = Figure(figsize=(6.5, 4), layout="constrained")
    axes = figure.add_subplot()
    axes.plot(trajectory.t, trajectory.manipulability, color=LINES[0])
    axes.set(title=title, xlabel="t [s]", ylabel=r"manipulability $\mu$ (eq. 3.4)")
    axes.set_ylim(0.0, 1.1 * float(trajectory.manipulability.max()))
    _finish(axes, trajectory, legend=False)
    return figure


def sweep_figure(sweeps: Sequence[tuple[str, Sequence[SweepPoint], tuple[float, float]]]) -> Figure:
    """Return clearance and final manipulability against the activation distance, the range of the claims shaded.

    Args:
        sweeps: For each robot a name, the points of its sweep and the range in which all claims hold, m.
    """
    figure = Figure(figsize=(4.8 * len(sweeps), 6.2), layout="constrained")
    grid = figure.subplots(2, len(sweeps), sharex=True, sharey="row", squeeze=False)
    for column, (name, points, (low, high)) in enumerate(sweeps):
        epsilon = [point.epsilon for point in points]
        above, below = grid[0, column], grid[1, column]
        for i in range(3):
            above.plot(epsilon, [p.clearance[i] for p in points], color=LINES[i], label=f"case {i + 1}")
            below.plot(epsilon, [p.manipulability[i] for p in points], color=LINES[i], label=f"case {i + 1}")
        safe = {"color": LINES[3], "linestyle": "--", "label": "case 2 by qp"}
        above.plot(epsilon, [p.safe.clearance.min() for p in points], **safe)
        below.plot(epsilon, [p.safe.manipulability[-1] for p in points], **safe)
        above.axhline(0.0, color="black", linewidth=0.8)
        for axes in (above, below):
            axes.axvspan(low, high, color=LINES[2], alpha=0.12, label=f"all claims hold: {low:.2f} to {high:.2f} m")
            axes.grid(alpha=0.3)
        above.set(title=name)
        below.set(xlabel="activation distance [m]")
        above.legend(frameon=False, fontsize=8)
    grid[0, 0].set(ylabel="least clearance [m]")
    grid[1, 0].set(ylabel=r"final manipulability $\mu$")
    return figure


def timing_figure(robot: Robot, trajectories: Mapping[str, Trajectory]) -> Figure:
    """Return velocities and accelerations of all joints over time, in units of their limits, a column per trajectory.

    Where a trajectory has no timing they are differences of its samples.

    Args:
        robot: The robot.
        trajectories: Motions by what they are called.
    """
    figure = Figure(figsize=(2.6 + 3.2 * len(trajectories), 4.6), layout="constrained")
    grid = figure.subplots(2, len(trajectories), sharex="col", squeeze=False)
    for column, (name, trajectory) in zip(grid.T, trajectories.items(), strict=True):
        t, timing = trajectory.t, trajectory.timing
        rates = (
            (np.gradient(trajectory.q, t, axis=0), np.gradient(np.gradient(trajectory.q, t, axis=0), t, axis=0))
            if timing is None
            else (timing.velocity, timing.acceleration)
        )
        for axes, rate, limit in zip(column, rates, (robot.velocity_limit, robot.acceleration_limit), strict=True):
            axes.set_prop_cycle(color=colormaps["tab20"](np.arange(20)))  # twelve that differ
            lines = axes.plot(t, rate / limit, linewidth=0.9)
            axes.axhspan(-1.0, 1.0, color="black", alpha=0.06, linewidth=0)
            # An infinite acceleration is as large as the samples are close: what matters is that it is beyond.
            axes.set_ylim(*(np.array([-1.0, 1.0]) * float(np.clip(1.1 * abs(rate / limit).max(), 1.1, 3.0))))
            _finish(axes, trajectory, legend=False)
        column[0].set_title(f"{name}, {trajectory.duration:.2f} s", fontsize=10)
        column[1].set(xlabel="time [s]")
    for axes, quantity in zip(grid[:, 0], ("velocity", "acceleration"), strict=True):
        axes.set(ylabel=f"{quantity} / its limit")
    figure.legend(lines, robot.joint_names, loc="outside right center", fontsize=8, frameon=False)
    return figure


def planning_time_figure(families: Mapping[str, Mapping[str, Sequence[float]]]) -> Figure:
    """Return for each family of scenes which share of them is planned within a time, a line per method.

    Args:
        families: Planning times by family and method, s; infinite where there is no plan that counts.
    """
    across = min(len(families), 2)
    down = -(-len(families) // across)
    figure = Figure(figsize=(0.8 + 4.2 * across, 0.7 + 2.6 * down), layout="constrained")
    grid = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    methods = list(dict.fromkeys(method for times in families.values() for method in times))
    planned = [t for times in families.values() for values in times.values() for t in values if np.isfinite(t)]
    low, high = 700.0 * min(planned, default=1e-3), 1400.0 * max(planned, default=1.0)
    for axes, (family, times) in zip(grid.flat, families.items(), strict=False):
        for method, values in times.items():
            _share_within(axes, method, 1e3 * np.array(values), high, LINES[methods.index(method) % len(LINES)])
        axes.set(xscale="log", xlim=(low, high), ylim=(-0.03, 1.05))
        axes.set_title(family, fontsize=10)
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 100 * low else (1.0,)))
        axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.yaxis.set_major_formatter(PercentFormatter(1.0))
        axes.tick_params(labelsize=8)
        axes.grid(alpha=0.3)
    handles, labels = grid.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False, fontsize=8)
    for axes in grid.flat[len(families) :]:
        axes.set_visible(False)
    figure.supxlabel("planning time, certificate included [ms]", fontsize=10)
    figure.supylabel("scenes reached and certified", fontsize=10)
    return figure


def _share_within(axes: Any, method: str, times: Array, end: float, colour: str) -> None:
    """Draw which share of times (N,) lies within a time, with a dot at the last of them and a thin line from there."""
    planned = np.sort(times[np.isfinite(times)])
    share = np.arange(len(planned) + 1) / len(times)
    x = [*planned[:1], *planned]  # the line rises from 0
    dot = {"marker": "o", "markersize": 4, "markevery": [-1] if x else []}
    axes.step(x, share[: len(x)], where="post", color=colour, label=method, **dot)
    if x:
        axes.hlines(share[-1], x[-1], end, color=colour, linewidth=0.8)


def _finish(axes: Any, trajectory: Trajectory, legend: bool = True) -> None:
    axes.set_xlim(0.0, max(trajectory.duration, 1e-3))
    axes.grid(alpha=0.3)
    if legend:
        axes.legend(frameon=False)


def _bones(kinematics: Kinematics, q: Array) -> Iterator[tuple[str, Array]]:
    """Yield the lines (2, 3) that show the links, m, each with its colour: that of the hand, or the torso's."""
    robot = kinematics.robot
    if all(isinstance(body.geometry, coal.Capsule) for body in robot.collision_model.geometryObjects):
        for name, bone in zip(robot.link_names, kinematics.bones(q), strict=True):
            yield HANDS[0] if name.startswith("left") else HANDS[1] if name.startswith("right") else TORSO, bone
        return
    model, points = robot.model, kinematics.stick_figure(q)
    colours = {joint: HANDS[i % len(HANDS)] for i, hand in enumerate(robot.hands) for joint in hand.arm}
    for joint in range(1, model.njoints):
        if parent := model.parents[joint]:
            yield colours.get(model.names[joint], TORSO), points[[parent - 1, joint - 1]]
    for i, hand in enumerate(robot.hands):
        wrist = model.frames[model.getFrameId(hand.frame)].parentJoint
        yield HANDS[i % len(HANDS)], points[[wrist - 1, model.njoints - 1 + i]]


def _faces(box: Box) -> Array:
    """Return the corners (6, 4, 3) of the faces of a box."""
    square = np.array([[1, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]]) / 2.0
    turned = np.array([np.roll(side * square, axis, axis=1) for axis in range(3) for side in (1.0, -1.0)])
    faces: Array = (turned * box.size) @ pin.rpy.rpyToMatrix(*box.rpy).T + box.center
    return faces


def _sphere(sphere: Sphere) -> Array:
    """Return the surface (3, 24, 24) of a sphere."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 24), np.linspace(0, np.pi, 24))
    surface = np.array([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
    points: Array = np.array(sphere.center)[:, None, None] + sphere.radius * surface
    return points
