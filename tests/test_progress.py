"""What shows how much is done leaves the streams of the process alone, which belong to all threads."""

from __future__ import annotations

import sys
import time

import pytest

from humanoid_rail.progress import progress, progress_bar


def terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make stderr a terminal, as far as rich is concerned."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)


def test_what_takes_long_is_shown_and_cleared_away(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    terminal(monkeypatch)
    monkeypatch.setattr("humanoid_rail.progress.PATIENCE", 0.01)
    shown = ""
    with progress("planning"):
        for _ in range(200):  # until it is there
            shown += capsys.readouterr().err
            if "planning ..." in shown:
                break
            time.sleep(0.05)
    assert "planning ..." in shown
    assert "0:00:0" in shown
    assert capsys.readouterr().out == ""


def test_what_is_quick_shows_nothing(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    terminal(monkeypatch)
    monkeypatch.setattr("humanoid_rail.progress.PATIENCE", 1000.0)
    with progress("planning"):
        pass
    assert "planning" not in capsys.readouterr().err


def test_nothing_is_shown_where_stderr_is_no_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("humanoid_rail.progress.PATIENCE", 0.0)
    with progress("planning"):
        time.sleep(0.05)
    assert capsys.readouterr().err == ""


def test_streams_are_not_replaced(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    terminal(monkeypatch)
    streams = sys.stdout, sys.stderr
    with progress("planning"), progress_bar("scenes", 3) as advance:
        assert (sys.stdout, sys.stderr) == streams
        advance(3)
    out, err = capsys.readouterr()
    assert out == ""
    assert "scenes" in err
    assert "3/3" in err
