"""Processes that answer requests, both lines of JSON: the planners that are compared, each in one of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from humanoid_rail.errors import HumanoidRailError, InvalidInput

ROOT = Path(__file__).resolve().parent.parent
"""The folder of this checkout."""
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
"""With these in its environment a process computes in one thread, so that its processor time is that of the work."""


class Worker:
    """A process that answers one request after the other."""

    def __init__(
        self, command: Sequence[str], folder: Path = ROOT, environment: Mapping[str, str] = ONE_THREAD
    ) -> None:
        """Start the process in a folder; it computes in one thread."""
        self.folder = folder
        self._process = subprocess.Popen(
            list(command),
            cwd=folder,
            env={**os.environ, **ONE_THREAD},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )

    def ask(self, request: Mapping[str, Any]) -> dict[str, Any]:
        """Return the answer to a request.

        Raises:
            HumanoidRailError: If the process has ended.
        """
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(request) + "\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            pass  # `answer` says so
        return self.answer()

    def answer(self) -> dict[str, Any]:
        """Return the next line of the process.

        Raises:
            HumanoidRailError: If there is none, because the process has ended.
        """
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise HumanoidRailError(f"the process that plans in {self.folder} ended; what it said is above")
        answer: dict[str, Any] = json.loads(line)
        return answer

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.communicate()


class Checkout(Worker):
    """A process that plans with the package of a checkout, by a script that imports only that package."""

    def __init__(self, folder: Path, script: Path) -> None:
        """Start the process.

        Raises:
            InvalidInput: If the checkout has no Python of its own.
            HumanoidRailError: If the package cannot be imported there, or is not the one of the checkout.
        """
        folder = folder.resolve()
        python = folder / ".venv" / "bin" / "python"
        if not python.exists():
            raise InvalidInput("checkout", str(folder), "a checkout with a .venv, as `make plan` makes it")
        # -P: neither the folder of the script nor the working directory is looked into for modules.
        super().__init__([str(python), "-P", str(script)], folder)
        self.about = self.answer()
        """What the script says of the package first: `package`, its file, and maybe more."""
        package = Path(self.about["package"])
        if not package.is_relative_to(folder):
            self.close()
            raise HumanoidRailError(f"{python} imports the package of {package.parent}, not of its checkout")


def serve(answer: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
    """Answer requests until stdin ends. What libraries print to stdout goes to stderr."""
    out = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    for line in sys.stdin:
        out.write(json.dumps(answer(json.loads(line))) + "\n")
        out.flush()
