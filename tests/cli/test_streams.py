"""Where what a command prints goes: nowhere, to a full disk, or to where only ASCII can be written."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT
from running import without_display

SCENE = ROOT / "scenes" / "dev" / "sparse-80000.json"
ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONIOENCODING": "ascii"}
needs_full_disk = pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")


def shell(line: str, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a line of bash in which `$rail` is the command; its exit code is that of the first command of a pipe."""
    return subprocess.run(
        ["bash", "-c", f"{line}; exit ${{PIPESTATUS[0]}}"],
        cwd=cwd,
        env={**without_display(), "rail": f"{sys.executable} -m humanoid_rail", **environment},
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )


@pytest.mark.parametrize("arguments", ["urdf", "--help", "plan --help"])
def test_nobody_reads_on(arguments: str, tmp_path: Path) -> None:
    ran = shell(f"$rail {arguments} | true", tmp_path)
    assert (ran.returncode, ran.stdout, ran.stderr) == (141, "", "")


@needs_full_disk
@pytest.mark.parametrize("arguments", ["urdf", "--help", "--version", f"plan {SCENE}"])
def test_the_disk_is_full(arguments: str, tmp_path: Path) -> None:
    ran = shell(f"$rail {arguments} > /dev/full", tmp_path)
    assert (ran.returncode, ran.stderr.count("\n")) == (1, 1), ran.stderr
    assert ran.stderr.startswith("error: stdout cannot be written to: ")


def test_stdout_is_closed(tmp_path: Path) -> None:
    ran = shell("$rail urdf >&-", tmp_path)
    assert (ran.returncode, ran.stderr) == (1, "error: stdout cannot be written to: it is closed\n")


def test_stderr_is_closed(tmp_path: Path) -> None:
    ran = shell("$rail urdf -o robot.urdf 2>&-", tmp_path)
    assert (ran.returncode, ran.stdout) == (0, "")
    assert (tmp_path / "robot.urdf").read_text(encoding="utf-8").startswith("<?xml")
    assert shell("$rail dance 2>&-", tmp_path).returncode == 2


@needs_full_disk
def test_a_plan_is_kept_although_its_report_is_lost(tmp_path: Path) -> None:
    assert shell(f"$rail plan {SCENE} --out kept --no-page > /dev/full", tmp_path).returncode == 1
    assert {path.name for path in (tmp_path / "kept").iterdir()} >= {"summary.json", "trajectory.npz", "scene.json"}


@pytest.mark.parametrize("name", ["caf\u00e9.yaml", "-x.yaml", "a b'c\nd.yaml"])
def test_names_of_any_kind_in_any_locale(name: str, tmp_path: Path) -> None:
    text = "targets: {left: [0.12, -2.23, 3.2], right: [0.12, 2.23, 3.2]}\n"
    (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "named.yaml").write_text(f"name: \u4e16\n{text}", encoding="utf-8")
    out = name.removesuffix(".yaml")
    command = [sys.executable, "-m", "humanoid_rail"]
    for arguments in (
        ["plan", "--out", out, "--", name],
        ["verify", "--", out],
        ["export", "--format", "csv", "-o", f"{out}.csv", "--", out],
        ["plan", "named.yaml"],
    ):
        ran = subprocess.run(
            [*command, *map(os.fsencode, arguments)],
            cwd=tmp_path,
            env={**without_display(), **ASCII},
            capture_output=True,
            check=False,
        )
        assert (ran.returncode, ran.stderr) == (0, b""), arguments
        ran.stdout.decode("ascii")
    assert f'"name": "{out}"'.replace("\n", "\\n") in (tmp_path / out / "scene.json").read_text(encoding="utf-8")
    assert (tmp_path / f"{out}.csv").is_file()
