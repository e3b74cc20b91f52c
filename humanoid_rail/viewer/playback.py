"""The meshcat view of a motion. The only module that imports meshcat.

Shown are the robot and what is in its way as they move, the hands' traces coloured by clearance, and lines between the
nearest points of the closest bodies.
"""

from __future__ import annotations

import html
import signal
import threading
import time
import webbrowser
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from itertools import combinations, product
from types import FrameType
from typing import Any

import coal
import meshcat
import meshcat.geometry as mg
import meshcat.transformations as mt
import numpy as np
import pinocchio as pin
from meshcat.animation import Animation, AnimationFrameVisualizer
from scipy.spatial import ConvexHull

from humanoid_rail._arrays import Array
from humanoid_rail.viewer.camera import ZOOM, sight
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.viewer.closest_pairs import Closest, ClosestPairs, closest_of_all, closest_pairs
from humanoid_rail.viewer.colours import hand_colour, rgb
from humanoid_rail.scene.obstacles import HalfSpace, is_moving
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.shapes import PlacedShape, placed_shapes
from humanoid_rail.scene.targets import direction, position
from humanoid_rail.trajectory import Status, Trajectory

FRAMES_PER_SECOND = 30
HOLD = 1.5
"""How long the view rests on the last configuration before the animation starts over, s."""
THORN = 0.45
"""Length of what shows in which direction a hand has to point, m."""
OBSTACLE_COLOUR = 0xC0305A
WALL_COLOUR = 0x7C8792
CLOSEST_COLOUR = 0x11151C
ENDS = ("one", "two")
"""Nodes of the beads at the nearest points of a closest pair."""
SCALE = ((0.0, 0xD7191C), (0.1, 0xF07F1B), (0.25, 0xEFBF1D), (0.5, 0x6F9DBF))
"""Colours of the traces by clearance in m, linear in between: alarming near contact, calm from afar.

Red, orange and yellow differ in lightness, and blue from them in hue, also for eyes that do not tell red from green."""
PENETRATION_COLOUR = 0x4A0014
"""Of the traces where the clearance is negative."""
FLOOR = -0.33
"""Height of the grid: under the rail, m."""

# meshcat's cylinders lie along y, coal's and URDF's along z.
_Y_TO_Z = mt.rotation_matrix(np.pi / 2, [1, 0, 0])


def playback_html(robot: Robot, scene: Scene, trajectory: Trajectory) -> str:
    """Return a page that plays a motion back: one self-contained file, no server needed."""
    pairs = closest_pairs(robot, scene, trajectory, _moments(trajectory))
    with _server() as view:
        _publish(view, robot, scene, trajectory, pairs)
        page: str = view.static_html()
    caption = _caption(trajectory, scene.name, closest_of_all(robot, scene, trajectory, pairs))
    head, body = "<title>MeshCat</title>", '<div id="meshcat-pane">'
    page = page.replace(head, f"<title>{html.escape(scene.name)}: humanoid_rail</title>", 1)
    return page.replace(body, caption + body, 1)


def _caption(trajectory: Trajectory, name: str, closest: Sequence[Closest]) -> str:
    """Return what the page says of the motion, as HTML."""
    limits = "within limits" if trajectory.limits_ok else "beyond joint limits"
    status = trajectory.status.replace("_", " ")
    ended = "in" if trajectory.status is Status.REACHED else "after"
    said = f"{status} {ended} {trajectory.duration:.2f} s, {_proof(trajectory.certificate)}, {limits}"
    why = "" if trajectory.status is Status.REACHED else html.escape(trajectory.reason)
    pairs = "; ".join(
        f"{html.escape(pair.link)} &ndash; {html.escape(pair.other)}, {pair.distance:.3f} m at {pair.t:.2f} s"
        for pair in closest
    )
    hands = " ".join(
        f'<span style="color:#{hand_colour(i):06x}">&#9679;</span> {html.escape(hand)}'
        for i, hand in enumerate(trajectory.hand_names)
    )
    lines = [
        f"<b>{html.escape(name)}</b>: {html.escape(said)}",
        why,
        f'<span style="color:#{CLOSEST_COLOUR:06x}">&#9679;&#8212;&#9679;</span> closest: {pairs}' if pairs else "",
        f"{hands}{_legend(trajectory, closest)}",
        '<span style="color:#6b7684">Drag to turn, scroll to zoom; pause and time under Open Controls.</span>',
    ]
    return (
        '<div style="position:fixed;left:8px;top:6px;max-width:70vw;padding:6px 10px;border-radius:6px;'
        'background:rgba(245,248,251,0.45);font:14px/1.5 sans-serif;color:#2e3440;pointer-events:none">'
        f"{''.join(f'<div>{line}</div>' for line in lines if line)}</div>"
    )


