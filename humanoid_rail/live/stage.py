"""Sky, floor, light, the first camera, and the marks of targets, as the page that plays motions back has them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import trimesh
import viser

from humanoid_rail._arrays import Array
from humanoid_rail.live.triangles import Triangles
from humanoid_rail.live.world import World
from humanoid_rail.viewer.camera import HALF_HEIGHT, best_view
from humanoid_rail.viewer.drawing import DIRECTION_LENGTH
from humanoid_rail.viewer.sizes import scale
from humanoid_rail.viewer.view import floor_height
from humanoid_rail.viewer.visual_meshes import robot_visuals

SKY, FLOOR, LINES = 0xE8EDF2, 0xDFE5EB, 0xBCC6D0
WIDE = 1.1
"""What the panel leaves free of a window is wider than high by this factor."""
BACK, ASIDE = 1.1, 0.2
"""The camera is farther away by this factor, as gizmos stand out; it looks past the middle by this share of half the
height of the picture, away from the panel."""
MISTY = (8.0, 45.0)
"""The floor becomes one with the sky between these distances, m; they are scaled with the robot."""


def bytes_of(colour: int) -> tuple[int, int, int]:
    """Return red, green and blue from 0 to 255."""
    red, green, blue = colour.to_bytes(3, "big")
    return red, green, blue


def set_stage(server: viser.ViserServer, world: World) -> None:
    """Draw sky, floor and light, and let browsers look from where obstacles hide the least of the robot."""
    scene, size = server.scene, scale(world.robot)
    start = world.scene.model_copy(update={"initial": tuple(world.q.tolist())})
    view = best_view(world.robot, start, wide=WIDE)
    scene.set_up_direction("+z")
    away = BACK * view.camera
    right = np.cross([0.0, 0.0, 1.0], away)
    middle = view.middle + ASIDE * HALF_HEIGHT * np.linalg.norm(away) * right / np.linalg.norm(right)
    camera = server.initial_camera
    camera.look_at, camera.position = tuple(middle.tolist()), tuple((middle + away).tolist())
    camera.fov = 2.0 * float(np.arctan(HALF_HEIGHT))
    scene.set_background_image(np.full((8, 8, 3), bytes_of(SKY), np.uint8))
    near, far = (float(np.linalg.norm(away)) + size * distance for distance in MISTY)
    scene.configure_fog(near, far, color=bytes_of(SKY))
    scene.configure_default_lights(enabled=False)
    scene.configure_environment_map("studio", environment_intensity=0.12)
    scene.add_light_hemisphere("/light/sky", sky_color=(255, 255, 255), ground_color=(169, 179, 191), intensity=1.9)
    sun = view.middle + size * np.array([1.5, -1.0, 4.0])
    scene.add_light_directional(
        "/light/sun", color=(255, 246, 232), intensity=1.8, cast_shadow=True, position=tuple(sun.tolist())
    )
    height = floor_height(world.robot, world.scene, robot_visuals(world.robot))
    scene.add_grid(
        "/floor",
        infinite_grid=True,
        cell_size=size,
        cell_thickness=0.6,
        section_size=5.0 * size,
        section_thickness=0.6,
        cell_color=bytes_of(LINES),
        section_color=bytes_of(LINES),
        plane_color=bytes_of(FLOOR),
        plane_opacity=1.0,
        fade_distance=far,
        position=(0.0, 0.0, height),
    )


def mark_target(
    server: viser.ViserServer, name: str, rotation: Array, colour: int, size: float, *, pointed: bool, number: str
) -> Any:
    """Draw a target at the origin of a node: a ball, a cone whose tip comes along x if pointed, and a number below it.

    The node is turned by the rotation (3, 3). The label of the number is returned.
    """
    scene, paint = server.scene, bytes_of(colour)
    scene.add_icosphere(f"{name}/ball", radius=0.035 * size, color=paint)
    scene.add_icosphere(f"{name}/halo", radius=0.09 * size, color=paint, opacity=0.3, cast_shadow=False)
    if pointed:
        length = DIRECTION_LENGTH * size
        cone = trimesh.creation.cone(radius=0.04 * size, height=length)
        turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])).matrix()
        cone.apply_transform(pin.SE3(turn, np.array([-length, 0.0, 0.0])).homogeneous)
        mesh = Triangles(np.array(cone.vertices), np.array(cone.faces))
        draw(server, f"{name}/direction", mesh, colour)
    below = rotation.T @ np.array([0.0, 0.0, -0.1 * size])
    place = tuple(below.tolist())
    return scene.add_label(f"{name}/number", number, position=place, anchor="top-center", visible=bool(number))


def draw(
    server: viser.ViserServer | viser.ClientHandle,
    name: str,
    mesh: Triangles,
    colour: int,
    opacity: float | None = None,
    flat: bool = False,
) -> Any:
    """Draw triangles in a colour, in all browsers or in one; flat ones have edges."""
    return server.scene.add_mesh_simple(
        name,
        mesh.vertices,
        mesh.faces,
        color=bytes_of(colour),
        opacity=opacity,
        flat_shading=flat,
        side="double",
        cast_shadow=opacity is None,
    )


def put(handle: Any, placement: pin.SE3) -> None:
    """Put a node somewhere."""
    handle.position = tuple(placement.translation.tolist())
    x, y, z, w = pin.Quaternion(placement.rotation).coeffs().tolist()
    handle.wxyz = (w, x, y, z)
