"""Two checkouts are compared scene by scene."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import ROOT

from benchmarks import against
from benchmarks.against import WORKER, Comparison, compare, faults_of, main, tabulate
from benchmarks.worker import Checkout
from humanoid_rail.errors import InvalidInput

SCENE = ROOT / "scenes" / "dev" / "sparse-80000.json"
REACHED, STUCK = ("reached", True), ("stuck", True)


def comparison(family: str, times: list[float], others: list[float], result: tuple[str, bool]) -> Comparison:
    return Comparison(family, f"{family}-1.json", "auto", times, others, result, REACHED)


def test_times_and_results_are_compared_per_family_and_over_all() -> None:
    found = [
        comparison("a", [2.0, 9.0], [1.0, 3.0], REACHED),
        comparison("b", [3.0, 1.0], [4.0, 5.0], STUCK),
    ]
    rows = {row[0]: row[2:] for row in tabulate(found)}
    assert rows["a"] == ["1", "2.000", "2.000 to 2.000", "2.000", "1 each", "1 each"]
    assert rows["b"] == ["1", "0.250", "0.250 to 0.250", "0.250", "0 and 1", "1 each"]
    assert rows["all"] == ["2", "1.125", "0.688 to 1.562", "0.600", "1 and 2", "2 each"]
    faults = list(faults_of(found, 1.1))
    assert faults[0] == "b-1 by auto: stuck, certified here, reached, certified there."
    assert "auto takes 1.125 times as long" in faults[1]
    assert list(faults_of(found[:1], 2.5)) == []


@pytest.mark.skipif(not (ROOT / ".venv" / "bin" / "python").exists(), reason="the checkout has no .venv")
def test_a_checkout_is_as_good_as_itself() -> None:
    checkouts = Checkout(ROOT, WORKER), Checkout(ROOT, WORKER)
    try:
        found = [Comparison("sparse", str(SCENE), "qp")]
        compare(found, *checkouts, 2)
    finally:
        for checkout in checkouts:
            checkout.close()
    assert found[0].result == found[0].other_result == REACHED
    assert len(found[0].times) == len(found[0].others) == 2
    assert min(*found[0].times, *found[0].others) > 0


def test_what_is_no_checkout_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"a checkout with a \.venv"):
        Checkout(tmp_path, WORKER)


@pytest.mark.parametrize("options", [["--method", "pink"], ["--repeats", "0"], ["--family", "none"]])
def test_bad_options_are_refused(options: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(against, "Checkout", None)
    with pytest.raises(InvalidInput):
        main.main([str(tmp_path), *options], standalone_mode=False)
