"""The playback page, opened by a real browser."""

from __future__ import annotations

import base64
import re
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import umsgpack
from conftest import ROOT, plan
from PIL import Image
from screenshot import browser_path, opened, seek

from humanoid_rail import (
    Box,
    Capsule,
    HalfSpace,
    Kinematics,
    Mesh,
    Robot,
    Scene,
    Sphere,
    Trajectory,
    load_scene,
    plan_case,
)
from humanoid_rail.viewer.camera import viewpoint
from humanoid_rail.viewer.closest_pairs import closest_of_all, closest_pairs
from humanoid_rail.viewer.colours import CLEARANCE_SCALE as SCALE
from humanoid_rail.viewer.colours import PENETRATION_COLOUR
from humanoid_rail.viewer.frames import FRAMES_PER_SECOND, HOLD
from humanoid_rail.viewer.playback import playback_html

needs_browser = pytest.mark.skipif(browser_path() is None, reason="Chromium (Debian: chromium) is not installed")


def pixels(page: Any) -> np.ndarray:
    return np.asarray(Image.open(BytesIO(page.screenshot())).convert("RGB")).astype(int)


def share(image: np.ndarray, rgb: tuple[int, int, int], tolerance: int = 40) -> float:
    """Return the share of pixels that have about this colour."""
    return float((abs(image - rgb).max(axis=2) < tolerance).mean())


def commands(page: str) -> list[dict[str, Any]]:
    """Return what a page tells meshcat to draw."""
    blobs = re.findall(r'fetch\("data:application/octet-binary;base64,([^"]+)"', page)
    return [umsgpack.unpackb(base64.b64decode(blob)) for blob in blobs]


def tracks(page: str, path: str) -> dict[str, np.ndarray]:
    """Return the values (F, k) of each animated property of a node at every frame."""
    (animation,) = [command for command in commands(page) if command["type"] == "set_animation"]
    clips = [entry["clip"] for entry in animation["animations"] if entry["path"] == f"/meshcat/world/{path}"]
    result = {}
    for track in clips[0]["tracks"] if clips else ():
        frames, values = [key["time"] for key in track["keys"]], np.array([key["value"] for key in track["keys"]])
        every = np.arange(frames[-1] + 1)
        result[track["name"]] = np.stack([np.interp(every, frames, column) for column in values.T], axis=-1)
    return result


