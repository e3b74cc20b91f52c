"""Writing files: all or nothing, and refused before anything is computed where it cannot be."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from conftest import ROOT, changed
from running import Ran, assert_bad_input

from humanoid_rail import InvalidInput, Robot, Scene, Trajectory, export
from humanoid_rail import _files as files
from humanoid_rail._files import check_file, check_folder, write_file, write_files
from humanoid_rail.io.plan_folder import write_plan

SCENE = ROOT / "scenes" / "dev" / "sparse-80000.json"


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A folder with things in the way of others."""
    (tmp_path / "file").write_text("mine", encoding="utf-8")
    (tmp_path / "taken" / "summary.json").mkdir(parents=True)
    (tmp_path / "nowhere").symlink_to(tmp_path / "missing")
    (tmp_path / "circle").symlink_to(tmp_path / "circle")
    return tmp_path


def everything(folder: Path) -> list[str]:
    return sorted(str(path) for path in folder.rglob("*"))


BAD_FOLDERS = ("file", "file/below", "file/below/it", "taken", "nowhere", "circle", "x" * 300, "/proc/nothing", "")
BAD_FILES = ("file/below", "file/below/it", "taken", "circle", "x" * 300, "/proc/nothing", "", ".", "new/..")


@pytest.mark.parametrize("out", BAD_FOLDERS)
def test_a_folder_that_cannot_be_used_is_refused_before_planning(
    out: str, tree: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tree)
    monkeypatch.setattr("humanoid_rail.cli.plan.plan", None)  # planning would be an error
    before = everything(tree)
    assert_bad_input(Ran(capfd, "plan", SCENE, "--out", out), "out is ")
    assert everything(tree) == before


@pytest.mark.parametrize("out", BAD_FILES)
def test_a_file_that_cannot_be_written_is_refused(
    out: str, tree: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tree)
    before = everything(tree)
    assert_bad_input(Ran(capfd, "urdf", "-o", out), "out is ")
    assert_bad_input(Ran(capfd, "export", "no-plan", "--format", "csv", "-o", out), "out is ")
    assert everything(tree) == before


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_without_permission(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(InvalidInput, match="Permission denied"):
        check_folder(tmp_path / "new")


def test_a_disk_that_takes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Full:
        def __init__(self, dir: Path) -> None: ...

        def __enter__(self) -> Full:
            return self

        def __exit__(self, *_: object) -> None: ...

        def write(self, content: bytes) -> int:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(files, "TemporaryFile", Full)
    for check in (check_folder, check_file):
        with pytest.raises(InvalidInput, match="No space left on device"):
            check(tmp_path / "new")


@pytest.mark.parametrize("failure", [OSError("the disk is full"), KeyboardInterrupt()])
def test_nothing_is_left_behind(failure: BaseException, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write = Path.write_bytes

    def fail_at_two(path: Path, content: bytes) -> int:
        if path.name == "two":
            raise failure
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", fail_at_two)
    with pytest.raises(InvalidInput if isinstance(failure, OSError) else KeyboardInterrupt):
        write_files(tmp_path / "a" / "b" / "c", {"one": b"1", "two": b"2"})
    assert everything(tmp_path) == []
    with pytest.raises(InvalidInput if isinstance(failure, OSError) else KeyboardInterrupt):
        write_file(tmp_path / "a" / "two", b"2")
    assert everything(tmp_path) == []


def test_links_and_devices_stay_what_they_are(tmp_path: Path) -> None:
    (tmp_path / "real").write_bytes(b"old")
    (tmp_path / "link").symlink_to("real")
    write_file(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_bytes() == b"new"
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    write_file(tmp_path / "pipe", b"sent")
    assert os.read(reader, 10) == b"sent"
    assert (tmp_path / "pipe").is_fifo()
    os.close(reader)


def test_a_plan_replaces_another_one(
    robot: Robot, free: Scene, planned: Trajectory, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    write_plan(planned, robot, free, tmp_path, [("playback.html", "of another plan")])
    ran = Ran(capfd, "plan", SCENE, "--out", tmp_path, "--no-page")
    assert ran.code == 0
    assert not (tmp_path / "playback.html").exists(), "the page of another plan"
    assert f"humanoid-rail play {tmp_path}." in " ".join(ran.out.split())
    assert "playback.html" not in ran.out
    assert Ran(capfd, "verify", tmp_path).code == 0


def test_an_export_is_refused_before_it_is_made(robot: Robot, free: Scene, planned: Trajectory, tree: Path) -> None:
    bad = changed(planned, q=planned.q * float("nan"))  # which would be the error otherwise
    for format, out in (("csv", tree / "taken"), ("mujoco", tree / "file")):
        with pytest.raises(InvalidInput, match=r"^out is"):
            export(bad, robot, free, format, out)
