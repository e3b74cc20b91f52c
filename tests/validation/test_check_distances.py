"""The measurement of what the margin is made of: it holds, means something, and finds what is wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from humanoid_rail import InvalidInput
from validation import check_distances
from validation.check_distances import ALLOWED, SHAPES, largest_excess, largest_rounding, main
from validation.exact_distances import KINDS, Measured


@pytest.mark.parametrize("kind", KINDS)
def test_rounding_is_within_the_margin(kind: str) -> None:
    assert 0.0 < largest_rounding(kind, 60, np.random.default_rng(1)) < ALLOWED


def test_a_separation_is_never_above_the_distance_of_spheres() -> None:
    assert abs(largest_excess(("sphere", "sphere"), 60, np.random.default_rng(1))) < 1e-6


def test_boxes_lose_something() -> None:
    assert 0.1 < largest_excess(("box", "box"), 200, np.random.default_rng(1)) < 1e4


def test_tables_are_written(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("<!-- excess -->\n<!-- /excess -->\n<!-- rounding -->\n<!-- /rounding -->\n", encoding="utf-8")
    result = CliRunner().invoke(main, ["--pairs", "12", "--readme", str(page)], standalone_mode=False)
    assert result.return_value == 0
    text = page.read_text(encoding="utf-8")
    assert all(f"| {name} " in text for name in (*SHAPES, "halfspace"))


def test_a_distance_that_is_too_large_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check_distances, "measured_distances", lambda *arguments: Measured(1.0 + 1e-12, 1.0, 1.0))
    assert CliRunner().invoke(main, ["--pairs", "1"], standalone_mode=False).return_value == 1


@pytest.mark.parametrize(("option", "value"), [("--pairs", "0"), ("--seed", "-1")])
def test_options_that_make_no_sense_are_refused(option: str, value: str) -> None:
    with pytest.raises(InvalidInput, match=option.strip("-")):
        main([option, value], standalone_mode=False)
