"""Without the native engine: the Python reference works, and one error says what to install."""

from __future__ import annotations

import subprocess
import sys

import pytest
from conftest import ROOT


def python(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)


WITHOUT = """
import sys
{how}
from humanoid_rail import *
from humanoid_rail import GradientProjection
robot, scene = load_robot(), paper_scene()
trajectory = plan(robot, scene, GradientProjection(engine="python", dt=0.5))
print(trajectory.engine, trajectory.status, trajectory.certificate, trajectory.certified, trajectory.reason)
print(plan_many(robot, [scene], GradientProjection(engine="python", dt=0.5), n_jobs=1)[0].status)
for need in (
    lambda: plan(robot, scene),
    lambda: plan(robot, scene, "qp"),
    lambda: plan(robot, scene, GradientProjection()),
    lambda: verify(robot, scene, trajectory),
    lambda: NativeKinematics(robot),
    lambda: plan_many(robot, [scene], n_jobs=1),
):
    try:
        need()
    except EngineMissing as error:
        print("missing:", error)
"""


@pytest.mark.parametrize(
    ("how", "why"),
    [
        ("sys.modules['humanoid_rail._engine'] = None", "_engine"),
        ("import coal; coal.__version__ = '9.9.9'", "built for Pinocchio and coal 4.1.0 and 3.0.3, and these are"),
    ],
)
def test_without_the_native_engine_one_error_says_what_to_install(how: str, why: str) -> None:
    result = python(WITHOUT.format(how=how))
    assert result.returncode == 0, result.stderr
    planned, many, *missing = result.stdout.strip().split("\n")
    assert planned.startswith("python reached None False |e| fell to")
    assert "is not installed" in planned
    assert many == "reached"
    assert len(missing) == 6
    for line in missing:
        assert why in line
        assert "install" in line
        assert 'GradientProjection(engine="python")' in line
