"""What something was measured on."""

from __future__ import annotations

import os
import platform
from importlib.metadata import version


def machine() -> str:
    """Return what this was measured on."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    python = platform.python_version()
    load = f"load {os.getloadavg()[0]:.1f}"
    libraries = f"Pinocchio {version('pin')}, coal {version('coal')}"
    return f"{platform.system()} {platform.machine()}, {cores} cores ({load} before), Python {python}, {libraries}"