def _proof(certificate: Certificate) -> str:
    """Return in a few words what is proven of a motion."""
    if certificate.certified:
        return "certified free of contact"
    contact = certificate.contact
    return "not certified" + (f": {contact.link} touches {contact.other} at {contact.t:.2f} s" if contact else "")


def _legend(trajectory: Trajectory, closest: Sequence[Closest]) -> str:
    """Return what the colours of the traces mean, as HTML: a bar with numbers in m; empty where they mean nothing."""
    if not closest:
        return ""
    of = "obstacles" if trajectory.clearance.size else "other links"
    zero, far = 18.0, SCALE[-1][0]  # the share of penetration, in per cent of the bar
    at = [zero + (100 - zero) * clearance / far for clearance, _ in SCALE]
    colours = [f"#{colour:06x} {x:g}%" for x, (_, colour) in zip(at, SCALE, strict=True)]
    stops = ",".join([f"#{PENETRATION_COLOUR:06x} {zero:g}%", *colours])
    marks = ["&lt; 0", *(f"{clearance:g}" for clearance, _ in SCALE[:-1]), f"&ge; {far:g}"]
    label = "position:absolute;top:11px;transform:translateX(-50%);white-space:nowrap;font-size:11px;line-height:1"
    numbers = "".join(
        f'<span style="{label};left:{x:g}%">{mark}</span>' for x, mark in zip([zero / 2, *at], marks, strict=True)
    )
    return (
        f'<span style="margin-left:20px">traces: clearance from {of}, m</span><span style="display:inline-block;'
        "position:relative;width:250px;height:9px;margin:0 16px 10px 10px;vertical-align:middle;"
        f'background:linear-gradient(to right,{stops})">{numbers}</span>'
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
            _publish(view, robot, scene, trajectory, closest_pairs(robot, scene, trajectory, _moments(trajectory)))
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


def _publish(view: meshcat.Visualizer, robot: Robot, scene: Scene, trajectory: Trajectory, pairs: ClosestPairs) -> None:
    """Send robot, scene, traces, closest pairs, camera and animation to a meshcat server."""
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
    clearance = _clearance(trajectory, pairs)
    for number, step in enumerate(scene.steps):
        for i, name in enumerate(trajectory.hand_names):
            if (target := step[name]) is not None:
                towards = direction(target, robot.hands[i].pointing)
                _draw_target(view[f"targets/{number}/{name}"], np.array(position(target)), towards, hand_colour(i))
    for i, name in enumerate(trajectory.hand_names):
        colours = np.tile(rgb(hand_colour(i)), (len(trajectory.t), 1)) if clearance is None else _colours(clearance)
        _draw_trace(view[f"traces/{name}"], trajectory.hands[:, i], colours)
    shown = [kind for kind, closest in pairs._asdict().items() if closest]
    for kind in shown:
        # Some links are never far from each other; obstacles matter more.
        _draw_connection(view[f"closest/{kind}"], strong=kind == shown[0])
    view.set_animation(_animation(view, robot, scene, trajectory, pairs), play=True, repetitions=10_000)


def _moments(trajectory: Trajectory) -> Array:
    """Return the time in the motion of each frame of the animation (F,), s: at the end all rests."""
    frames = int(np.ceil((trajectory.duration + HOLD) * FRAMES_PER_SECOND)) + 1
    return np.minimum(np.arange(frames) / FRAMES_PER_SECOND, trajectory.duration)


def _animation(
    view: meshcat.Visualizer, robot: Robot, scene: Scene, trajectory: Trajectory, pairs: ClosestPairs
) -> Animation:
    animation = Animation(default_framerate=FRAMES_PER_SECOND)
    data = robot.model.createData()
    moments = _moments(trajectory)
    for frame, t in enumerate(moments):
        pin.forwardKinematics(robot.model, data, robot.full_configuration(trajectory.configuration(t)))
        with animation.at_frame(view, frame) as at:
            for joint in range(1, robot.model.njoints):
                for tree in ("robot", "capsules"):
                    at[f"{tree}/{robot.model.names[joint]}"].set_transform(data.oMi[joint].homogeneous)
            for kind, closest in pairs._asdict().items():
                if closest:
                    _move_connection(at[f"closest/{kind}"], closest[frame].points)
    moving = [(i, np.array(obstacle.velocity)) for i, obstacle in enumerate(scene.obstacles) if is_moving(obstacle)]
    end = int(np.argmax(moments))
    # In between they move evenly.
    for frame in sorted({0, max(end - 1, 0), end, len(moments) - 1}):
        with animation.at_frame(view, frame) as at:
            for i, velocity in moving:
                at[f"obstacles/{i}"].set_property("position", "vector3", (moments[frame] * velocity).tolist())
    return animation


def _clearance(trajectory: Trajectory, pairs: ClosestPairs) -> Array | None:
    """Return what the traces show (N,), m: from obstacles; without any between links; None without both."""
    if trajectory.clearance.size:
        nearest: Array = trajectory.clearance.min(axis=1)
        return nearest
    if not pairs.links:
        return None
    return np.interp(trajectory.t, [pair.t for pair in pairs.links], [pair.distance for pair in pairs.links])


def _colours(clearance: Array) -> Array:
    """Return the colours (..., 3) of clearances in m, red, green and blue from 0 to 1."""
    at, colours = [x for x, _ in SCALE], np.array([rgb(colour) for _, colour in SCALE])
    scaled = np.stack([np.interp(clearance, at, channel) for channel in colours.T], axis=-1)
    return np.where((clearance < 0)[..., None], rgb(PENETRATION_COLOUR), scaled)


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


def _draw_target(view: meshcat.Visualizer, at: Array, towards: Array | None, colour: int) -> None:
    """Draw a target, and a thorn towards it along the direction in which the hand has to point, if there is one."""
    view["point"].set_object(mg.Sphere(0.035), mg.MeshPhongMaterial(color=colour))
    view["halo"].set_object(mg.Sphere(0.09), mg.MeshPhongMaterial(color=colour, opacity=0.3, transparent=True))
    if towards is not None:
        view["thorn"].set_object(
            mg.Cylinder(THORN, radiusTop=0.0, radiusBottom=0.04), mg.MeshPhongMaterial(color=colour)
        )
        turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 1.0, 0.0]), towards).matrix()
        view["thorn"].set_transform(pin.SE3(turn, -THORN / 2 * towards).homogeneous)
    view.set_transform(mt.translation_matrix(at))


