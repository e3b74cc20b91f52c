"""The measurements of the engine run, and their figures are what they say."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT

from benchmarks import engine_report
from benchmarks.engine import PER_METRE, aisle
from benchmarks.engine_report import RATIO_COLUMNS, Report, main, seconds
from benchmarks.limits import LIMITS, broken
from benchmarks.stopwatch import Ratio, ratio
from humanoid_rail._native import why_no_engine

pytestmark = pytest.mark.skipif(why_no_engine() is not None, reason="there is no native engine to measure")

WITHIN = "evaluation: native engine / bare library calls, both called from C++"


def run(*options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "benchmarks.engine_report", *map(str, options)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def test_one_command_prints_tables_and_writes_json_and_markdown(tmp_path: Path) -> None:
    pytest.importorskip("pink", reason="needs the extra compare")
    page = tmp_path / "page.md"
    page.write_text(
        "<!-- times -->\nof last week\n<!-- /times -->\nkept\n<!-- ratios -->\n<!-- /ratios -->\n", encoding="utf-8"
    )
    options = [
        "--repeats",
        "1",
        "--plans",
        "8",
        "--follow",
        "1",
        "--json",
        tmp_path / "b.json",
        "--ratios",
        page,
        "--times",
        page,
    ]
    result = run(*options)
    assert result.returncode == 0, result.stderr
    report = json.loads((tmp_path / "b.json").read_text())
    for figure in report["figures"]:
        assert 0 < figure["low"] <= figure["median"] <= figure["high"], figure
    text = page.read_text()
    assert f"| {' | '.join(RATIO_COLUMNS)} |" in text
    for row in report["ratios"]:
        assert f"| {row['what']} |" in text
    # Each limit is of something that is measured.
    assert set(LIMITS) <= {row["what"] for row in report["ratios"]}
    assert "last week" not in text
    assert "kept" in text


@pytest.mark.parametrize("options", [["--repeats", "0"], ["--plans", "-1"], ["--follow", "0"], ["--repeats", "many"]])
def test_bad_options_are_one_line(options: list[str]) -> None:
    result = run(*options)
    assert result.returncode == 2
    assert result.stderr.startswith("error: ")
    assert len(result.stderr.splitlines()) == 1


@pytest.mark.parametrize(("check", "value", "code"), [(True, 1.1, 0), (True, 9.0, 1), (False, 9.0, 0)])
def test_the_check_names_the_ratio_that_is_beyond_its_limit(
    check: bool, value: float, code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    report = Report("any", [], [Ratio(WITHIN, value, value, value), Ratio("without a limit", 1e9, 1e9, 1e9)], [])
    monkeypatch.setattr(engine_report, "measure", lambda *options: report)
    assert main.main(["--no-pink", *(["--check"] if check else [])], standalone_mode=False) == code
    said = capsys.readouterr().err
    assert (WITHIN in said) == bool(code)
    assert "without a limit" not in said


def test_limits_are_ranges() -> None:
    for what, limit in LIMITS.items():
        inside = limit.least if limit.least > 0 else limit.most
        assert broken([Ratio(what, inside, inside, inside)]) == []
        outside = limit.least * 0.9 if limit.least > 0 else limit.most * 1.1
        (said,) = broken([Ratio(what, outside, outside, outside)])
        assert what in said


def test_ratios_are_taken_repeat_by_repeat() -> None:
    found = ratio("x", np.array([1.0, 4.0, 9.0]), np.array([1.0, 2.0, 3.0]))
    assert (found.median, found.low, found.high) == (2.0, 1.5, 2.5)
    assert [seconds(x) for x in (2.0, 0.0123, 3.2e-6)] == ["2 s", "12.3 ms", "3.2 us"]


def test_spheres_are_as_dense_however_many(rng: np.random.Generator) -> None:
    for count in (10, 1000):
        y = [sphere.center[1] for sphere in aisle(count, rng)]
        assert len(y) == count
        assert np.ptp(y) == pytest.approx(count / PER_METRE, rel=0.3)
