"""Robots of other packages, for tests that skip where these are not installed."""

from __future__ import annotations

from importlib import metadata

import pytest

from humanoid_rail import Robot, load_robot


def other_robot(name: str) -> Robot:
    """Return a robot of another package, `PACKAGE:ROBOT`."""
    package = name.partition(":")[0]
    try:
        metadata.version(package)
    except metadata.PackageNotFoundError:
        pytest.skip(f"{package}, a package of models, is not installed")
    return load_robot(name)