def trace(page: str, hand: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the beads of a trace: where they are (B, 3), m, and their colours (B, 3) from 0 to 255."""
    (command,) = [c for c in commands(page) if c["type"] == "set_object" and c["path"].endswith(f"traces/{hand}")]
    attributes = command["object"]["geometries"][0]["data"]["attributes"]
    return tuple(
        np.frombuffer(attributes[name]["array"].data, np.float32).reshape(-1, 3) * factor
        for name, factor in (("position", 1.0), ("color", 255.0))
    )


def rgb(colour: int) -> list[int]:
    return [colour >> 16, colour >> 8 & 255, colour & 255]


def segment_distance(point: np.ndarray, ends: np.ndarray) -> float:
    way = ends[1] - ends[0]
    share = np.clip((point - ends[0]) @ way / (way @ way), 0.0, 1.0)
    return float(np.linalg.norm(point - ends[0] - share * way))


@pytest.fixture(scope="module")
def moving(robot: Robot, scene: Scene) -> tuple[Scene, Trajectory]:
    """A sphere that comes down between the arms, and one at rest."""
    obstacles = (
        Sphere(center=(-1.2, 1.4, 4.6), radius=0.2, velocity=(0.0, 0.1, -0.35)),
        Sphere(center=(-3.0, 0.0, 1.0), radius=0.2),
    )
    scene = scene.model_copy(update={"obstacles": obstacles})
    return scene, plan(robot, scene, "qp")


@needs_browser
def test_the_page_shows_the_robot_moving(robot: Robot, scene: Scene, tmp_path: Path) -> None:
    trajectory = plan_case(robot, 3)
    (tmp_path / "playback.html").write_text(playback_html(robot, scene, trajectory), encoding="utf-8")
    with opened(tmp_path / "playback.html") as (page, troubles):
        running = pixels(page)
        page.wait_for_timeout(1000)
        later = pixels(page)
        stills = {}
        for t in (0.0, 2.0, trajectory.duration):
            seek(page, t)
            stills[t] = pixels(page)
        seek(page, trajectory.duration + 0.5)  # where the view rests on the end
        joints = {
            name: page.evaluate(
                """name => {
                    const find = path => viewer.scene_tree.find(path).object;
                    const world = find(["meshcat", "world"]), node = find(["meshcat", "world", "robot", name]);
                    viewer.scene.updateMatrixWorld(true);
                    return world.matrixWorld.clone().invert().multiply(node.matrixWorld).elements;
                }""",
                name,
            )
            for name in [*robot.model.names][1:]
        }
        hidden = page.evaluate(
            """() => viewer.scene_tree.find(["meshcat", "world", "capsules"]).object.visible === false"""
        )
        assert hidden
        assert "certified free of contact" in page.inner_text("body")
        assert "paper" in page.title()
        assert not troubles
    assert (abs(running - later).max(axis=2) > 30).mean() > 1e-3, "the animation does not run"
    first, middle, last = stills.values()
    assert (abs(first - middle).max(axis=2) > 30).mean() > 5e-3
    assert (abs(middle - last).max(axis=2) > 30).mean() > 1e-3
    for image in stills.values():
        assert share(image, (45, 120, 210), 60) > 3e-4, "no blue arm"
        assert share(image, (240, 120, 40), 60) > 3e-4, "no orange arm"
        assert share(image, (225, 125, 160), 45) > 1e-3, "no obstacles"
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.full_configuration(trajectory.q[-1]))
    for name, elements in joints.items():
        shown = np.array(elements).reshape(4, 4).T
        np.testing.assert_allclose(shown, data.oMi[robot.model.getJointId(name)].homogeneous, atol=1e-5, err_msg=name)


@needs_browser
def test_every_kind_of_obstacle_is_drawn(robot: Robot, tmp_path: Path, cube_file: str) -> None:
    obstacles = (
        Sphere(center=(-2.0, 0.0, 2.0), radius=0.2),
        Box(center=(-2.0, 1.0, 2.0), size=(0.3, 0.4, 0.5), rpy=(0.1, 0.2, 0.3)),
        Capsule(center=(-2.0, 2.0, 2.0), radius=0.1, length=0.4, rpy=(1.0, 0.0, 0.0)),
        HalfSpace(normal=(0.0, 0.0, 1.0), offset=-0.3),
        Mesh(file=cube_file, center=(-2.0, 3.0, 2.0), scale=0.4),
    )
    targets = {"left": (0.1, -2.1, 3.1), "right": (0.1, 2.3, 3.1)}
    scene = Scene(name="<all> & more", targets=targets, obstacles=obstacles)
    (tmp_path / "page.html").write_text(playback_html(robot, scene, plan(robot, scene)), encoding="utf-8")
    with opened(tmp_path / "page.html") as (page, troubles):
        positions = [
            page.evaluate(
                """i => {
                    viewer.scene.updateMatrixWorld(true);
                    const world = viewer.scene_tree.find(["meshcat", "world"]).object;
                    const path = ["meshcat", "world", "obstacles", String(i), "0", "<object>"];
                    const mesh = viewer.scene_tree.find(path).object;
                    mesh.geometry.computeBoundingBox();
                    const at = world.matrixWorld.clone().invert().multiply(mesh.matrixWorld);
                    const box = mesh.geometry.boundingBox.applyMatrix4(at);
                    return [...box.min.toArray(), ...box.max.toArray()];
                }""",
                i,
            )
            for i in range(len(obstacles))
        ]
        assert page.title().startswith("<all> & more")
        assert page.inner_text("body").startswith("<all> & more: ")
        assert not troubles
    for obstacle, box in zip(obstacles, positions, strict=True):
        if not isinstance(obstacle, HalfSpace):
            np.testing.assert_allclose(np.add(box[:3], box[3:]) / 2, obstacle.center, atol=1e-3)
    np.testing.assert_allclose(np.subtract(positions[0][3:], positions[0][:3]), 3 * [0.4], atol=0.01)
    assert positions[3][5] == pytest.approx(-0.3, abs=0.01)
    assert positions[4][3:] == pytest.approx([-1.8, 3.2, 2.2], abs=1e-3)


def test_the_camera_is_not_behind_a_wall(robot: Robot, scene: Scene) -> None:
    trajectory = plan_case(robot, 1, dt=0.5)
    for normal in ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, -1.0, 0.0)):
        wall = HalfSpace(normal=normal, offset=-6.0)
        middle, camera = viewpoint(robot, scene.model_copy(update={"obstacles": (wall,)}), trajectory)
        assert np.dot(normal, middle + camera) > -6.0
    far = scene.model_copy(update={"obstacles": (Sphere(center=(40.0, 0.0, 3.0), radius=1.0),)})
    assert np.linalg.norm(viewpoint(robot, far, trajectory)[0] - viewpoint(robot, scene, trajectory)[0]) < 2.0


def test_no_server_is_left_behind(robot: Robot, scene: Scene) -> None:
    import psutil

    page = playback_html(robot, scene, plan_case(robot, 1, dt=0.1))
    assert "http://" not in page.split("</script>")[-2]
    children = [process.cmdline() for process in psutil.Process().children(recursive=True)]
    assert not [command for command in children if "meshcat.servers.zmqserver" in command]


def test_traces_show_the_clearance(robot: Robot, scene: Scene) -> None:
    trajectory = plan_case(robot, 1)  # from afar into a sphere
    clearance = trajectory.clearance.min(axis=1)
    page = playback_html(robot, scene, trajectory)
    for i, hand in enumerate(trajectory.hand_names):
        beads, colours = trace(page, hand)
        sample = np.linalg.norm(beads[:, None] - trajectory.hands[None, :, i], axis=2).argmin(axis=1)
        inside, far, near = clearance[sample] < -0.02, clearance[sample] > 0.52, abs(clearance[sample] - 0.05) < 0.02
        assert min(inside.sum(), far.sum(), near.sum()) > 3
        np.testing.assert_allclose(colours[inside], np.tile(rgb(PENETRATION_COLOUR), (inside.sum(), 1)), atol=0.1)
        np.testing.assert_allclose(colours[far], np.tile(rgb(SCALE[-1][1]), (far.sum(), 1)), atol=0.1)
        red, green, blue = colours[near].T
        assert (red > 200).all()
        assert (green < 140).all()
        assert (blue < 60).all()


def test_colours_of_clearances_differ_in_lightness() -> None:
    def lightness(colour: int) -> float:
        linear = (np.array(rgb(colour)) / 255) ** 2.2
        return float(116 * (linear @ [0.2126, 0.7152, 0.0722]) ** (1 / 3) - 16)

    contact, near, further, far = (lightness(colour) for _, colour in SCALE)
    assert lightness(PENETRATION_COLOUR) + 20 < contact
    assert contact + 10 < near < further - 10
    assert SCALE[0][0] == 0.0
    assert SCALE[-1][0] == 0.5
    assert far < 70, "it has to be seen on the light background"


def test_without_obstacles_traces_show_the_clearance_of_links(robot: Robot, scene: Scene) -> None:
    empty = scene.model_copy(update={"obstacles": ()})
    trajectory = plan(robot, empty)
    page = playback_html(robot, empty, trajectory)
    assert "clearance from other links" in page
    assert tracks(page, "closest/links/one")
    assert not tracks(page, "closest/obstacles/one")
    links = Kinematics(robot).measure(trajectory.q[0]).self_clearance.min()
    share = (links - SCALE[2][0]) / (SCALE[3][0] - SCALE[2][0])
    assert 0 < share < 1
    expected = (1 - share) * np.array(rgb(SCALE[2][1])) + share * np.array(rgb(SCALE[3][1]))
    np.testing.assert_allclose(trace(page, "left")[1][0], expected, atol=0.5)

    bare = replace(robot, self_collision_pairs=())
    page = playback_html(bare, empty, plan(bare, empty))
    assert "closest" not in page.split("</script>")[-1]
    assert "clearance" not in page
    left, right = (trace(page, hand)[1] for hand in ("left", "right"))
    assert len(np.unique(left, axis=0)) == len(np.unique(right, axis=0)) == 1
    assert abs(left[0] - right[0]).max() > 50


def every_obstacle(cube_file: str) -> tuple[Any, ...]:
    return (
        Sphere(center=(-1.2, 1.4, 4.6), radius=0.2, velocity=(0.0, 0.1, -0.35)),
        Box(center=(-2.0, 2.4, 3.0), size=(0.3, 0.4, 0.5), rpy=(0.1, 0.2, 0.3), velocity=(0.0, -0.1, 0.0)),
        Capsule(center=(-1.0, 3.0, 2.4), radius=0.1, length=0.4, rpy=(1.0, 0.0, 0.0)),
        HalfSpace(normal=(0.0, 0.0, 2.0), offset=-1.2, velocity=(0.0, 0.0, 0.05)),
        Mesh(file=cube_file, center=(-1.3, 0.4, 3.2), scale=0.4, velocity=(0.05, 0.0, 0.0)),
    )


@pytest.mark.parametrize("method", ["gradient-projection", "qp"])
def test_closest_pairs_are_those_of_the_kinematics(method: str, robot: Robot, scene: Scene, cube_file: str) -> None:
    scene = scene.model_copy(update={"obstacles": every_obstacle(cube_file)})
    trajectory = plan(robot, scene, method, c_kappa=0.0, c_mu=0.0)
    kinematics, times = Kinematics(robot, scene.obstacles), np.linspace(0.0, trajectory.duration, 100)
    pairs = closest_pairs(robot, scene, trajectory, times)
    assert len(pairs.obstacles) == len(pairs.links) == len(times)
    for t, obstacle, links in zip(times, *pairs, strict=True):
        q = trajectory.configuration(t)
        measured = kinematics.measure(q, t=t)
        bones = dict(zip(robot.link_names, kinematics.bones(q), strict=True))
        link = robot.link_names.index(obstacle.link)
        other = int(re.fullmatch(r"obstacles\[(\d)\] \((\w+)\)", obstacle.other)[1])
        assert obstacle.t == links.t == t
        assert obstacle.distance == pytest.approx(measured.clearance[link, other], abs=1e-6)
        assert obstacle.distance == pytest.approx(measured.clearance.min(), abs=2e-5)
        assert links.distance == pytest.approx(measured.self_clearance.min(), abs=2e-5)
        for pair in (obstacle, links):
            assert np.linalg.norm(pair.points[1] - pair.points[0]) == pytest.approx(abs(pair.distance), abs=1e-6)
            assert segment_distance(pair.points[0], bones[pair.link]) == pytest.approx(0.05, abs=1e-4)
        assert segment_distance(links.points[1], bones[links.other]) == pytest.approx(0.05, abs=1e-4)
        if other == 0:
            centre = np.array(scene.obstacles[0].center) + t * np.array(scene.obstacles[0].velocity)
            assert np.linalg.norm(obstacle.points[1] - centre) == pytest.approx(0.2, abs=1e-4)
    assert len({pair.other for pair in pairs.obstacles}) > 1
    assert (min(pair.distance for pair in pairs.obstacles) < 0) == (method == "gradient-projection")


@pytest.mark.parametrize("case", [1, 2, 3])
def test_the_closest_of_all_is_that_of_the_trajectory(case: int, robot: Robot, scene: Scene) -> None:
    trajectory = plan_case(robot, case)
    pairs = closest_pairs(robot, scene, trajectory, [0.0, trajectory.duration / 2])  # far too few
    obstacle, links = closest_of_all(robot, scene, trajectory, pairs)
    assert obstacle.distance == pytest.approx(trajectory.min_clearance, abs=1e-6)
    k = np.abs(trajectory.t - obstacle.t).argmin()
    assert trajectory.clearance[k].min() == pytest.approx(obstacle.distance, abs=1e-6)
    assert links.distance == pytest.approx(trajectory.min_clearance_self, abs=1e-3)


def test_a_contact_between_samples_is_among_the_closest(robot: Robot, scene: Scene) -> None:
    hand = plan_case(robot, 3).hands[:, 0]
    between = tuple((hand[0] + 0.12 * (hand[-1] - hand[0])).tolist())
    scene = scene.model_copy(update={"obstacles": (Sphere(center=between, radius=0.1),)})
    trajectory = plan(robot, scene, "gradient-projection", c_kappa=0.0, dt=1.0)
    assert trajectory.collision_free
    assert trajectory.certificate.contact is not None
    pairs = closest_pairs(robot, scene, trajectory, trajectory.t)
    obstacle, _ = closest_of_all(robot, scene, trajectory, pairs)
    assert obstacle.distance < 1e-5


def test_a_tie_does_not_change_the_closest_pair(robot: Robot, scene: Scene) -> None:
    trajectory = plan_case(robot, 3)  # all along it several pairs are 0.4 m apart, up to rounding
    pairs = closest_pairs(robot, scene, trajectory, trajectory.t)
    assert len({(pair.link, pair.other) for pair in pairs.links}) == 1


def test_the_animation_moves_obstacles_and_connections(robot: Robot, moving: tuple[Scene, Trajectory]) -> None:
    scene, trajectory = moving
    page = playback_html(robot, scene, trajectory)
    positions = tracks(page, "obstacles/0")[".position"]
    times = np.minimum(np.arange(len(positions)) / FRAMES_PER_SECOND, trajectory.duration)
    assert len(positions) / FRAMES_PER_SECOND > trajectory.duration + HOLD
    np.testing.assert_allclose(positions, np.outer(times, scene.obstacles[0].velocity), atol=1e-9)
    assert not tracks(page, "obstacles/1")

    kinematics = Kinematics(robot, scene.obstacles)
    for kind in ("obstacles", "links"):
        one, two = (tracks(page, f"closest/{kind}/{end}")[".position"] for end in ("one", "two"))
        line = tracks(page, f"closest/{kind}/line")
        assert len(one) == len(two) == len(positions)
        for frame in range(0, len(times), 10):
            measured = kinematics.measure(trajectory.configuration(times[frame]), t=times[frame])
            least = (measured.clearance if kind == "obstacles" else measured.self_clearance).min()
            way = two[frame] - one[frame]
            assert np.linalg.norm(way) == pytest.approx(least, abs=2e-5)
            x, y, z, w = line[".quaternion"][frame]
            ends = pin.Quaternion(w, x, y, z) * (line[".scale"][frame] * [0.0, 1.0, 0.0])
            np.testing.assert_allclose(ends, way, atol=1e-6)
            np.testing.assert_allclose(line[".position"][frame], (one[frame] + two[frame]) / 2, atol=1e-9)


@needs_browser
def test_the_browser_moves_obstacles_and_connections(
    robot: Robot, moving: tuple[Scene, Trajectory], tmp_path: Path
) -> None:
    scene, trajectory = moving
    (tmp_path / "page.html").write_text(playback_html(robot, scene, trajectory), encoding="utf-8")
    with opened(tmp_path / "page.html") as (page, troubles):
        for t in (1.0, 3.0, trajectory.duration + 1.0):
            seek(page, t)
            sphere, top, bottom, one, two = np.array(
                page.evaluate(
                    """() => {
                        viewer.scene.updateMatrixWorld(true);
                        const find = path => viewer.scene_tree.find(["meshcat", "world", ...path]).object;
                        const to_world = find([]).matrixWorld.clone().invert();
                        const place = (path, y) => {
                            const point = find([]).position.clone().set(0, y, 0);
                            return point.applyMatrix4(find(path).matrixWorld).applyMatrix4(to_world).toArray();
                        };
                        const part = name => ["closest", "obstacles", name, "2", "<object>"];
                        return [
                            place(["obstacles", "0", "0", "<object>"], 0), place(part("line"), 0.5),
                            place(part("line"), -0.5), place(part("one"), 0), place(part("two"), 0),
                        ];
                    }"""
                )
            )
            time = min(t, trajectory.duration)
            centre = np.array(scene.obstacles[0].center) + time * np.array(scene.obstacles[0].velocity)
            np.testing.assert_allclose(sphere, centre, atol=2e-3)
            (closest,) = closest_pairs(robot, scene, trajectory, [time]).obstacles
            assert closest.other == "obstacles[0] (sphere)"
            np.testing.assert_allclose([one, two], closest.points, atol=5e-3)
            np.testing.assert_allclose([bottom, top], [one, two], atol=1e-3)
            seen = page.evaluate(
                """() => {
                    const path = ["meshcat", "world", "closest", "obstacles", "one", "2", "<object>"];
                    const bead = viewer.scene_tree.find(path).object;
                    return [bead.renderOrder, bead.material.depthTest];
                }"""
            )
            assert seen == [2, False]
        assert not troubles


def test_the_caption_says_what_is_certain(robot: Robot, scene: Scene) -> None:
    page = playback_html(robot, scene, plan_case(robot, 3)).split("</script>")
    caption = next(part for part in page if "meshcat-pane" in part)
    assert "certified free of contact" in caption
    assert "not certified" not in caption
    obstacle, links = r"\w+ &ndash; obstacles\[\d\] \(sphere\), 0\.437 m at \d\.\d\d s", r"\w+ &ndash; \w+, 0\.400 m at"
    assert re.search(f"closest: {obstacle}; {links}", caption)
    for mark in ("linear-gradient", "&lt; 0", ">0<", ">0.1<", ">0.25<", "&ge; 0.5", "clearance from obstacles, m"):
        assert mark in caption

    collided = plan_case(robot, 1)
    page = playback_html(robot, scene, collided)
    t = collided.certificate.contact.t
    assert f"not certified: left_clavicle touches obstacles[0] (sphere) at {t:.2f} s" in page
    assert f"left_clavicle &ndash; obstacles[0] (sphere), {collided.min_clearance:.3f} m at 6.34 s" in page


def test_the_page_says_why_there_is_no_way(robot: Robot) -> None:
    scene = load_scene(ROOT / "scenes" / "unsolvable" / "target_in_collision-1.yaml")
    page = playback_html(robot, scene, plan(robot, scene))
    assert "target in collision after" in page
    assert "the left hand at its target would be 0.35 m inside obstacles[0] (sphere)" in page
