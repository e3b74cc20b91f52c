"""Loads the native engine, the compiled extension `humanoid_rail._engine`."""

from __future__ import annotations

import sys
from ctypes import CDLL
from functools import cache
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.metadata import files
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

from humanoid_rail.errors import EngineMissing

_PACKAGE = Path(__file__).resolve().parent


def engine() -> ModuleType:
    """Return the extension module.

    Raises:
        EngineMissing: If it was not built, or was built for other versions of Pinocchio or coal.
    """
    reason = why_no_engine()
    if reason is not None:
        raise EngineMissing(reason)
    return sys.modules["humanoid_rail._engine"]


@cache
def why_no_engine() -> str | None:
    """Return why the native engine cannot be used and what to do about it; None if it can."""
    if "humanoid_rail._engine" not in sys.modules and find_spec("humanoid_rail._engine") is None:
        return _what_to_install()
    try:
        # These bring the libraries that the extension is linked with, so they come first.
        import coal
        import pinocchio as pin

        # Nothing else loads this library, and it lies beside the extension only where both are in one environment.
        for file in files("eiquadprog") or ():
            if file.name.startswith("libeiquadprog."):
                CDLL(str(file.locate()))
        from humanoid_rail import _engine
    except (ImportError, OSError) as error:
        return f"it cannot be loaded ({error}); install humanoid_rail again: {_install_command()}"
    if (pin.__version__, coal.__version__) != (_engine.PINOCCHIO_VERSION, _engine.COAL_VERSION):
        return (
            f"it was built for Pinocchio and coal {_engine.PINOCCHIO_VERSION} and {_engine.COAL_VERSION}, and these "
            f"are {pin.__version__} and {coal.__version__}; install humanoid_rail again: {_install_command()}"
        )
    return None


def _what_to_install() -> str:
    if _is_checkout():
        return (
            f"this is a checkout ({_PACKAGE.parent}) whose engine was not built for this Python; build it with "
            f"`{_install_command()}`, or run Python outside the checkout to use an installed package"
        )
    return (
        "it was not built when humanoid_rail was installed; install a C++17 compiler (g++ or clang++) and then "
        f"`{_install_command()}`"
    )


def _is_checkout() -> bool:
    """Return whether this package is the source folder of a checkout, which holds no compiled extension."""
    compiled = any((_PACKAGE / f"_engine{suffix}").exists() for suffix in EXTENSION_SUFFIXES)
    return not compiled and (_PACKAGE.parent / "engine").is_dir() and (_PACKAGE.parent / "CMakeLists.txt").is_file()


def _install_command() -> str:
    return "make plan" if _is_checkout() else "pip install --force-reinstall --no-deps humanoid_rail"
