"""What the native engine takes and gives back: memory, also of tasks and objectives written in Python."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT, plan

from humanoid_rail import (
    Auto,
    GradientProjection,
    NativeKinematics,
    PointTask,
    Problem,
    Robot,
    SafeVelocity,
    Scene,
    Sphere,
    State,
    load_robot,
    solve,
)
from humanoid_rail.model.native_robot import _robots


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_kinematics_leave_no_memory_behind(robot: Robot, rng: np.random.Generator) -> None:
    obstacles = tuple(Sphere(center=center, radius=0.1) for center in rng.uniform(-50, 50, (1000, 3)))

    def resident() -> int:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")

    def make(times: int) -> None:
        for _ in range(times):
            NativeKinematics(robot, obstacles).measure(robot.initial, 0.5)

    make(20)
    before = resident()
    make(60)
    assert resident() - before < 2e6


COUNTER = """
#define _GNU_SOURCE
#include <stddef.h>
extern void *__libc_malloc(size_t); extern void *__libc_memalign(size_t, size_t);
extern void *__libc_calloc(size_t, size_t); extern void *__libc_realloc(void *, size_t);
long allocations = 0;
void *malloc(size_t n) { ++allocations; return __libc_malloc(n); }
void *calloc(size_t n, size_t m) { ++allocations; return __libc_calloc(n, m); }
void *realloc(void *p, size_t n) { ++allocations; return __libc_realloc(p, n); }
int posix_memalign(void **p, size_t a, size_t n) { ++allocations; *p = __libc_memalign(a, n); return *p ? 0 : 12; }
void *aligned_alloc(size_t a, size_t n) { ++allocations; return __libc_memalign(a, n); }
"""

COUNTED = """
import ctypes, sys
import numpy as np
from humanoid_rail import Capsule, Gains, HalfSpace, NativeKinematics, PointTask, load_robot, paper_scene, plan_case
from humanoid_rail._native import engine
from humanoid_rail.kinematics.native_tasks import native_tasks
from humanoid_rail.resolution.native_options import native_gains
count = ctypes.c_long.in_dll(ctypes.CDLL(sys.argv[1]), "allocations")
robot, scene = load_robot(), paper_scene()
# Not boxes and meshes: for them coal's own GJK allocates a few bytes.
capsule, floor = Capsule(center=(0.5, 2.0, 3.0), radius=0.3, length=0.5), HalfSpace(normal=(0, 0, 1), offset=0.0)
obstacles = (*scene.obstacles, capsule, floor)
kinematics = NativeKinematics(robot, obstacles)
# Not singularities: there Eigen's SVD does.
q = plan_case(robot, 1).q[::4]
assert kinematics.along(q).clearance.min() < 0
gains = native_gains(robot, Gains(epsilon=3.0), 6, kinematics.state)
tasks = native_tasks(robot, [PointTask(hand, (1.0, 1.0, 1.0)) for hand in robot.hand_names], kinematics.state)
found = []
for repeats in (1, 11, 21):
    before = count.value
    engine().velocity_seconds(kinematics.native, q, tasks, gains, repeats)
    found.append(count.value - before)
print(*found)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="replaces glibc's malloc")
def test_nothing_is_allocated_in_the_loop(tmp_path: Path) -> None:
    """1,600 evaluations more take no allocation more, in contact too."""
    source, library = tmp_path / "count.c", tmp_path / "count.so"
    source.write_text(COUNTER, encoding="utf-8")
    subprocess.run(["cc", "-shared", "-fPIC", "-o", library, source], check=True)
    result = subprocess.run(
        [sys.executable, "-c", COUNTED, str(library)],
        env={**os.environ, "LD_PRELOAD": str(library)},
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    first, second, third = map(int, result.stdout.split())
    assert third == second, (first, second, third)


def test_memory_is_given_back(robot: Robot, scene: Scene) -> None:
    """Kinematics and native robots end with what they were made for."""
    before = len(_robots)
    other = load_robot(link_radius=0.02)
    plan(other, scene, dt=0.5)
    assert len(_robots) == before + 1
    del other
    gc.collect()
    assert len(_robots) == before


class Own:
    """A task that is written in Python."""

    def __init__(self, target: tuple[float, float, float]) -> None:
        self._task = PointTask("left", target)
        self.rows = 3

    def error(self, state: State) -> np.ndarray:
        return self._task.error(state)

    def jacobian(self, state: State) -> np.ndarray:
        return self._task.jacobian(state)

    def drift(self, state: State, velocity: np.ndarray) -> np.ndarray:
        return self._task.drift(state, velocity)


@pytest.mark.parametrize("method", [Auto, SafeVelocity, GradientProjection], ids=lambda method: method.name)
def test_what_is_called_back_ends_with_the_plan(robot: Robot, free: Scene, method: Any) -> None:
    """C++ keeps tasks, objectives and equalities: none of them may keep itself alive through it."""

    class Objective:
        def __call__(self, state: State) -> np.ndarray:
            return np.zeros(state.q.size)

    class Equality:
        def __call__(self, state: State) -> tuple[np.ndarray, np.ndarray]:
            return np.zeros((0, state.q.size)), np.zeros(0)

    def use() -> list[weakref.ref[Any]]:
        used: list[Any] = [Own((-1.2, 0.6, 3.4)), Objective()]
        options = {"objectives": [used[1]], "max_time": 1.0}
        if method is SafeVelocity:
            used.append(Equality())
            options["equalities"] = [used[2]]
        solve(Problem(robot, free, [used[0]], robot.initial), method(**options))
        return [weakref.ref(one) for one in used]

    references = use()
    gc.collect()
    assert [reference() for reference in references] == [None] * len(references)


LEAVE = """
import numpy as np
from humanoid_rail import Auto, GradientProjection, SafeVelocity, load_robot, paper_scene, plan
robot, scene = load_robot(), paper_scene()
nothing = {"objectives": [lambda state: np.zeros(robot.n)], "max_time": 1.0}
for method in (Auto(**nothing), SafeVelocity(**nothing, equalities=[lambda state: (np.zeros((0, 12)), np.zeros(0))])):
    plan(robot, scene, method)
try:
    plan(robot, scene, GradientProjection(objectives=[lambda state: 1 / 0]))
except ZeroDivisionError:
    print("said")
"""


def test_nothing_is_left_at_the_end() -> None:
    """The binding library counts its objects when the interpreter ends, and says if any are left."""
    result = subprocess.run([sys.executable, "-c", LEAVE], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (result.returncode, result.stdout, result.stderr) == (0, "said\n", "")
