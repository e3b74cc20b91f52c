"""The options of `humanoid-rail plan`, and what its report says first."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import pytest
from conftest import ROOT
from running import Ran, assert_bad_input

from humanoid_rail import Auto, GradientProjection, SafeVelocity, read_trajectory
from humanoid_rail.cli import plan
from humanoid_rail.cli.plan_options import IN_PYTHON_ONLY, method_of
from humanoid_rail.paper.cases import case_method
from humanoid_rail.planning.methods import METHODS

SCENE = ROOT / "scenes" / "dev" / "sparse-80000.json"


def rows(ran: Ran) -> list[tuple[str, str]]:
    """Return the rows of a report; a text that is broken into lines has them joined again."""
    found: list[tuple[str, str]] = []
    for line in ran.out.splitlines():
        if line.startswith("│"):
            name, text = (part.strip() for part in line.strip("│").split("│"))
            if name:
                found.append((name, text))
            else:
                found[-1] = (found[-1][0], f"{found[-1][1]} {text}")
    return found


@pytest.mark.parametrize(
    ("method", "option", "value", "those_with_it"),
    [
        ("qp", "--seed", 3, "auto"),
        ("gradient-projection", "--seed", 3, "auto"),
        ("qp", "--max-edge-checks", 100, "auto"),
        ("gradient-projection", "--max-planning-time", 1, "auto"),
        ("gradient-projection", "--safety-distance", 0.02, "auto and qp"),
        ("gradient-projection", "--damper-gain", 2, "auto and qp"),
        ("auto", "--engine", "python", "gradient-projection"),
        ("qp", "--engine", "native", "gradient-projection"),
    ],
)
def test_an_option_that_the_method_has_not_names_those_that_have_it(
    method: str, option: str, value: object, those_with_it: str, capfd: pytest.CaptureFixture[str]
) -> None:
    said = f"{option} is not an option of the method {method}, but of {those_with_it}"
    assert_bad_input(Ran(capfd, "plan", SCENE, "--method", method, option, value, "--no-view"), said)
    assert_bad_input(Ran(capfd, "plan", "--case", 3, "--method", method, option, value, "--no-view"), said)


def test_without_a_method_the_options_are_those_of_auto_and_of_a_case_those_of_the_paper(
    capfd: pytest.CaptureFixture[str],
) -> None:
    said = "--engine is not an option of the method auto"
    assert_bad_input(Ran(capfd, "plan", SCENE, "--engine", "python"), said)
    said = "--seed is not an option of the method gradient-projection"
    assert_bad_input(Ran(capfd, "plan", "--case", 1, "--seed", 1), said)


def test_the_method_is_made_of_the_options_that_were_given() -> None:
    assert method_of(None, {}) == method_of(None, {"seed": None, "dt": None}) == Auto()
    options = {"seed": 3, "max_edge_checks": 99, "max_planning_time": 0.5, "epsilon": 0.4, "dt": None}
    assert method_of("auto", options) == Auto(seed=3, max_edge_checks=99, max_planning_time=0.5, epsilon=0.4)
    assert method_of("qp", {"safety_distance": 0.02}) == SafeVelocity(safety_distance=0.02)
    assert method_of("gradient-projection", {"engine": "python"}) == GradientProjection(engine="python")


def test_every_option_of_a_method_can_be_given_or_is_for_python_only() -> None:
    given = {parameter.name for parameter in plan.command.params}
    known = {field.name for method in METHODS.values() for field in fields(method)}
    assert known - given == set(IN_PYTHON_ONLY)


@pytest.mark.parametrize(
    ("options", "method"),
    [
        ([], case_method(2, dt=0.1)),
        (["--epsilon", "0.7"], case_method(2, dt=0.1, epsilon=0.7)),
        (["--method", "qp"], case_method(2, "qp", dt=0.1)),
        (["--method", "auto", "--seed", "4"], case_method(2, "auto", dt=0.1, seed=4)),
    ],
)
def test_a_case_has_the_options_of_the_paper_but_for_those_that_are_given(
    options: list[str], method: object, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert Ran(capfd, "plan", "--case", 2, "--dt", 0.1, *options, "--out", tmp_path, "--no-view").code == 0
    assert read_trajectory(tmp_path).method == method


def test_the_report_begins_with_what_matters(capfd: pytest.CaptureFixture[str]) -> None:
    ran = Ran(capfd, "plan", SCENE, "--no-view")
    assert ran.code == 0
    assert ran.out.split()[0] == "sparse-80000"
    found = rows(ran)
    assert [name for name, _ in found[:4]] == ["status", "certified", "limits", "duration"]
    assert found[0][1].startswith("reached: ")
    assert "times the lower bound" in found[3][1]
    timing = dict(found)["timing"]
    assert timing == "of least time: within limits of velocity and acceleration, at rest at both ends"
    quick = rows(Ran(capfd, "plan", SCENE, "--no-optimise", "--no-view"))
    assert ("timing", "the method's own; retime it before a drive runs it (--retime)") in quick
    names = [name for name, _ in rows(Ran(capfd, "plan", SCENE, "--retime", "--no-view"))]
    assert {"peak velocity", "peak acceleration", "peak jerk"} <= set(names)


def test_of_a_case_the_report_says_what_its_law_does_not_do(capfd: pytest.CaptureFixture[str]) -> None:
    law = "by its own law, gradient projection (eq. 4.9), which neither prevents collisions nor knows limits"
    ran = Ran(capfd, "plan", "--case", 1, "--dt", 0.1, "--no-view")
    assert ran.code == 0  # it is there, through both spheres
    assert " ".join(ran.out.split()).startswith(f"case 1 of the paper {law} ")
    found = rows(ran)
    assert found[1][0] == "certified"
    assert found[1][1].startswith("no: ")
    assert "beyond limits" in [name for name, _ in found]
    ran = Ran(capfd, "plan", "--case", 1, "--dt", 0.1, "--method", "qp", "--no-view")
    assert ran.out.startswith("case 1 of the paper by qp")
    assert "its own law" not in ran.out


def test_a_plan_that_does_not_get_there_exits_1(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    ran = Ran(capfd, "plan", SCENE, "--max-planning-time", 1e-6, "--out", tmp_path, "--no-view")
    assert (ran.code, ran.err) == (1, "")
    assert rows(ran)[0][1].startswith("planning_timeout: ")
    assert read_trajectory(tmp_path).status == "planning_timeout"


def test_an_option_is_checked_before_a_file_is_read(capfd: pytest.CaptureFixture[str]) -> None:
    assert_bad_input(Ran(capfd, "plan", "none.yaml", "--method", "qp", "--seed", 1), "--seed is not an option")
    assert_bad_input(Ran(capfd, "plan", "none.yaml", "--dwell", 1), "--dwell needs --retime")
    assert_bad_input(Ran(capfd, "plan", "none.yaml", "--dt", 0), "dt is 0.0")
