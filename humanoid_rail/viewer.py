"""The meshcat view of a motion. The only module that imports meshcat."""

from __future__ import annotations

import html
import signal
import time
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from types import FrameType

import coal
import meshcat
import meshcat.geometry as mg
import meshcat.transformations as mt
import numpy as np
import pinocchio as pin
from meshcat.animation import Animation

from humanoid_rail.arrays import Array
from humanoid_rail.obstacles import HalfSpace
from humanoid_rail.robot import Robot
from humanoid_rail.scene import Scene
from humanoid_rail.shapes import PlacedShape, placed_shapes
from humanoid_rail.trajectory import Trajectory

FRAMES_PER_SECOND = 30
HOLD = 1.5
"""How long the view rests on the last configuration before the animation starts over, s."""
HAND_COLOURS = (0x1F70CC, 0xE86B1A, 0x2E9E5B, 0x8E44AD)
OBSTACLE_COLOUR = 0xD6453D
WALL_COLOUR = 0x7C8792
CAMERA = np.array([-1.45, -1.2, 0.5])
"""Where the camera is from the middle of the motion, in units of the motion's radius: before the robot's chest."""
ZOOM = 1.9
FLOOR = -0.33
"""Height of the grid: under the rail, m."""

# meshcat's cylinders lie along y, coal's and URDF's along z.
_Y_TO_Z = mt.rotation_matrix(np.pi / 2, [1, 0, 0])


def playback_html(robot: Robot, scene: Scene, trajectory: Trajectory) -> str:
    """Return a page that plays a motion back: one self-contained file, no server needed."""
    with _server() as view:
        _publish(view, robot, scene, trajectory)
        page: str = view.static_html()
    return page.replace("<title>MeshCat</title>", f"<title>{html.escape(scene.name)}: humanoid_rail</title>")


def show(
    robot: Robot,
    scene: Scene,
    trajectory: Trajectory,
    *,
    open_browser: bool = True,
    on_ready: Callable[[str], None] = lambda url: None,
) -> None:
    """Play a motion back in a browser until interrupted (Ctrl-C, or the signals TERM and HUP).

    Args:
        robot: The robot.
        scene: The scene the motion was planned in.
        trajectory: The motion.
        open_browser: Whether to open the page in the user's browser.
        on_ready: Called with the URL of the page once it is served.
    """
    with _server() as view, _interrupted_by(signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)):
        try:
            _publish(view, robot, scene, trajectory)
            on_ready(view.url())
            if open_browser:
                webbrowser.open(view.url(), new=2)
            while True:
                time.sleep(0.5)
        except KeyboardInterrupt:
            pass


@contextmanager
def _server() -> Iterator[meshcat.Visualizer]:
    """Run a meshcat server, which is a process of its own, and end it whatever happens."""
    with redirect_stdout(StringIO()):  # it announces itself
        view = meshcat.Visualizer()
    try:
        yield view
    finally:
        view.window.zmq_socket.close(linger=0)
        view.window.server_proc.kill()
        view.window.server_proc.communicate()


