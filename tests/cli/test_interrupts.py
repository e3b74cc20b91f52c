"""Commands and calls end when they are asked to, and so does every process that they started."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.error import URLError
from urllib.request import urlopen

import psutil
import pytest
from running import without_display

PATIENCE = 600.0
"""Processes that nobody waits for any more are given this long to end, s: far more than they need."""

PREPARED = """
import sys
import numpy as np
from types import SimpleNamespace
from humanoid_rail import *
from humanoid_rail.collision.closest_pairs import closest_pairs
from humanoid_rail.collision.certifier import certify

robot, places = load_robot(), np.random.default_rng(1).uniform(-1.0, 1.0, (8000, 3))
crowd = tuple(Sphere(center=(50.0 + x, y, z), radius=0.1) for x, y, z in places.tolist())
scene = paper_scene().model_copy(update={"obstacles": crowd})
many = np.linspace(robot.initial, robot.initial + 0.3, 200_000)
t = np.arange(len(many), dtype=float)
far = np.array([robot.initial, robot.initial + 1e7])
native = NativeKinematics(robot, scene.obstacles)
slow = {"gain": 1e-6, "epsilon": 100.0, "max_time": 1e4}


def busy():
    print("busy", flush=True)

"""
"""A script begins with this."""

CALLS = {
    "certify": "certify(robot, paper_scene().obstacles, np.array([0.0, 1.0]), far, max_checks=10**10)",
    "closest_pairs": "closest_pairs(robot, scene.obstacles, t, many)",
    "along": "native.along(many)",
    "gradient-projection": "plan(robot, scene, GradientProjection(rtol=1e-12, **slow))",
    "qp": "plan(robot, scene, SafeVelocity(**slow))",
}
"""Calls that take minutes."""


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Start Python in a process of its own, in a session of its own as a terminal would, and end it afterwards."""
    processes: list[subprocess.Popen[str]] = []

    def starting(*arguments: str) -> subprocess.Popen[str]:
        processes.append(
            subprocess.Popen(
                [sys.executable, *arguments],
                cwd=tmp_path,
                env=without_display(),
                # Where the tests run in the background of a shell, INT is ignored, and children inherit that.
                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
        )
        return processes[-1]

    yield starting
    for process in processes:
        process.kill()
        process.communicate()


def wait_for(process: subprocess.Popen[str], said: str) -> str:
    assert process.stdout is not None
    for line in process.stdout:
        if said in line:
            return line
    raise AssertionError(process.communicate())


def have_ended(processes: list[psutil.Process]) -> bool:
    _, alive = psutil.wait_procs(processes, timeout=PATIENCE)
    return not [process for process in alive if process.status() != psutil.STATUS_ZOMBIE]


@pytest.mark.parametrize("call", CALLS)
def test_a_long_native_call_is_interrupted(call: str, start: Callable[..., subprocess.Popen[str]]) -> None:
    process = start("-c", f"{PREPARED}busy()\n{CALLS[call]}\nprint('done', flush=True)\n")
    wait_for(process, "busy")
    time.sleep(0.5)  # into the call; an interrupt before it would end the script as well
    process.send_signal(signal.SIGINT)
    said, errors = process.communicate()
    assert process.returncode == -signal.SIGINT, errors
    assert "done" not in said
    assert errors.rstrip().endswith("KeyboardInterrupt")


def test_an_interrupted_call_leaves_the_object_as_it_was(start: Callable[..., subprocess.Popen[str]]) -> None:
    script = f"""{PREPARED}
before = native.along(many[:2]).clearance
busy()
try:
    native.along(many)
except KeyboardInterrupt:
    print("same" if np.array_equal(native.along(many[:2]).clearance, before) else "other", flush=True)
"""
    process = start("-c", script)
    wait_for(process, "busy")
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    said, errors = process.communicate()
    assert (process.returncode, said) == (0, "same\n"), errors


SCENES = """
import os
from pathlib import Path

import numpy as np

from humanoid_rail import SafeVelocity, load_robot, paper_scene, plan_many


def tell(state):
    Path(f"busy-{os.getpid()}").touch()
    return np.zeros(12)


if __name__ == "__main__":
    plan_many(load_robot(), 4 * [paper_scene()], SafeVelocity(gain=1e-6, max_time=1e4, objectives=(tell,)), n_jobs=2)
"""


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_workers_end_with_the_process_that_started_them(
    ending: signal.Signals, start: Callable[..., subprocess.Popen[str]], tmp_path: Path
) -> None:
    (tmp_path / "many.py").write_text(SCENES)
    process = start("many.py")
    parent = psutil.Process(process.pid)
    deadline = time.monotonic() + PATIENCE
    while len(list(tmp_path.glob("busy-*"))) < 2:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.1)
    children = parent.children(recursive=True)
    process.send_signal(ending)
    assert have_ended([*children, parent])


def test_nothing_is_served_any_more_when_a_playback_is_killed(start: Callable[..., subprocess.Popen[str]]) -> None:
    process = start("-m", "humanoid_rail", "plan", "--case", "1", "--dt", "0.1", "--view")
    line = wait_for(process, "Ctrl-C")
    url = re.findall(r"http://\S+", line)[0]
    assert urlopen(url).status == 200
    assert not psutil.Process(process.pid).children(recursive=True)
    process.kill()
    process.wait()
    with pytest.raises(URLError):
        urlopen(url)


@pytest.mark.parametrize(("ending", "code", "said"), [("INT", 130, "interrupted"), ("TERM", 143, "terminated")])
def test_a_command_that_is_ended_says_so_and_leaves_nothing_behind(
    ending: str, code: int, said: str, start: Callable[..., subprocess.Popen[str]], tmp_path: Path
) -> None:
    slow = ("--method", "qp", "--gain", "1e-6", "--max-time", "1e4")
    process = start("-X", "importtime", "-m", "humanoid_rail", "plan", *slow, "--out", "out")
    assert process.stderr is not None
    for line in process.stderr:  # the engine is loaded last before it plans
        if "humanoid_rail._engine" in line:
            break
    time.sleep(1.0)
    process.send_signal(getattr(signal, f"SIG{ending}"))
    out, errors = process.communicate()
    assert (process.returncode, out) == (code, ""), errors
    assert errors.strip().splitlines()[-1] == said
    assert list(tmp_path.iterdir()) == []
