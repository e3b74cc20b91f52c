"""The scripts, run as a user runs them."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from urllib.error import URLError
from urllib.request import urlopen

import numpy as np
import pytest
from conftest import ROOT

OUTPUTS = {"trajectory.npz", "trajectory.csv", "summary.json", "playback.html", "scene.json", "robot.urdf"}


def command(script: str, *arguments: str) -> list[str]:
    return [sys.executable, str(ROOT / "scripts" / f"{script}.py"), *arguments]


def script(name: str, *arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
    return subprocess.run(
        command(name, *arguments), cwd=cwd, env=environment, capture_output=True, text=True, check=False
    )


def test_plan_a_case(tmp_path: Path) -> None:
    result = script("plan", "--case", "3", "--out", "out", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    assert "reached" in result.stdout
    assert "playback.html" in result.stdout  # how to see it
    assert {path.name for path in (tmp_path / "out").iterdir()} == OUTPUTS
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["duration"] == pytest.approx(6.3355, abs=1e-3)
    with np.load(tmp_path / "out" / "trajectory.npz") as arrays:
        assert arrays["q"].shape == (635, 12)


def test_plan_a_scene_file_with_every_option(tmp_path: Path) -> None:
    arguments = ["--method", "gradient-projection", "--epsilon", "0.5", "--c-mu", "0.5", "--c-kappa", "2"]
    arguments += ["--gain", "1,1,1,2,2,2", "--dt", "0.1", "--tolerance", "0.02", "--max-time", "30"]
    arguments += ["--link-radius", "0.02", "--no-view", "--out", "out"]
    scene = str(ROOT / "scenes" / "dev" / "sparse-80000.json")
    result = script("plan", scene, *arguments, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    with np.load(tmp_path / "out" / "trajectory.npz") as arrays:
        np.testing.assert_allclose(np.diff(arrays["t"])[:-1], 0.1)


def test_a_case_keeps_its_gains(tmp_path: Path) -> None:
    summaries = []
    for case in "123":
        script("plan", "--case", case, "--out", case, cwd=tmp_path)
        summaries.append(json.loads((tmp_path / case / "summary.json").read_text()))
    assert [summary["collision_free"] for summary in summaries] == [False, True, True]


def test_targets_that_are_not_reached_exit_1_and_are_written(tmp_path: Path) -> None:
    result = script("plan", "--case", "3", "--max-time", "1", "--out", "out", cwd=tmp_path)
    assert result.returncode == 1
    assert "time_limit" in result.stdout
    assert {path.name for path in (tmp_path / "out").iterdir()} == OUTPUTS


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (["none.yaml"], "none.yaml"),
        (["--case", "4"], "case"),
        (["--case", "one"], "--case"),
        (["--case", "1", "scene.yaml"], "scene"),
        (["--method", "magic"], "method"),
        (["--case", "1", "--method", "magic"], "method"),
        (["--gain", "0"], "gain"),
        (["--gain", "1,2"], "gain"),
        (["--gain", "much"], "gain"),
        (["--dt", "nan"], "dt"),
        (["--epsilon", "-1"], "epsilon"),
        (["--link-radius", "-0.1"], "link_radius"),
        (["--nonsense"], "--nonsense"),
        (["a.yaml", "b.yaml"], "b.yaml"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(arguments: list[str], names: str, tmp_path: Path) -> None:
    result = script("plan", *arguments, "--out", "out", cwd=tmp_path)
    assert result.returncode == 2
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith("error: ")
    assert names in result.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("out", ["file", "file/below", "", "x" * 300])
def test_out_that_cannot_be_used(out: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    for name in ("plan", "reproduce"):
        result = script(name, "--out", out, cwd=tmp_path)
        assert (result.returncode, result.stderr.count("\n"), result.stdout) == (2, 1, ""), result.stderr
        assert result.stderr.startswith("error: out is ")
    assert (tmp_path / "file").read_text() == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_names_are_printed_as_they_are(tmp_path: Path) -> None:
    scene = "name: '[/bold] <b>:smile:'\ntargets: {left: [0.12, -2.23, 3.2], right: [0.12, 2.23, 3.2]}\n"
    (tmp_path / "scene.yaml").write_text(scene)
    result = script("plan", "scene.yaml", "--out", "[red]", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "[/bold] <b>:smile:" in result.stdout
    assert "Written to [red]" in result.stdout
    assert "[/bold] &lt;b&gt;:smile:" in (tmp_path / "[red]" / "playback.html").read_text()


def test_what_is_wrong_between_scene_and_robot_names_the_file(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text("name: x\ntargets: {left: [0, 0, 3]}\n")
    result = script("plan", "scene.yaml", cwd=tmp_path)
    assert result.stderr.startswith("error: scene.yaml: targets.right is missing"), result.stderr


def test_reproduce_does_not_touch_a_file_without_its_marks(tmp_path: Path) -> None:
    (tmp_path / "notes.md").write_text("<!-- claims --> and more")
    result = script("reproduce", "--no-sweep", "--readme", "notes.md", cwd=tmp_path)
    assert (result.returncode, result.stderr.count("\n")) == (2, 1)
    assert (tmp_path / "notes.md").read_text() == "<!-- claims --> and more"


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_the_view_ends_cleanly(ending: signal.Signals, tmp_path: Path) -> None:
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
    process = subprocess.Popen(
        command("plan", "--case", "1", "--dt", "0.1", "--view"),
        cwd=tmp_path,
        env={**environment, "PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    said = ""
    while "Ctrl-C" not in said:
        line = process.stdout.readline()
        assert line, f"ended early: {said}"
        said += line
    url = re.findall(r"http://\S+", said)[0]
    assert urlopen(url).status == 200
    process.send_signal(ending)
    _, errors = process.communicate()
    assert process.returncode == 0, errors
    assert errors == ""
    with pytest.raises(URLError):
        urlopen(url)


def test_reproduce(tmp_path: Path) -> None:
    result = script("reproduce", "--no-sweep", "--out", "figures", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "NO" not in result.stdout.split()
    names = {path.name for path in (tmp_path / "figures").iterdir()}
    kinds = {2: "motion", 3: "clearance", 4: "manipulability"}
    expected = {f"figure_{i:02d}_{kinds[(i - 2) % 3 + 2]}" for i in range(2, 11)}
    assert names == {f"{name}.{suffix}" for name in expected for suffix in ("png", "svg")}
