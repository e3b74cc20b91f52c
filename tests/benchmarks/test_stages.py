"""Where the time of plans goes."""

import time

from conftest import ROOT

from benchmarks.stages import STAGES, stages_of
from humanoid_rail import Auto, Robot, load_scene, plan


def test_what_is_in_no_stage_is_the_rest() -> None:
    def busy() -> None:
        until = time.thread_time() + 0.02
        while time.thread_time() < until:
            pass

    spent = stages_of(busy)
    assert set(spent) == {*STAGES, "rest", "all"}
    assert spent["rest"] == spent["all"] >= 0.02
    assert not any(spent[stage] for stage in STAGES)


def test_the_stages_of_a_plan_are_seen(robot: Robot) -> None:
    scene = load_scene(min((ROOT / "scenes" / "dev").glob("shelf-*")))
    quick = stages_of(lambda: plan(robot, scene, Auto(optimise=False)))
    best = stages_of(lambda: plan(robot, scene))
    for stage in ("goals", "smoothing", "certificate"):
        assert quick[stage] > 0.0
    assert quick["least time"] == 0.0 < best["least time"]
    assert all(value >= 0.0 for value in (*quick.values(), *best.values()))
