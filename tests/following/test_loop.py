"""A follower's thread: what is said to it counts, and it ends with its owner, an exception or the interpreter."""

from __future__ import annotations

import gc
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable

import numpy as np
import psutil
import pytest
from conftest import AHEAD

from humanoid_rail import Follower, FollowerStatus, Kinematics, Robot, Scene, Sphere

SCENE = Scene(targets=AHEAD, obstacles=(Sphere(center=(3.0, 8.0, 3.0), radius=0.2),))
PATIENCE = 60.0
"""A busy machine is waited for this long, s."""


def wait_until(is_so: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE
    while not is_so():
        assert time.monotonic() < end
        time.sleep(0.002)


def threads() -> int:
    return psutil.Process().num_threads()


def test_it_follows_what_it_is_told_meanwhile(robot: Robot) -> None:
    """It ends at rest, at the targets that it was given while it ran."""
    targets = {"left": (-1.6, 0.6, 3.0), "right": (-1.6, 2.2, 3.0)}
    follower = Follower(robot, SCENE, dt=0.002, obstacle_speed=1.0)
    with follower:
        assert follower.is_running
        with pytest.raises(RuntimeError, match="stop it first"):
            follower.step()
        with pytest.raises(RuntimeError, match="runs already"):
            follower.start()
        wait_until(lambda: follower.state.cycle > 20)
        follower.set_targets(targets)
        follower.move_obstacle(0, (3.0, 7.999, 3.0))
        wait_until(lambda: follower.state.status is FollowerStatus.REACHED)
    assert not follower.is_running
    state, times = follower.state, follower.cycle_times
    assert not state.velocity.any()
    assert times.cycles == state.cycle
    assert 0.0 < times.median <= times.percentile_99 <= times.longest
    assert 0 <= times.overruns <= times.cycles
    hands = Kinematics(robot).hand_positions(state.q).reshape(-1, 3)
    np.testing.assert_allclose(hands, list(targets.values()), atol=0.05)
    assert follower.step().cycle == times.cycles + 1  # on by hand


def test_it_may_be_asked_from_many_threads(robot: Robot) -> None:
    with Follower(robot, SCENE, dt=0.002, obstacle_speed=1.0) as follower:
        failed: list[BaseException] = []

        def work(number: int) -> None:
            try:
                for i in range(50):
                    follower.set_targets({"left": (-1.6, 0.6 + 0.001 * i, 3.0), "right": None})
                    follower.move_obstacle(0, (3.0, 8.0 + 1e-4 * number, 3.0))
                    assert follower.state.proven
            except BaseException as error:
                failed.append(error)

        workers = [threading.Thread(target=work, args=(i,)) for i in range(4)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
    assert not failed


def test_the_thread_ends_with_its_owner(robot: Robot) -> None:
    before = threads()
    follower = Follower(robot, SCENE, dt=0.002)
    follower.start()
    assert threads() == before + 1
    del follower
    gc.collect()
    wait_until(lambda: threads() == before)


def test_the_thread_ends_with_an_exception(robot: Robot) -> None:
    follower = Follower(robot, SCENE, dt=0.002)

    def interrupted() -> None:
        with follower:
            raise KeyError

    with pytest.raises(KeyError):
        interrupted()
    assert not follower.is_running


@pytest.mark.parametrize("ending", ["", "raise SystemExit(0)", "del follower", "os.fork() or os._exit(0)"])
def test_a_process_ends_well_while_it_runs(ending: str) -> None:
    code = f"""
        import os
        from humanoid_rail import Follower, load_robot, paper_scene

        follower = Follower(load_robot(), paper_scene(), dt=0.001)
        follower.start()
        while follower.state.cycle < 10:
            pass
        {ending}
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not done.stderr


def test_a_follower_of_another_process_says_so() -> None:
    code = """
        import os
        from humanoid_rail import Follower, load_robot, paper_scene

        follower = Follower(load_robot(), paper_scene(), dt=0.001)
        follower.start()
        child = os.fork()
        if child == 0:
            assert not follower.is_running
            calls = (
                follower.start,
                follower.step,
                follower.stop,
                lambda: follower.state,
                lambda: follower.cycle_times,
                lambda: follower.move_obstacle(0, (0.0, 0.0, 9.0)),
                lambda: follower.set_targets({"left": (-1.6, 0.6, 3.0), "right": None}),
            )
            for call in calls:
                try:
                    call()
                    os._exit(2)
                except RuntimeError as error:
                    assert "started in another process" in str(error)
            del follower
            os._exit(0)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        assert follower.is_running
        follower.stop()
        if os.fork() == 0:
            follower.step()  # its thread had ended before
            os._exit(0)
        assert os.waitstatus_to_exitcode(os.wait()[1]) == 0
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def moving(robot: Robot) -> Follower:
    """Return a follower that runs, and takes half a second to brake."""
    follower = Follower(robot, SCENE, dt=0.002, acceleration_limit=0.05)
    follower.start()
    wait_until(lambda: abs(follower.state.velocity).max() > 0.025)
    return follower


def in_thread(call: Callable[[], object]) -> threading.Thread:
    thread = threading.Thread(target=call, daemon=True)
    thread.start()
    return thread


def test_a_start_that_waits_for_a_stop_lets_others_run(robot: Robot) -> None:
    """While one thread brakes and another waits to start again, a third still gets Python."""
    follower, turns = moving(robot), 0
    stops = in_thread(follower.stop)
    wait_until(lambda: follower.state.status is FollowerStatus.BRAKING)
    starts = in_thread(follower.start)
    while starts.is_alive():
        turns += 1
        time.sleep(0.001)
    stops.join()
    assert turns > 10  # one or two if it held the interpreter's lock
    assert follower.is_running
    follower.stop()


def test_a_stop_after_a_start_that_waits_ends(robot: Robot) -> None:
    """It stops the thread that was started while it waited."""
    follower = moving(robot)
    calls = [in_thread(follower.stop)]
    wait_until(lambda: follower.state.status is FollowerStatus.BRAKING)
    for call in (follower.start, follower.stop):
        calls.append(in_thread(call))
        time.sleep(0.02)  # so that they most likely wait in this order; in any other they end as well
    for thread in calls:
        thread.join(PATIENCE)
        assert not thread.is_alive()
    follower.stop()
    assert not follower.is_running
