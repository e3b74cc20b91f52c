"""The page in the browser: the world with gizmos to drag, and the panel beside it. What is in it is drawn by viser."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import viser

from humanoid_rail._arrays import Array
from humanoid_rail.io.carried_robot import is_papers
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.live.obstacles import Obstacles
from humanoid_rail.live.session import SPEED, Mode, Session, Shown
from humanoid_rail.live.stage import draw, mark_target, put, set_stage
from humanoid_rail.live.triangles import triangles
from humanoid_rail.live.world import World, placed, target_rotation, turned_target
from humanoid_rail.model.library import load_robot
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.methods import METHODS
from humanoid_rail.scene.placing import placement_of
from humanoid_rail.scene.targets import Pose, Target, is_oriented, numbers_there, pointing_direction, position
from humanoid_rail.viewer.colours import PLAIN, colour_of, hand_colour
from humanoid_rail.viewer.drawing import node_name
from humanoid_rail.viewer.sizes import scale
from humanoid_rail.viewer.visual_meshes import robot_visuals

SIZES = {
    "upper arms, m": (("l_l2", "l_r2"), 0.4, 1.6, 1.0),
    "forearms, m": (("l_l3", "l_r3"), 0.4, 1.6, 1.0),
    "torso, m": (("l_t2", "l_t3"), 0.2, 1.0, 0.5),
    "radius, m": (("link_radius",), 0.0, 0.12, 0.05),
    "speed, rad/s": (("revolute_velocity",), 0.2, 4.0, 2.0),
    "acceleration, rad/s2": (("revolute_acceleration",), 1.0, 20.0, 10.0),
}
"""Arguments of the paper's robot that sliders set: from where, to where, and where they begin."""


