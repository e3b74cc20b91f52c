"""Motions of other tools in files: joints by name and in any order, units and followers checked, nothing lost."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import BPoly, CubicHermiteSpline

from humanoid_rail import InvalidInput, Kinematics, Robot, Scene, Sphere, Trajectory, export, retime, verify
from humanoid_rail.cli import commands
from humanoid_rail.cli.console import run
from humanoid_rail.io.motion_files import departure, limits_exceeded, read_motion


@pytest.fixture(scope="module")
def motion(robot: Robot, free: Scene, planned: Trajectory) -> Trajectory:
    return retime(planned, robot, free)


@pytest.fixture
def rows(motion: Trajectory) -> tuple[list[str], np.ndarray]:
    return ["t", *motion.joint_names], np.column_stack([motion.t, motion.q])


def write_csv(path: Path, header: list[str], rows: np.ndarray) -> Path:
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([header, *rows.tolist()])
    return path


@pytest.mark.parametrize("format", ["csv", "npz", "ros-json", "ros-yaml"])
def test_what_is_exported_is_verified_as_the_same_motion(
    format: str, motion: Trajectory, robot: Robot, free: Scene, tmp_path: Path
) -> None:
    path = tmp_path / f"motion.{format.removeprefix('ros-')}"
    export(motion, robot, free, format, path, **({"passive": True} if "ros" in format else {}))
    again = read_motion(path, robot)
    np.testing.assert_allclose(again.t, motion.t, atol=1e-9)
    np.testing.assert_array_equal(again.q, motion.q)
    np.testing.assert_array_equal(again.timing.velocity, motion.timing.velocity)
    np.testing.assert_array_equal(again.acceleration, motion.timing.acceleration)
    assert verify(robot, free, again).clearance_bound == pytest.approx(motion.clearance_bound, abs=1.1e-3)
    assert limits_exceeded(robot, again) == ()
    # Times in whole nanoseconds are not those of the spline to the last bit.
    assert departure(again) < 1e-8
    assert read_motion(path, robot, linear=True).timing is None


def test_columns_may_stand_in_any_order(rows: tuple[list[str], np.ndarray], robot: Robot, tmp_path: Path) -> None:
    header, table = rows
    order = np.random.default_rng(1).permutation(len(header))
    path = write_csv(tmp_path / "m.csv", [header[i] for i in order], table[:, order])
    found = read_motion(path, robot)
    np.testing.assert_array_equal(found.q, table[:, 1:])
    assert found.timing is None


def indented(text: str, by: str) -> str:
    return "".join(f"{by}{line}\n" for line in text.splitlines())


@pytest.mark.parametrize(
    ("ending", "wrapped"),
    [
        ("yaml", lambda text: f"{text}---\n"),
        ("yaml", lambda text: f"goal:\n  trajectory:\n{indented(text, '    ')}"),
        ("yaml", lambda text: f"joint_trajectory:\n{indented(text, '  ')}multi_dof_joint_trajectory: {{points: []}}\n"),
        ("yaml", lambda text: f"trajectory:\n- joint_trajectory:\n{indented(text, '    ')}"),
        ("json", lambda text: f"\ufeff{text}"),
    ],
    ids=["echo", "goal", "RobotTrajectory", "DisplayTrajectory", "byte order mark"],
)
def test_messages_are_read_as_tools_write_them(
    ending: str, wrapped: Callable[[str], str], motion: Trajectory, robot: Robot, free: Scene, tmp_path: Path
) -> None:
    path = tmp_path / f"m.{ending}"
    export(motion, robot, free, f"ros-{ending}", path)
    path.write_text(wrapped(path.read_text(encoding="utf-8")), encoding="utf-8")
    np.testing.assert_array_equal(read_motion(path, robot).q, motion.q)


def message(motion: Trajectory, time: object) -> str:
    point = {"positions": motion.q[0].tolist(), "time_from_start": time}
    return json.dumps({"joint_names": list(motion.joint_names), "points": [point]})


def of_csv(motion: Trajectory, separator: str) -> bytes:
    header, row = ["t", *motion.joint_names], [0.0, *motion.q[0].tolist()]
    return f"{separator.join(header)}\n{separator.join(map(str, row))}\n".encode()


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("m.json", lambda m: message(m, {"seconds": 1}).encode(), "time_from_start"),
        ("m.json", lambda m: message(m, "0.1").encode(), "time_from_start"),
        (
            "m.json",
            lambda m: b'{"joint_trajectory": {}, "multi_dof_joint_trajectory": {"points": [{}]}}',
            "multi_dof_joint_trajectory.points",
        ),
        ("m.csv", lambda m: of_csv(m, ";"), "commas"),
        ("m.csv", lambda m: of_csv(m, "\t"), "commas"),
        ("m.csv", lambda m: b"", "header"),
        ("m.csv", lambda m: 1000 * of_csv(m, ",").decode().encode("utf-16"), "UnicodeDecodeError"),
        ("m.csv", lambda m: b"\n" + of_csv(m, ",") + b"\n1,2\n", "line 5"),
    ],
)
def test_what_cannot_be_read_is_said_in_short(
    name: str, content: Callable[[Trajectory], bytes], said: str, motion: Trajectory, robot: Robot, tmp_path: Path
) -> None:
    (tmp_path / name).write_bytes(content(motion))
    with pytest.raises(InvalidInput, match=said) as error:
        read_motion(tmp_path / name, robot)
    assert len(str(error.value)) < 500


def test_empty_lines_and_names_as_bytes_are_read(motion: Trajectory, robot: Robot, tmp_path: Path) -> None:
    (tmp_path / "m.csv").write_bytes(of_csv(motion, ",").replace(b"\n", b"\n\n"))
    np.testing.assert_array_equal(read_motion(tmp_path / "m.csv", robot).q, motion.q[:1])
    np.savez(tmp_path / "m.npz", t=motion.t, q=motion.q, joint_names=np.array(motion.joint_names, "S"))
    np.testing.assert_array_equal(read_motion(tmp_path / "m.npz", robot).q, motion.q)


@pytest.mark.parametrize("kind", ["timedelta64[ms]", "complex", "bool"])
def test_arrays_that_are_no_real_numbers_are_refused(
    kind: str, motion: Trajectory, robot: Robot, tmp_path: Path
) -> None:
    t = (1000.0 * motion.t).astype(kind)
    np.savez(tmp_path / "m.npz", t=t, q=motion.q)
    with pytest.raises(InvalidInput, match=r"motion.t is .*real numbers"):
        read_motion(tmp_path / "m.npz", robot)


def test_followers_have_to_follow(motion: Trajectory, robot: Robot, free: Scene, tmp_path: Path) -> None:
    path = tmp_path / "m.json"
    export(motion, robot, free, "ros-json", path, passive=True)
    message = json.loads(path.read_text())
    column = message["joint_names"].index("chest_level_waist")
    message["points"][3]["positions"][column] += 0.01
    path.write_text(json.dumps({"trajectory": message}))
    with pytest.raises(InvalidInput, match=r"chest_level_waist.*row 3: it follows other joints"):
        read_motion(path, robot)


def _renamed(header: list[str], table: np.ndarray) -> tuple[list[str], np.ndarray]:
    return ["t", "rial", *header[2:]], table


def _without(header: list[str], table: np.ndarray) -> tuple[list[str], np.ndarray]:
    return header[:-1], table[:, :-1]


def _degrees(header: list[str], table: np.ndarray) -> tuple[list[str], np.ndarray]:
    return header, np.column_stack([table[:, :2], np.degrees(table[:, 2:])])


def _millimetres(header: list[str], table: np.ndarray) -> tuple[list[str], np.ndarray]:
    return header, np.column_stack([table[:, 0], 1000 * table[:, 1] + 500, table[:, 2:]])


def _untimed(header: list[str], table: np.ndarray) -> tuple[list[str], np.ndarray]:
    return header[1:], table[:, 1:]


def _nan(header: list[str], table: np.ndarray) -> tuple[list[str], np.ndarray]:
    return header, np.where(np.arange(table.size).reshape(table.shape) == 5, np.nan, table)


def _extra(header: list[str], table: np.ndarray) -> tuple[list[str], np.ndarray]:
    return [*header, "gripper"], np.column_stack([table, table[:, 0]])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (_renamed, "rial.*did you mean rail"),
        (_without, "right_elbow_pitch is missing"),
        (_degrees, "look like degrees"),
        (_millimetres, "look like millimetres"),
        (_untimed, "motion.t is missing"),
        (_nan, "finite numbers"),
        (_extra, "gripper.*joints of humanoid_rail"),
    ],
)
def test_what_does_not_fit_is_said(
    change: Callable[..., tuple[list[str], np.ndarray]],
    said: str,
    rows: tuple[list[str], np.ndarray],
    robot: Robot,
    tmp_path: Path,
) -> None:
    path = write_csv(tmp_path / "m.csv", *change(*rows))
    with pytest.raises(InvalidInput, match=said) as raised:
        read_motion(path, robot)
    assert raised.value.source == str(path)


def test_a_controller_that_uses_accelerations_departs_as_far_as_is_said(
    motion: Trajectory, robot: Robot, free: Scene, tmp_path: Path
) -> None:
    """Against the polynomials of degree five themselves."""
    path = tmp_path / "m.npz"
    rng = np.random.default_rng(2)
    t, q, v = motion.t[::20], motion.q[::20], motion.timing.velocity[::20]
    a = motion.timing.acceleration[::20] + rng.normal(0.0, 1.0, q.shape)
    np.savez(path, time=t, positions=q, velocities=v, accelerations=a)
    found = read_motion(path, robot)
    quintic = BPoly.from_derivatives(t, np.stack([q, v, a], axis=1))
    fine = np.linspace(t[0], t[-1], 40 * len(t))
    off = abs(quintic(fine) - CubicHermiteSpline(t, q, v)(fine)).max()
    assert 0.5 * departure(found) < off <= departure(found)


def test_the_command_verifies_a_file(
    motion: Trajectory, robot: Robot, free: Scene, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path, scene = tmp_path / "m.yaml", tmp_path / "scene.json"
    export(motion, robot, free, "ros-yaml", path)
    scene.write_text(free.model_dump_json(exclude_none=True))
    for more, code in (([], 0), (["--linear"], 0)):
        with pytest.raises(SystemExit) as ended:
            run(commands, ["verify", str(path), "--scene", str(scene), *more])
        assert ended.value.code == code
    blocked = free.model_dump(mode="json", exclude_none=True)
    center = motion.hands[len(motion.t) // 2, 0].tolist()
    blocked["obstacles"] = [{"type": "sphere", "center": center, "radius": 0.2}]
    scene.write_text(json.dumps(blocked))
    with pytest.raises(SystemExit) as ended:
        run(commands, ["verify", str(path), "--scene", str(scene)])
    assert ended.value.code == 1
    out, _ = capfd.readouterr()
    assert "the cubic through positions and velocities" in out
    assert "left_forearm touches obstacles[0]" in " ".join(out.split())
    with pytest.raises(SystemExit) as ended:
        run(commands, ["verify", str(path)])
    assert ended.value.code == 2
    assert "by --scene" in capfd.readouterr().err


def test_the_command_says_from_when_on_a_proof_holds(
    robot: Robot, free: Scene, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Only after 5 s is there a sample; until then a ball has gone through the robot and out of its way."""
    q = np.tile(robot.initial, (2, 1))
    hand = Kinematics(robot).hand_positions(robot.initial)[0]
    ball = Sphere(center=tuple(hand - (0.0, 0.0, 6.0)), radius=0.2, velocity=(0.0, 0.0, 3.0))
    scene = tmp_path / "scene.json"
    scene.write_text(free.model_copy(update={"obstacles": (ball,)}).model_dump_json(exclude_none=True))
    for start, said in ((0.0, "touches obstacles[0]"), (5.0, "from t = 5 s to t = 6 s")):
        path = tmp_path / "late.csv"
        rows = np.column_stack([[start, 6.0], q])
        np.savetxt(path, rows, delimiter=",", header=",".join(["t", *robot.joint_names]), comments="")
        with pytest.raises(SystemExit) as ended:
            run(commands, ["verify", str(path), "--scene", str(scene)])
        assert ended.value.code == (0 if start else 1)
        out = " ".join(capfd.readouterr().out.replace("│", "").split())
        assert said in out
        assert ("nothing is said of the time before the first sample" in out) == (start > 0.0)
