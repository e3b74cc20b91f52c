"""The two engines: the same results from C++ and from readable Python."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from typing import Any, NamedTuple

from humanoid_rail import certification, integration, inverse_kinematics, kinematics, rollout, validity
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.errors import InvalidInput
from humanoid_rail.resolution.integrate import Integration

ENGINES = ("native", "python")
"""`native` is C++ on the same Pinocchio and coal; `python` is the reference, to be read."""


class Engine(NamedTuple):
    """What computes a motion."""

    name: str
    kinematics: Callable[..., Any]
    """The `Kinematics` of the engine."""
    integrate: Callable[..., Integration]
    """The `integrate` of the engine, for its own kinematics: eq. 4.9."""
    rollout: Callable[..., Integration]
    """The `rollout` of the engine, for its own kinematics: the safe velocity."""
    certify: Callable[..., Certificate]
    """The `certify` of the engine."""
    validity: Callable[..., Any]
    """The `Validity` of the engine."""
    inverse_kinematics: Callable[..., Any]
    """The `InverseKinematics` of the engine."""


def get_engine(name: str) -> Engine:
    """Return an engine by name: the Python engine, with a warning, instead of a native one that was not built.

    Raises:
        InvalidInput: If there is no engine of that name.
    """
    if not isinstance(name, str) or name not in ENGINES:
        raise InvalidInput("engine", name, f"one of {', '.join(ENGINES)}")
    reason = why_not_native() if name == "native" else None
    if reason is not None:
        message = f"the native engine is not there ({reason}); planning in Python, slower. See docs/engine.md"
        warnings.warn(message, RuntimeWarning, stacklevel=3)
    if name == "python" or reason is not None:
        return Engine(
            "python",
            kinematics.Kinematics,
            integration.integrate,
            rollout.rollout,
            certification.certify,
            validity.Validity,
            inverse_kinematics.InverseKinematics,
        )
    from humanoid_rail import native

    return Engine(
        "native",
        native.Kinematics,
        native.integrate,
        native.rollout,
        native.certify,
        native.validity,
        native.InverseKinematics,
    )


@cache
def why_not_native() -> str | None:
    """Return why the native engine cannot be used, None if it can."""
    if "humanoid_rail._engine" not in sys.modules and find_spec("humanoid_rail._engine") is None:
        return "it was not built when the package was installed, as happens where there is no C++ compiler"
    try:
        from humanoid_rail import native  # noqa: F401
    except ImportError as error:
        return str(error)
    return None
