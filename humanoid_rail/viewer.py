"""The meshcat view of a motion. The only module that imports meshcat."""

from __future__ import annotations

import html
import signal
import threading
import time
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from itertools import combinations, product
from types import FrameType

import coal
import meshcat
import meshcat.geometry as mg
import meshcat.transformations as mt
import numpy as np
import pinocchio as pin
from meshcat.animation import Animation
from scipy.spatial import ConvexHull

from humanoid_rail.arrays import Array
from humanoid_rail.camera import ZOOM, sight
from humanoid_rail.obstacles import HalfSpace
from humanoid_rail.robot import Robot
from humanoid_rail.scene import Scene
from humanoid_rail.shapes import PlacedShape, placed_shapes
from humanoid_rail.trajectory import Trajectory

FRAMES_PER_SECOND = 30
HOLD = 1.5
"""How long the view rests on the last configuration before the animation starts over, s."""
HAND_COLOURS = (0x1F70CC, 0xE86B1A, 0x2E9E5B, 0x8E44AD)
OBSTACLE_COLOUR = 0xC0305A
WALL_COLOUR = 0x7C8792
FLOOR = -0.33
"""Height of the grid: under the rail, m."""

# meshcat's cylinders lie along y, coal's and URDF's along z.
_Y_TO_Z = mt.rotation_matrix(np.pi / 2, [1, 0, 0])


def playback_html(robot: Robot, scene: Scene, trajectory: Trajectory) -> str:
    """Return a page that plays a motion back: one self-contained file, no server needed."""
    with _server() as view:
        _publish(view, robot, scene, trajectory)
        page: str = view.static_html()
    head, body = "<title>MeshCat</title>", '<div id="meshcat-pane">'
    page = page.replace(head, f"<title>{html.escape(scene.name)}: humanoid_rail</title>", 1)
    return page.replace(body, _caption(scene, trajectory) + body, 1)


def _caption(scene: Scene, trajectory: Trajectory) -> str:
    """Return what the page says of the motion, as HTML."""
    outcome = "collision-free" if trajectory.collision_free else "in collision"
    clearance = "" if trajectory.min_clearance is None else f" (least clearance {trajectory.min_clearance:.3f} m)"
    limits = "within limits" if trajectory.limits_ok else "beyond joint limits"
    said = f"{trajectory.status} in {trajectory.duration:.2f} s, {outcome}{clearance}, {limits}"
    hands = " ".join(
        f'<span style="color:#{_hand_colour(i):06x}">&#9679;</span> {html.escape(name)}'
        for i, name in enumerate(trajectory.hand_names)
    )
    return (
        '<div style="position:fixed;left:16px;top:12px;max-width:70vw;font:14px/1.5 sans-serif;color:#2e3440;'
        f'pointer-events:none"><b>{html.escape(scene.name)}</b>: {said}<br>{hands}<br>'
        '<span style="color:#6b7684">Drag to turn, scroll to zoom; pause and time under Open Controls.</span></div>'
    )


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
    with _server() as view, _interruptible():
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
def _interruptible() -> Iterator[None]:
    """Let INT, TERM and HUP raise KeyboardInterrupt, INT also where a shell has it ignored, as for background jobs."""

    def interrupt(_signal: int, _frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    signals = {signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)}
    if threading.current_thread() is not threading.main_thread():
        signals = set()  # Python lets only the main thread handle them
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
    middle, camera = sight(robot, scene, trajectory)
    view["/Grid"].set_transform(mt.translation_matrix([0, 0, FLOOR - middle[2]]))
    x, y, z = camera
    # The camera hangs in a node whose y axis points up.
    view["/Cameras/default/rotated/<object>"].set_property("position", [x, z, -y])
    view["/Cameras/default/rotated/<object>"].set_property("zoom", ZOOM)
    view = view["world"]
    view.set_transform(mt.translation_matrix(-middle))
    visual = pin.buildGeomFromUrdfString(robot.model, robot.urdf, pin.GeometryType.VISUAL)
    _draw_bodies(view["robot"], robot, visual)
    _draw_bodies(view["capsules"], robot, robot.collision_model)
    view["capsules"].set_property("visible", False)
    for i, obstacle in enumerate(scene.obstacles):
        colour, opacity = (WALL_COLOUR, 0.2) if isinstance(obstacle, HalfSpace) else (OBSTACLE_COLOUR, 0.35)
        for j, piece in enumerate(placed_shapes(obstacle)):
            _draw(view[f"obstacles/{i}/{j}"], piece, colour, opacity)
            if isinstance(piece.shape, coal.Box):
                edges = mg.PointsGeometry(_edges(piece.shape).astype(np.float32))
                material = mg.LineBasicMaterial(OBSTACLE_COLOUR)
                view[f"obstacles/{i}/{j}/edges"].set_object(mg.LineSegments(edges, material))
    for i, name in enumerate(trajectory.hand_names):
        _draw_target(view[f"targets/{name}"], np.array(scene.targets[name]), _hand_colour(i))
        _draw_trace(view[f"traces/{name}"], trajectory.hands[:, i], _hand_colour(i))
    view.set_animation(_animation(view, robot, trajectory), play=True, repetitions=10_000)


def _animation(view: meshcat.Visualizer, robot: Robot, trajectory: Trajectory) -> Animation:
    animation = Animation(default_framerate=FRAMES_PER_SECOND)
    data = robot.model.createData()
    frames = int(np.ceil((trajectory.duration + HOLD) * FRAMES_PER_SECOND)) + 1
    for frame in range(frames):
        q = trajectory.configuration(frame / FRAMES_PER_SECOND)
        pin.forwardKinematics(robot.model, data, robot.full_configuration(q))
        with animation.at_frame(view, frame) as at:
            for joint in range(1, robot.model.njoints):
                for tree in ("robot", "capsules"):
                    at[f"{tree}/{robot.model.names[joint]}"].set_transform(data.oMi[joint].homogeneous)
    return animation


def _hand_colour(i: int) -> int:
    return HAND_COLOURS[i % len(HAND_COLOURS)]


def _draw_bodies(view: meshcat.Visualizer, robot: Robot, bodies: pin.GeometryModel) -> None:
    """Draw the bodies of a robot, each joint's under a node of its own, which the animation moves."""
    for body in bodies.geometryObjects:
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


def _edges(box: coal.Box) -> Array:
    """Return the twelve edges of a box as pairs of points (3, 24)."""
    corners = np.array(list(product((-1, 1), repeat=3))) * box.halfSide
    pairs = [(a, b) for a, b in combinations(range(8), 2) if (corners[a] != corners[b]).sum() == 1]
    edges: Array = corners[np.array(pairs).ravel()].T
    return edges


def _hull(points: Array) -> mg.TriangularMeshGeometry:
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
