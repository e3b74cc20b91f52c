"""The robot and its scene as MJCF, the format of MuJoCo. Needs no MuJoCo."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from itertools import combinations, product
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import coal
import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.io.mujoco.actuators import PositionActuator
from humanoid_rail.io.mujoco.inertias import mended_inertias
from humanoid_rail.io.mujoco.mjcf_bodies import (
    add_mesh_assets,
    add_robot,
    body_names,
    find,
    numbers,
    shape_attributes,
    site_size,
    underside,
)
from humanoid_rail.io.mujoco.objects import add_objects
from humanoid_rail.io.mujoco.visual_meshes import NO_MESHES, VisualMeshes
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.colors import color_bytes
from humanoid_rail.scene.obstacles import HalfSpace, Obstacle, is_moving, name_of
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.shapes import PlacedShape, placed_shapes
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.camera import viewpoint
from humanoid_rail.viewer.colours import hand_colour, rgb

TIMESTEP = 2.5e-4
"""A step of the simulation takes this long, s. With steps twice as long passive joints of light robots vibrate."""

# filterparent: the SRDF says which links may touch, not their order. equality: as stiff as MuJoCo allows, so that
# passive joints have no play.
TEMPLATE = f"""
<mujoco>
  <compiler angle="radian" autolimits="true" inertiafromgeom="false"/>
  <option timestep="{TIMESTEP!r}" integrator="implicitfast"><flag filterparent="disable"/></option>
  <statistic/>
  <visual>
    <global fovy="42" offwidth="1920" offheight="1080"/>
    <headlight ambient="0.35 0.35 0.35" diffuse="0.4 0.4 0.4" specular="0.1 0.1 0.1"/>
    <quality shadowsize="4096"/>
  </visual>
  <default>
    <equality solref="{2 * TIMESTEP!r} 1" solimp="0.9999 0.9999 0.001 0.5 2"/>
    <default class="visual"><geom group="2" contype="0" conaffinity="0"/></default>
    <default class="collision"><geom group="3" rgba="0.2 0.7 0.3 0.4"/></default>
    <default class="obstacle"><geom rgba="0.75 0.19 0.35 0.45"/></default>
    <default class="object"><geom rgba="0.90 0.68 0.20 1"/></default>
  </default>
  <asset>
    <texture type="skybox" builtin="gradient" rgb1="0.93 0.95 0.97" rgb2="0.66 0.74 0.83" width="256" height="1536"/>
    <texture name="floor" type="2d" builtin="checker" rgb1="0.82 0.84 0.86" rgb2="0.78 0.8 0.83" width="64"
             height="64"/>
    <material name="floor" texture="floor" texrepeat="1 1" texuniform="true"/>
  </asset>
  <worldbody/>
  <contact/>
  <equality/>
  <actuator/>
  <keyframe/>
