"""A signal ends the playback, also one that comes while Python ignores what is raised."""

from __future__ import annotations

import os
import signal
import threading

import pytest

from humanoid_rail import Robot, Scene, plan_case
from humanoid_rail._signals import END_ASKED
from humanoid_rail.viewer.playback import show


class _TakenApart:
    """Gets a signal while it is taken apart."""

    def __del__(self) -> None:
        os.kill(os.getpid(), signal.SIGTERM)
        for _ in range(100):  # the handler runs between two steps of this
            pass


@pytest.mark.skipif(threading.current_thread() is not threading.main_thread(), reason="signals are for the main thread")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_signal_whose_exception_is_ignored_ends_the_playback(robot: Robot, scene: Scene) -> None:
    pytest.importorskip("meshcat")
    asked: list[bool] = []

    def ready(_url: str) -> None:
        thing = _TakenApart()
        del thing
        asked.append(END_ASKED.is_set())

    show(robot, scene, plan_case(robot, 1, dt=0.5), open_browser=False, on_ready=ready)
    assert asked == [True]
    assert not END_ASKED.is_set()