def _draw_trace(view: meshcat.Visualizer, points: Array, colours: Array) -> None:
    """Draw the path of a hand as beads, 1 cm apart, from its points (N, 3) and their colours (N, 3)."""
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    beads = np.arange(0.0, travelled[-1] + 1e-9, 0.01)
    position = np.array([np.interp(beads, travelled, column) for column in points.T])
    colour = np.array([np.interp(beads, travelled, column) for column in colours.T])
    view.set_object(mg.PointCloud(position.astype(np.float32), colour.astype(np.float32), size=0.05))


class _OnTop(mg.Mesh):  # type: ignore[misc]  # meshcat has no types
    """A mesh of one colour that is seen through everything else."""

    def __init__(self, geometry: mg.Geometry, colour: int, order: int) -> None:
        super().__init__(geometry, mg.MeshBasicMaterial(color=colour, transparent=True, depthTest=False))
        self._order = order

    def lower(self) -> dict[str, Any]:
        data: dict[str, Any] = super().lower()
        data["object"]["renderOrder"] = self._order
        return data


def _draw_connection(view: meshcat.Visualizer, strong: bool) -> None:
    """Draw a line of length 1 and two beads at its ends, which :func:`_move_connection` puts in place.

    They are seen through bodies, or else they would be hidden where it matters: where two touch. White around it sets a
    strong one off from what is dark.
    """
    line, bead = (0.008, 0.025) if strong else (0.005, 0.016)
    layers = [(0.008, 0xFFFFFF)] if strong else []
    for order, (around, colour) in enumerate([*layers, (0.0, CLOSEST_COLOUR)], start=1):
        view[f"line/{order}"].set_object(_OnTop(mg.Cylinder(1.0, line + around), colour, order))
        for end in ENDS:
            view[f"{end}/{order}"].set_object(_OnTop(mg.Sphere(bead + around), colour, order))


def _move_connection(at: AnimationFrameVisualizer, points: Array) -> None:
    """Put a connection between two points (2, 3) in a frame of the animation."""
    for end, point in zip(ENDS, points, strict=True):
        at[end].set_property("position", "vector3", point.tolist())
    way = points[1] - points[0]
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 1.0, 0.0]), way)
    at["line"].set_property("position", "vector3", points.mean(axis=0).tolist())
    at["line"].set_property("quaternion", "quaternion", turn.coeffs().tolist())
    at["line"].set_property("scale", "vector3", [1.0, max(float(np.linalg.norm(way)), 1e-4), 1.0])