@contextmanager
def _interrupted_by(*signals: signal.Signals) -> Iterator[None]:
    """Let these signals end the view as Ctrl-C does."""

    def interrupt(_signal: int, _frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = {s: signal.signal(s, interrupt) for s in signals}
    try:
        yield
    finally:
        for s, handler in before.items():
            signal.signal(s, handler)


def _publish(view: meshcat.Visualizer, robot: Robot, scene: Scene, trajectory: Trajectory) -> None:
    """Send robot, scene, traces, camera and animation to a meshcat server."""
    view["/Background"].set_property("top_color", [0.93, 0.95, 0.97])
    view["/Background"].set_property("bottom_color", [0.78, 0.82, 0.86])
    view["/Axes"].set_property("visible", False)
    # meshcat's camera turns about the origin and cannot be told otherwise, so the world moves instead.
    middle, radius = _sight(trajectory, scene)
    view["/Grid"].set_transform(mt.translation_matrix([0, 0, FLOOR - middle[2]]))
    x, y, z = CAMERA * max(radius, 1.5)
    # The camera hangs in a node whose y axis points up.
    view["/Cameras/default/rotated/<object>"].set_property("position", [x, z, -y])
    view["/Cameras/default/rotated/<object>"].set_property("zoom", ZOOM)
    view = view["world"]
    view.set_transform(mt.translation_matrix(-middle))
    _draw_robot(view["robot"], robot)
    for i, obstacle in enumerate(scene.obstacles):
        colour, opacity = (WALL_COLOUR, 0.25) if isinstance(obstacle, HalfSpace) else (OBSTACLE_COLOUR, 0.45)
        for j, piece in enumerate(placed_shapes(obstacle)):
            _draw(view[f"obstacles/{i}/{j}"], piece, colour, opacity)
    for i, name in enumerate(trajectory.hand_names):
        colour = HAND_COLOURS[i % len(HAND_COLOURS)]
        _draw_target(view[f"targets/{name}"], np.array(scene.targets[name]), colour)
        _draw_trace(view[f"traces/{name}"], trajectory.hands[:, i], colour)
    view.set_animation(_animation(view, robot, trajectory), play=True, repetitions=10_000)


def _animation(view: meshcat.Visualizer, robot: Robot, trajectory: Trajectory) -> Animation:
    animation = Animation(default_framerate=FRAMES_PER_SECOND)
    data = robot.model.createData()
    frames = int(np.ceil((trajectory.duration + HOLD) * FRAMES_PER_SECOND)) + 1
    for frame in range(frames):
        t = min(frame / FRAMES_PER_SECOND, trajectory.duration)
        q = np.array([np.interp(t, trajectory.t, column) for column in trajectory.q.T])
        pin.forwardKinematics(robot.model, data, robot.full_configuration(q))
        with animation.at_frame(view, frame) as at:
            for joint in range(1, robot.model.njoints):
                at[f"robot/{robot.model.names[joint]}"].set_transform(data.oMi[joint].homogeneous)
    return animation


def _draw_robot(view: meshcat.Visualizer, robot: Robot) -> None:
    """Draw the visual geometry, each joint's under a node of its own."""
    visual = pin.buildGeomFromUrdfString(robot.model, robot.urdf, pin.GeometryType.VISUAL)
    for body in visual.geometryObjects:
        joint = robot.model.names[body.parentJoint]
        rgb = (255 * np.clip(body.meshColor[:3], 0, 1)).astype(int)
        colour = int(rgb[0]) << 16 | int(rgb[1]) << 8 | int(rgb[2])
        placement = coal.Transform3s(body.placement.rotation, body.placement.translation)
        _draw(view[f"{joint}/{body.name}"], PlacedShape(body.geometry, placement), colour, float(body.meshColor[3]))


def _draw(view: meshcat.Visualizer, placed: PlacedShape, colour: int, opacity: float) -> None:
    """Draw a coal shape where it is."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = placed.placement.getRotation(), placed.placement.getTranslation()
    material = mg.MeshPhongMaterial(color=colour, opacity=opacity, transparent=opacity < 1)
    shape = placed.shape
    match shape:
        case coal.Sphere():
            view.set_object(mg.Sphere(shape.radius), material)
        case coal.Box():
            view.set_object(mg.Box(2 * shape.halfSide), material)
        case coal.Cylinder():
            view.set_object(mg.Cylinder(2 * shape.halfLength, shape.radius), material)
            T = T @ _Y_TO_Z
        case coal.Capsule():
            view.set_object(_capsule(shape), material)
        case coal.Halfspace():
            view.set_object(mg.Box([20.0, 20.0, 0.01]), material)
            T = _plane(shape)
        case coal.ConvexBase():
            view.set_object(_hull(np.array(shape.points())), material)
        case _:
            raise TypeError(f"no picture of a {type(shape).__name__}")
    view.set_transform(T)


def _hull(points: Array) -> mg.TriangularMeshGeometry:
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    faces = hull.simplices.copy()
    corners = points[faces]
    inward = np.einsum(
        "fx,fx->f", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), hull.equations[:, :3]
    )
    faces[inward < 0] = faces[inward < 0][:, ::-1]
    return mg.TriangularMeshGeometry(points, faces)


def _capsule(shape: coal.Capsule) -> mg.TriangularMeshGeometry:
    """Return a capsule along z as the hull of points on its two half spheres."""
    azimuth, height = np.meshgrid(np.linspace(0, 2 * np.pi, 24, endpoint=False), np.linspace(-np.pi / 2, np.pi / 2, 16))
    sphere = np.stack([np.cos(height) * np.cos(azimuth), np.cos(height) * np.sin(azimuth), np.sin(height)], axis=-1)
    points = shape.radius * sphere.reshape(-1, 3)
    points[:, 2] += np.where(points[:, 2] > 0, shape.halfLength, -shape.halfLength)
    return _hull(np.unique(points.round(9), axis=0))


def _plane(shape: coal.Halfspace) -> Array:
    """Return the transform of a plate in the xy plane to the surface of a half-space."""
    T: Array = pin.SE3(
        pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), np.array(shape.n)), shape.d * np.array(shape.n)
    ).homogeneous
    return T


def _draw_target(view: meshcat.Visualizer, at: Array, colour: int) -> None:
    view["point"].set_object(mg.Sphere(0.035), mg.MeshPhongMaterial(color=colour))
    view["halo"].set_object(mg.Sphere(0.09), mg.MeshPhongMaterial(color=colour, opacity=0.3, transparent=True))
    view.set_transform(mt.translation_matrix(at))


def _draw_trace(view: meshcat.Visualizer, points: Array, colour: int) -> None:
    """Draw the path of a hand as beads, 1 cm apart."""
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    beads = np.arange(0.0, travelled[-1] + 1e-9, 0.01)
    position = np.array([np.interp(beads, travelled, column) for column in points.T])
    rgb = np.array([[colour >> 16 & 255], [colour >> 8 & 255], [colour & 255]]) / 255
    colours = np.repeat(rgb, position.shape[1], axis=1)
    view.set_object(mg.PointCloud(position.astype(np.float32), colours.astype(np.float32), size=0.05))


def _sight(trajectory: Trajectory, scene: Scene) -> tuple[Array, float]:
    """Return the middle of what is to be seen and its radius: motion, targets, obstacles and the robot below them."""
    rail = trajectory.q[:, 0]
    points = [trajectory.hands.reshape(-1, 3), np.array(list(scene.targets.values()))]
    points += [np.array([[0.0, y, z] for y in (rail.min(), rail.max()) for z in (0.0, 3.0)])]
    points += [_bounds(piece) for obstacle in scene.obstacles for piece in placed_shapes(obstacle)]
    low, high = np.vstack(points).min(axis=0), np.vstack(points).max(axis=0)
    return (low + high) / 2, float(np.linalg.norm(high - low)) / 2


def _bounds(placed: PlacedShape) -> Array:
    """Return the corners (2, 3) of the box around a shape; none (0, 3) for a half-space, which has no end."""
    if isinstance(placed.shape, coal.Halfspace):
        return np.zeros((0, 3))
    body = coal.CollisionObject(placed.shape, placed.placement)
    body.computeAABB()
    return np.array([body.getAABB().min_, body.getAABB().max_])
