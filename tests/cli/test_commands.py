"""The console command `humanoid-rail`, run as a user runs it."""

from __future__ import annotations

import json
import re
import signal
from pathlib import Path

import click
import numpy as np
import pytest
from conftest import ROOT, plan
from running import Ran, assert_bad_input, ran_without_engine, started

from humanoid_rail import (
    InvalidInput,
    Mesh,
    Robot,
    Scene,
    build_urdf,
    load_robot,
    load_scene,
    plan_case,
    verify,
    write_trajectory,
)
from humanoid_rail.cli.console import run
from humanoid_rail.io.plan_folder import read_plan, write_plan

CSV_COLUMNS = 1 + 12 + 6


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan that the command made of a robot that is not the default one."""
    cwd = tmp_path_factory.mktemp("plans")
    options = ["--case", 3, "--dt", 0.05, "--link-radius", 0.02, "--out", "kept"]
    process = started("plan", *options, cwd=cwd)
    out, errors = process.communicate()
    assert (process.returncode, errors) == (0, ""), errors
    assert "humanoid-rail play kept" in out
    return cwd / "kept"


@pytest.fixture(scope="module")
def colliding(tmp_path_factory: pytest.TempPathFactory, robot: Robot, scene: Scene) -> Path:
    """Case 1 of the paper, which runs through both spheres."""
    folder = tmp_path_factory.mktemp("plans") / "colliding"
    trajectory = plan_case(robot, 1, dt=0.05)
    assert not trajectory.certified
    write_plan(trajectory, robot, scene, folder)
    return folder


def test_bad_input_is_one_line_and_exit_2(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    for arguments, said in (
        (["dance"], "command is 'dance'; valid: one of plan, play, compare, live, verify, export, robot, urdf"),
        (["--nonsense"], "--nonsense"),
        (["plan", "--method", "magic"], "method is 'magic'"),
        (["play"], "FOLDER"),
        (["play", tmp_path], "trajectory is "),
        (["verify", tmp_path / "none"], "trajectory is "),
        (["evaluate", tmp_path], "command is 'evaluate'"),
        (["verify", tmp_path, "--engine", "python"], "--engine"),
        (["plan", "--timing", "fastest"], "--timing"),
    ):
        assert_bad_input(Ran(capfd, *arguments), said)


def test_an_interrupt_is_one_line_and_exit_130(capfd: pytest.CaptureFixture[str]) -> None:
    @click.command
    def interrupted() -> None:
        raise KeyboardInterrupt

    with pytest.raises(SystemExit) as caught:
        run(interrupted, [])
    out, errors = capfd.readouterr()
    # Click ends the line of the terminal's ^C.
    assert (caught.value.code, out, errors.strip()) == (130, "", "interrupted")


def test_without_the_engine_a_command_says_in_one_line_what_to_install(folder: Path, tmp_path: Path) -> None:
    for arguments in (["plan", "--no-view"], ["verify", folder]):
        result = ran_without_engine(*arguments, cwd=tmp_path)
        assert (result.returncode, result.stdout, result.stderr.count("\n")) == (2, "", 1), result.stderr
        assert result.stderr.startswith("error: the native engine is missing: ")
        assert "--method gradient-projection --engine python" in result.stderr


def test_without_the_engine_gradient_projection_still_plans(tmp_path: Path) -> None:
    options = ["--engine", "python", "--dt", "0.1", "--out", "out", "--no-view"]
    result = ran_without_engine("plan", "--case", "3", *options, cwd=tmp_path)
    assert (result.returncode, result.stderr) == (0, "")
    assert "no: nothing can be proven without the native engine" in " ".join(result.stdout.split())
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (summary["status"], summary["certified"], summary["certificate"]) == ("reached", False, None)
    result = ran_without_engine("export", "out", "--format", "csv", "-o", "motion.csv", cwd=tmp_path)
    assert (result.returncode, result.stderr) == (0, "")
    assert "Warning: the motion is not certified: nothing can be proven without the native engine." in result.stdout


def test_a_plan_is_read_back_with_its_robot_and_its_scene(folder: Path, scene: Scene) -> None:
    found = read_plan(folder)
    assert found.scene == scene
    assert found.robot.urdf == build_urdf(link_radius=0.02)
    expected = load_robot(link_radius=0.02)
    assert found.robot.hands == expected.hands
    assert found.robot.self_collision_pairs == expected.self_collision_pairs
    np.testing.assert_array_equal(found.robot.initial, expected.initial)
    assert found.trajectory.certificate == verify(expected, scene, found.trajectory)


def test_a_scene_with_a_mesh_is_read_back_from_elsewhere(
    robot: Robot, cube_file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(Path(cube_file).parent)
    mesh = Mesh(file=Path(cube_file).name, center=(-6.0, 3.0, 3.0), rpy=(0.1, 1e-7, -0.3), scale=(1.0, 0.5, 2.0))
    text = "name: '\\u00e9\\u2028 \\U0001F916'\ntargets: {left: [0.12, -2.23, 3.2], right: [0.12, 2.23, 3.2]}\n"
    (tmp_path / "scene.yaml").write_text(text.replace("'", '"'), encoding="utf-8")
    scene = load_scene(tmp_path / "scene.yaml").model_copy(update={"obstacles": (mesh,)})
    write_plan(plan(robot, scene, dt=0.1), robot, scene, tmp_path / "out")
    monkeypatch.chdir(tmp_path)
    found = read_plan("out")
    assert found.scene.name == scene.name == "é\u2028 \U0001f916"
    assert found.scene.targets == scene.targets
    (again,) = found.scene.obstacles
    assert (again.center, again.rpy, again.scale) == (mesh.center, mesh.rpy, mesh.scale)
    assert Path(again.file).resolve() == (tmp_path / "out" / "mesh-0.stl").resolve()
    assert Path(again.file).read_bytes() == Path(cube_file).read_bytes()
    for piece, other in zip(again.pieces, mesh.pieces, strict=True):
        np.testing.assert_array_equal(piece, other)


def test_verify_proves_what_is_free_and_finds_the_contact_in_what_is_not(
    folder: Path, colliding: Path, robot: Robot, scene: Scene, capfd: pytest.CaptureFixture[str]
) -> None:
    ran = Ran(capfd, "verify", folder)
    assert (ran.code, ran.err) == (0, "")
    assert "│ yes: no clearance below" in ran.out
    ran = Ran(capfd, "verify", colliding)
    assert ran.code == 1
    contact = verify(robot, scene, read_plan(colliding).trajectory).contact
    assert contact is not None
    assert f"no: {contact.link} touches {contact.other} at" in " ".join(ran.out.replace("│", " ").split())


@pytest.mark.parametrize("name", ["motion.txt", "motion"])
def test_verify_names_the_files_that_it_reads(name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / name).write_text("t,rail\n0,0\n", encoding="utf-8")
    ran = Ran(capfd, "verify", tmp_path / name, "--scene", ROOT / "scenes" / "paper.yaml")
    assert_bad_input(ran, "a folder of a plan, or a file that ends in .csv, .npz, .json, .yaml, .yml")


def test_verify_believes_no_summary(colliding: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    for path in colliding.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    summary = json.loads((tmp_path / "summary.json").read_text())
    (tmp_path / "summary.json").write_text(json.dumps(summary | {"certified": True, "contact": None}))
    assert Ran(capfd, "verify", tmp_path).code == 1


def test_another_scene_and_another_robot_can_be_given(
    folder: Path, scene: Scene, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    robot_file = tmp_path / "robot.urdf"
    assert Ran(capfd, "urdf", "link_radius=0.45", "-o", robot_file).code == 0
    assert Ran(capfd, "verify", folder, "--robot", robot_file).code == 1
    between = {"type": "sphere", "center": [-1.0, 0.0, 3.0], "radius": 1.0}
    scene_file = tmp_path / "scene.json"
    scene_file.write_text(json.dumps({"name": "full", "targets": dict(scene.targets), "obstacles": [between]}))
    ran = Ran(capfd, "verify", folder, "--scene", scene_file)
    assert (ran.code, ran.out.split()[0]) == (1, "full")
    scene_file.write_text(json.dumps({"name": "x", "targets": {"left": [0, 0, 3]}}))
    assert_bad_input(Ran(capfd, "verify", folder, "--scene", scene_file), f"{scene_file}: targets.right is missing")
    robot_file.write_text(build_urdf().replace('"rail"', '"track"'))
    assert_bad_input(Ran(capfd, "verify", folder, "--robot", robot_file), f"{robot_file}: ")


def test_what_is_missing_from_a_folder_is_named(
    folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    write_trajectory(read_plan(folder).trajectory, tmp_path)
    assert_bad_input(Ran(capfd, "verify", tmp_path), "robot.urdf")
    (tmp_path / "robot.urdf").write_text(build_urdf())
    assert_bad_input(Ran(capfd, "verify", tmp_path), "scene.json")
    (tmp_path / "scene.json").write_text("{")
    assert_bad_input(Ran(capfd, "verify", tmp_path), "scene.json: scene is '{'; valid: JSON")
    assert Ran(capfd, "verify", tmp_path, "--scene", ROOT / "scenes" / "paper.yaml").code == 0


def test_a_scene_of_another_plan_is_not_believed(folder: Path, robot: Robot, tmp_path: Path) -> None:
    """The samples of a plan were replaced by those of another, and the scene and the robot stayed."""
    kept = read_plan(folder)
    write_plan(kept.trajectory, kept.robot, kept.scene, tmp_path)
    other = load_scene(ROOT / "scenes" / "dev" / "sparse-80000.json")
    write_trajectory(plan(robot, other), tmp_path)
    with pytest.raises(InvalidInput, match="planned for") as caught:
        read_plan(tmp_path)
    assert (caught.value.field, caught.value.value) == ("name", "paper")
    scene_file = str(ROOT / "scenes" / "dev" / "sparse-80000.json")
    assert read_plan(tmp_path, scene_file).scene == other


def test_play_serves_the_plan_until_it_is_interrupted(folder: Path, tmp_path: Path) -> None:
    process = started("play", folder, cwd=tmp_path)
    assert process.stdout is not None
    line = process.stdout.readline()
    assert re.match(r"Playing at http://127\.0\.0\.1:\d+/\S* until Ctrl-C\.", line), process.communicate()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate()
    assert (process.returncode, errors) == (0, "")


@pytest.mark.parametrize("format", ["csv", "npz", "ros-json", "ros-yaml"])
def test_export_writes_one_file(format: str, folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / f"motion.{format}"
    ran = Ran(capfd, "export", folder, "--format", format, "-o", out)
    assert (ran.code, ran.err) == (0, "")
    assert ran.out.endswith(f"Written: {out}\n")
    assert [path.name for path in tmp_path.iterdir()] == [out.name]
    t = read_plan(folder).trajectory.t
    match format:
        case "csv":
            assert np.loadtxt(out, delimiter=",", skiprows=1).shape == (len(t), CSV_COLUMNS)
        case "npz":
            with np.load(out) as arrays:
                np.testing.assert_array_equal(arrays["t"], t)
        case _:
            assert out.read_text(encoding="utf-8").count("time_from_start") == len(t)


def test_export_includes_passive_joints_if_told_to(
    folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    names = []
    for option in ("--no-passive", "--passive"):
        out = tmp_path / "motion.json"
        assert Ran(capfd, "export", folder, "--format", "ros-json", "-o", out, option).code == 0
        names.append(json.loads(out.read_text())["joint_names"])
    assert set(names[1]) - set(names[0]) == {"chest_level_waist", "chest_level_spine"}


def test_export_says_what_it_cannot_write(folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    export = ("export", folder, "--format")
    assert_bad_input(Ran(capfd, *export, "fax", "-o", tmp_path / "x"), "format is 'fax'; valid: one of csv, npz")
    assert_bad_input(Ran(capfd, *export, "csv"), "--out")
    assert_bad_input(Ran(capfd, *export, "csv", "-o", tmp_path), "out is ")
    assert not list(tmp_path.iterdir())


def test_export_at_another_rate_is_the_same_motion(
    folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    plan = read_plan(folder)
    out = tmp_path / "fast.npz"
    assert Ran(capfd, "export", str(folder), "--format", "npz", "--rate", "1000", "-o", str(out)).code == 0
    with np.load(out) as arrays:
        np.testing.assert_array_equal(arrays["q"], plan.trajectory.resample(1e-3).q)
        assert np.isin(plan.trajectory.t, arrays["t"]).all()
    assert_bad_input(Ran(capfd, "export", str(folder), "--format", "npz", "--rate", "0", "-o", str(out)), "rate is 0.0")