</mujoco>
"""


def mjcf(
    robot: Robot,
    scene: Scene,
    trajectory: Trajectory,
    actuators: Sequence[PositionActuator],
    ctrl: Array,
    meshes: VisualMeshes = NO_MESHES,
    objects: Sequence[Obstacle] = (),
) -> str:
    """Return a motion's robot and scene as the text of an MJCF file.

    Every link of the URDF is a body, fixed ones too, with its inertia, its visual bodies (group 2) and the
    collision bodies that the robot is checked with (group 3, hidden at first). MuJoCo looks for contacts where the
    robot is checked, and nowhere else. The order of the joints is Pinocchio's. A warning says which inertias are not
    those of the URDF.

    Args:
        robot: The robot.
        scene: The scene; what moves is a mocap body, whose position is its displacement since t = 0.
        trajectory: The motion: for the keyframe `start` and the view.
        actuators: Those of the actuated joints.
        ctrl: The command that they are given at the start (n,), m and rad.
        meshes: The visual meshes; their files lie where `files` says.
        objects: What can be held: free bodies, with welds to the hands that grasp them.

    Raises:
        InvalidInput: If a collision body has no thickness, or a moment of inertia is negative.
    """
    inertias = mended_inertias(robot)
    for sentence in inertias.assumed:
        warnings.warn(sentence, stacklevel=2)
    document = ElementTree.fromstring(TEMPLATE)
    document.set("model", robot.name)
    world = find(document, "worldbody")
    _set_view(document, robot, scene, trajectory)
    if not any(isinstance(obstacle, HalfSpace) for obstacle in scene.obstacles):
        place = {"pos": numbers([0.0, 0.0, underside(robot, meshes)]), "size": "0 0 1"}
        SubElement(world, "geom", {"class": "visual"}, type="plane", material="floor", **place)
    add_mesh_assets(find(document, "asset"), robot, meshes)
    add_robot(world, robot, actuators, inertias, meshes)
    for i, (hand, end) in enumerate(zip(robot.hands, trajectory.hands[-1], strict=True)):
        rgba, size = f"{numbers(rgb(hand_colour(i)))} 0.4", numbers(site_size(robot.arm_reaches[i], 0.05))
        SubElement(world, "site", name=f"{hand.name}_end", pos=numbers(end), size=size, rgba=rgba)
    _add_obstacles(document, scene)
    _add_contacts(document, robot, scene)
    _add_coupling(find(document, "equality"), robot)
    for actuator in actuators:
        attributes = {"name": actuator.joint, "joint": actuator.joint, "kp": repr(actuator.kp), "kv": repr(actuator.kv)}
        SubElement(find(document, "actuator"), "position", attributes)
    free = add_objects(document, robot, objects, trajectory) if objects or trajectory.events else np.zeros(0)
    start = {"qpos": np.append(robot.full_configuration(trajectory.q[0]), free), "ctrl": ctrl}
    SubElement(find(document, "keyframe"), "key", {k: numbers(v) for k, v in start.items()}, name="start")
    ElementTree.indent(document)
    return ElementTree.tostring(document, encoding="unicode") + "\n"


def _set_view(document: Element, robot: Robot, scene: Scene, trajectory: Trajectory) -> None:
    middle, camera = viewpoint(robot, scene, trajectory)
    distance = float(np.linalg.norm(camera))
    # MuJoCo's own camera is 1.5 times the extent away from the centre.
    find(document, "statistic").attrib |= {"center": numbers(middle), "extent": repr(distance / 1.5)}
    # From above and behind the camera. Shadows are computed around the ray from the light's position.
    ray = np.array([*(-0.5 * camera[:2] / np.linalg.norm(camera[:2])), -1.0])
    light = SubElement(find(document, "worldbody"), "light", directional="true", diffuse="0.6 0.6 0.6")
    light.attrib |= {"dir": numbers(ray), "pos": numbers(middle - distance * ray)}
    azimuth, elevation = np.degrees([np.arctan2(-camera[1], -camera[0]), -np.arcsin(camera[2] / distance)])
    find(document, "visual/global").attrib |= {"azimuth": f"{azimuth:.1f}", "elevation": f"{elevation:.1f}"}


def _add_obstacles(document: Element, scene: Scene) -> None:
    world, assets = find(document, "worldbody"), find(document, "asset")
    for i, obstacle in enumerate(scene.obstacles):
        body = world
        if is_moving(obstacle):
            body = SubElement(world, "body", name=name_of(scene.obstacles, i), mocap="true")
        for name, placed in _pieces(scene.obstacles, i):
            shape = shape_attributes(placed)
            if isinstance(placed.shape, coal.ConvexBase):
                SubElement(assets, "mesh", name=name, vertex=numbers(np.ravel(placed.shape.points())))
                shape["mesh"] = name
            if obstacle.color is not None:
                shape["rgba"] = f"{numbers(rgb(color_bytes(obstacle.color)))} 1"
            elif isinstance(placed.shape, coal.Halfspace):
                shape |= {"material": "floor", "rgba": "1 1 1 1"}
            SubElement(body, "geom", {"class": "obstacle", "name": name, **shape})


def _pieces(obstacles: Sequence[Obstacle], i: int) -> list[tuple[str, PlacedShape]]:
    """Return the convex pieces of an obstacle and their names."""
    pieces, name = placed_shapes(obstacles[i]), name_of(obstacles, i)
    return [(name, piece) if len(pieces) == 1 else (f"{name} piece {k}", piece) for k, piece in enumerate(pieces)]


def _add_contacts(document: Element, robot: Robot, scene: Scene) -> None:
    """Exclude the pairs of links that are not checked, and ask for those that MuJoCo leaves out by itself."""
    contact, names = find(document, "contact"), body_names(robot)
    bodies, links = robot.collision_model.geometryObjects, robot.link_names
    excluded = [frozenset((pair.link, pair.other)) for pair in robot.unchecked_pairs]
    for a, b in combinations(dict.fromkeys(links), 2):
        if frozenset((a, b)) in excluded:
            SubElement(contact, "exclude", body1=names[a], body2=names[b])
    # MuJoCo looks at no pair that cannot move relative to each other, nor at parts of links that are excluded.
    for i, j in robot.self_collision_pairs:
        if bodies[i].parentJoint == bodies[j].parentJoint or frozenset((links[i], links[j])) in excluded:
            SubElement(contact, "pair", geom1=bodies[i].name, geom2=bodies[j].name)
    obstacles = [name for i in range(len(scene.obstacles)) for name, _ in _pieces(scene.obstacles, i)]
    for body, name in product((body for body in bodies if body.parentJoint == 0), obstacles):
        SubElement(contact, "pair", geom1=body.name, geom2=name)


def _add_coupling(equality: Element, robot: Robot) -> None:
    """Add the passive joints: q_full = S q + s0, in which each follows one actuated joint."""
    for joint_id, name in enumerate(list(robot.model.names)[1:], start=1):
        if name not in robot.joint_names:
            row = robot.coupling[robot.model.joints[joint_id].idx_v]
            leader = int(abs(row).argmax())
            polynomial = numbers([robot.offset[robot.model.joints[joint_id].idx_q], row[leader], 0.0, 0.0, 0.0])
            names = {"name": name, "joint1": name, "joint2": robot.joint_names[leader]}
            SubElement(equality, "joint", names, polycoef=polynomial)
