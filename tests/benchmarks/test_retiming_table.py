"""The tables of retimed plans, and of how MuJoCo follows them."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import ROOT

from benchmarks import retiming, tracking
from humanoid_rail import Robot
from humanoid_rail.paper.figures import timing_figure

SCENE = "sparse-80000.json"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """One scene, and a page with the marks of both tables."""
    shutil.copy(ROOT / "scenes" / "dev" / SCENE, tmp_path)
    page = "before\n<!-- retiming -->\n<!-- /retiming -->\n<!-- tracking -->\n<!-- /tracking -->\nafter\n"
    (tmp_path / "page.md").write_text(page)
    return tmp_path


def rows(page: Path, name: str) -> list[dict[str, str]]:
    """Return the lines of a table by its columns."""
    text = page.read_text().partition(f"<!-- {name} -->")[2].partition(f"<!-- /{name} -->")[0]
    head, _, *lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.strip().splitlines()]
    return [dict(zip(head, line, strict=True)) for line in lines]


def test_the_table_of_retimed_plans(folder: Path) -> None:
    options = ["--readme", str(folder / "page.md"), "--figure", str(folder / "timing.png")]
    result = CliRunner().invoke(retiming.main, [str(folder), *options], standalone_mode=False)
    assert result.exception is None
    assert result.return_value == 0
    assert (folder / "timing.png").read_bytes().startswith(b"\x89PNG")
    family, every = rows(folder / "page.md", "retiming")
    assert family["family"] == "sparse"
    assert {**family, "family": "all"} == every
    assert family["certified"] == family["at rest"] == "1/1"
    assert 0.9 < float(family["acceleration"]) <= 1.0
    planned, retimed, smooth = (float(family[name]) for name in ("planned [s]", "retimed [s]", "jerk 100 [s]"))
    assert planned < retimed < smooth < float(family["exponential [s]"])


def test_a_plan_beyond_a_limit_is_found(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    faster = retiming.retime

    def too_fast(*arguments: Any, **settings: Any) -> Any:
        return faster(*arguments, **settings, acceleration_limit=11.0)

    monkeypatch.setattr(retiming, "retime", too_fast)
    result = CliRunner().invoke(retiming.main, [str(folder)], standalone_mode=False)
    assert result.return_value == 1
    assert "1 of 1 do not hold" in result.output


def test_the_figure_has_the_rates_of_each_motion(robot: Robot) -> None:
    motions = retiming.timings(robot)
    figure = timing_figure(robot, motions)
    assert len(figure.axes) == 2 * len(motions)
    for column, motion in enumerate(motions.values()):
        drawn = np.array([line.get_ydata() for line in figure.axes[column].get_lines()]).T
        expected = np.gradient(motion.q, motion.t, axis=0) if motion.timing is None else motion.timing.velocity
        np.testing.assert_allclose(drawn, expected / robot.velocity_limit)


def test_the_table_of_motions_in_mujoco(folder: Path) -> None:
    result = CliRunner().invoke(
        tracking.main, [str(folder), "--readme", str(folder / "page.md")], standalone_mode=False
    )
    assert result.exception is None
    assert result.return_value == 0
    case, family = rows(folder / "page.md", "tracking")
    assert (case["motions"], family["motions"]) == (tracking.CASE, "sparse")
    for row in (case, family):
        assert (row["simulated"], row["with contacts"]) == ("1", "0")
        assert 0.0 < float(row["at the end [mm]"]) <= float(row["error of a hand [mm]"]) < 20.0


def test_the_committed_tables_are_of_all_scenes() -> None:
    scenes = len(list((ROOT / "scenes" / "dev").glob("*.json")))
    table = rows(ROOT / "docs" / "retime.md", "retiming")
    assert table[-1]["certified"] == table[-1]["at rest"] == f"{scenes}/{scenes}"
    assert sum(int(row["simulated"]) for row in rows(ROOT / "docs" / "export.md", "tracking")) == scenes + 1