class Page:
    """What a viser server shows of a session, to any number of browsers. What one changes the others see."""

    def __init__(self, server: viser.ViserServer, session: Session) -> None:
        self.server, self.session = server, session
        self._robot: Robot | None = None
        self._joints: dict[str, Any] = {}
        self._status, self._mode = "", session.mode
        self._chosen: tuple[int, Any] | None = None
        self._choosing = threading.Lock()
        self.targets: dict[tuple[int, str], Any] = {}
        self.numbers: dict[tuple[int, str], Any] = {}
        """The gizmo of each target, by step and hand."""
        set_stage(server, session.world)
        self._draw_world(session.world)
        self._add_panel(session.world)
        self.show(session.tick(0.0))

    def show(self, shown: Shown) -> None:
        """Show a moment."""
        robot, mode = self.session.world.robot, self.session.mode
        if robot is not self._robot:
            self._draw_robot(robot)
        if mode is not self._mode:  # also where nobody chose it
            self._mode, self.mode.value = mode, str(mode)
        if len(shown.q) != robot.n:
            return
        with self.server.atomic():
            self._move_robot(robot, shown.q)
            self.obstacles.show(shown.places, self._kinematics.stick_figure(shown.q))
        if shown.status != self._status:
            self._status = self.markdown.content = shown.status

    def _draw_robot(self, robot: Robot) -> None:
        if self._robot is not None:
            self.server.scene.remove_by_name("/robot")
        self._robot, self._data, self._kinematics = robot, robot.model.createData(), Kinematics(robot)
        self.server.scene.add_frame("/robot", show_axes=False)
        self._joints = {}
        for visual in robot_visuals(robot):
            joint = f"/robot/{node_name(visual.joint)}"
            if visual.joint not in self._joints:
                frame = self.server.scene.add_frame(joint, show_axes=False)
                self._joints[visual.joint] = frame
            rgba = PLAIN if visual.rgba is None else visual.rgba
            node = draw(
                self.server,
                f"{joint}/{node_name(visual.name)}",
                triangles(visual.shape),
                colour_of(np.array(rgba)),
                flat=isinstance(visual.shape, coal.Box),
            )
            put(node, visual.placement)

    def _move_robot(self, robot: Robot, q: Array) -> None:
        pin.forwardKinematics(robot.model, self._data, robot.full_configuration(q))
        for name, frame in self._joints.items():
            put(frame, self._data.oMi[robot.model.getJointId(name)])

    def _draw_world(self, world: World) -> None:
        self._draw_robot(world.robot)
        size = scale(world.robot)
        for number, step in enumerate(world.scene.steps):
            for i, hand in enumerate(world.robot.hands):
                if step[hand.name] is not None:
                    self._add_target(number, hand.name, i, size)
        self.obstacles = Obstacles(self.server, world.scene.obstacles, self.choose)

    @property
    def chosen(self) -> int | None:
        """The number of the obstacle that has a gizmo."""
        return None if self._chosen is None else self._chosen[0]

    def choose(self, i: int) -> None:
        """Give the obstacle of this number a gizmo, and take it from the one that has it; from this one if it has."""
        with self._choosing:
            before, self._chosen = self._chosen, None
            if before is not None:
                before[1].remove()
            if before is None or before[0] != i:
                self._chosen = i, self._obstacle_gizmo(i)

    def _add_target(self, step: int, hand: str, i: int, size: float) -> None:
        target = self.session.world.scene.steps[step][hand]
        assert target is not None
        name = f"/targets/{step}/{node_name(hand)}"
        gizmo = self.server.scene.add_transform_controls(
            name, scale=0.4 * size, disable_rotations=not is_oriented(target)
        )
        rotation = target_rotation(target)
        put(gizmo, pin.SE3(rotation, np.array(position(target))))
        steps = self.session.world.scene.steps
        number = numbers_there(steps, step, hand) if len(steps) > 1 else ""
        self.numbers[step, hand] = mark_target(
            self.server, name, rotation, hand_colour(i), size, pointed=is_directed(target), number=number
        )

        def moved(_: object) -> None:
            there = _pose(gizmo)

            def change(world: World) -> World:
                before = world.scene.steps[step][hand]
                return world.with_target(step, hand, turned_target(before, there.translation, there.rotation))

            self.session.change(change)
            self._number_targets(hand)

        gizmo.on_update(moved)
        self.targets[step, hand] = gizmo

    def _number_targets(self, hand: str) -> None:
        """Say at each target of a hand which steps have it there: two may have come together, or parted."""
        steps = self.session.world.scene.steps
        for (step, other), label in self.numbers.items():
            if other == hand and len(steps) > 1 and label.text != (said := numbers_there(steps, step, hand)):
                label.text = said

    def _obstacle_gizmo(self, i: int) -> Any:
        size = scale(self.session.world.robot)
        gizmo = self.server.scene.add_transform_controls(f"/handles/{i}", scale=0.5 * size, depth_test=False)
        put(gizmo, placement_of(self.session.world.scene.obstacles[i]))

        def moved(_: object) -> None:
            there = _pose(gizmo)

            def change(world: World) -> World:
                obstacle = placed(world.scene.obstacles[i], there.translation, there.rotation)
                return world.with_obstacle(i, obstacle)

            self.session.change(change)

        gizmo.on_update(moved)
        return gizmo

    def _add_panel(self, world: World) -> None:
        gui, session = self.server.gui, self.session
        # Sharing would open the page to others by way of a server of viser's.
        gui.configure_theme(show_share_button=False, show_logo=False)
        gui.set_panel_label(world.scene.name)
        self.mode: Any = gui.add_dropdown("mode", [str(mode) for mode in Mode], initial_value=str(session.mode))

        def chosen() -> None:
            session.set_mode(Mode(self.mode.value))
            self.mode.value = str(session.mode)  # another one, where the robot cannot follow

        self.mode.on_update(by_user(chosen))
        method = gui.add_dropdown("method", list(METHODS), initial_value=next(iter(METHODS)))
        method.on_update(by_user(lambda: session.set_method(method.value)))
        gui.add_button("Replan").on_click(lambda _: session.replan())
        speed = gui.add_slider("obstacles, m/s", 0.0, 2.0, 0.05, SPEED, hint="the fastest, when the robot follows")
        speed.on_update(by_user(lambda: session.set_obstacle_speed(speed.value)))
        self.markdown = gui.add_markdown("")
        with gui.add_folder("Joints", expand_by_default=False):
            self._add_joints(world)
        if has_sizes(world.robot):
            with gui.add_folder("Robot", expand_by_default=False):
                self._add_sizes()

    def _add_joints(self, world: World) -> None:
        robot = world.robot
        for i, (name, lower, upper) in enumerate(zip(robot.joint_names, robot.lower, robot.upper, strict=True)):
            low, high, digits = slider_range(float(lower), float(upper))
            there = round(float(np.clip(world.q[i], low, high)), digits)
            slider = self.server.gui.add_slider(name, low, high, 10.0**-digits, there)

            def moved(i: int = i, slider: Any = slider) -> None:
                def change(before: World) -> World:
                    q = np.array(before.q)
                    q[i] = np.clip(slider.value, before.robot.lower[i], before.robot.upper[i])
                    return before.at(q)

                if self.session.mode is Mode.PLAN:  # else the robot moves by itself
                    self.session.change(change)

            slider.on_update(by_user(moved))

    def _add_sizes(self) -> None:
        sliders = {
            label: self.server.gui.add_slider(label, low, high, 0.01, default)
            for label, (_, low, high, default) in SIZES.items()
        }

        def load() -> Robot:
            values = {name: sliders[label].value for label, (names, *_) in SIZES.items() for name in names}
            return load_robot(**values)

        for slider in sliders.values():
            slider.on_update(by_user(lambda: self.session.load_robot(load)))


def slider_range(lower: float, upper: float) -> tuple[float, float, int]:
    """Return the ends of a slider within limits, and to how many digits it is set: hundredths, or finer if it is short.

    A joint that cannot move has a slider of no length.
    """
    width = upper - lower
    digits = max(2, 2 - math.floor(math.log10(width))) if width > 0 else 2
    one = 10**digits
    low, high = math.ceil(one * lower) / one, math.floor(one * upper) / one
    return (low, high, digits) if width > 0 else (lower, lower, digits)


def by_user(work: Callable[[], None]) -> Callable[[Any], None]:
    """Return what calls a function for what a user did, and not for what this program set."""

    def called(event: Any) -> None:
        if event.client is not None:
            work()

    return called


def is_directed(target: Target) -> bool:
    """Return whether a target has a hand point in a direction, and nothing more."""
    return isinstance(target, Pose) and pointing_direction(target) is not None


def has_sizes(robot: Robot) -> bool:
    """Return whether sliders can set the sizes of a robot: the paper's, with the sizes at which they begin."""
    return is_papers(robot) and robot.urdf == load_robot().urdf


def _pose(handle: Any) -> pin.SE3:
    w, x, y, z = map(float, handle.wxyz)
    return pin.SE3(pin.Quaternion(w, x, y, z).normalized().matrix(), np.array(handle.position, float))
