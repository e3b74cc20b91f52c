"""The options of `humanoid-rail plan`, and the method that they make."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import signature
from typing import Any

import click

from humanoid_rail.cli.robot_options import NAMES
from humanoid_rail.errors import InvalidInput
from humanoid_rail.planning.methods import METHODS, Auto, GradientProjection, as_method
from humanoid_rail.planning.options import ENGINES, PlanningMethod

RETIMING = ("speed", "jerk_limit", "dwell")
"""These options are about retiming."""
GROUPS = {
    "What to plan": ("case", *NAMES, "link_radius", "lengths"),
    "How to plan": (
        "method",
        "safety_distance",
        "damper_gain",
        "max_edge_checks",
        "max_planning_time",
        "seed",
        "engine",
    ),
    "Equation 4.9": ("epsilon", "c_mu", "c_kappa", "gain"),
    "How fast": ("optimise", "max_optimisation_steps", "retimed", *RETIMING),
    "Samples, and when to stop": ("dt", "tolerance", "max_time"),
    "Results": ("out", "page", "view"),
}
"""The options have these headings as groups."""


def numbers(_context: click.Context, _option: click.Parameter, text: str | None) -> float | tuple[float, ...] | None:
    """Parse one number, or several separated by commas."""
    if text is None:
        return None
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        raise InvalidInput(
            "gain", text, "a number greater than 0, or one for each row of the tasks, separated by commas"
        ) from None
    return values[0] if len(values) == 1 else values


IN_PYTHON_ONLY = ("objectives", "equalities", "far_clearances", "rtol", "atol", "max_deviation", "max_tilt")
"""These fields of the methods are not options of the command line."""
METHOD_OPTIONS = (
    click.option("--safety-distance", type=float, help="Clearance that qp and auto keep, m  [0.01]"),
    click.option("--damper-gain", type=float, help="How fast qp and auto let clearances fall to it, 1/s  [1.4]"),
    click.option(
        "--max-edge-checks",
        type=int,
        help=f"The most edges that auto checks before it gives up  [{Auto.max_edge_checks}]",
    ),
    click.option("--max-planning-time", type=float, help="When planning by auto is cut off, s  [never]"),
    click.option(
        "--optimise/--no-optimise",
        default=None,
        help="Whether auto makes a motion of least time for a drive, or is quicker  [yes]",
    ),
    click.option(
        "--max-optimisation-steps",
        type=int,
        help=f"The most steps of that for each segment  [{Auto.max_optimisation_steps}]",
    ),
    click.option("--seed", type=int, help="Seed of the random numbers of auto  [0]"),
    click.option("--engine", help=f"Of gradient-projection: {' or '.join(ENGINES)}  [native]"),
    click.option("--epsilon", type=float, help="Activation distance of the obstacle penalty, m  [1.0]"),
    click.option(
        "--c-mu",
        type=float,
        help="Gain of the manipulability's gradient  [1.0 for the paper's robot, the same weight for others]",
    ),
    click.option("--c-kappa", type=float, help="Gain of the obstacle penalty's gradient  [1.0]"),
    click.option(
        "--gain", callback=numbers, help="K in 1/s: a number, or one for each row, separated by commas  [1.0]"
    ),
    click.option("--dt", type=float, help="Time between samples, s  [0.01]"),
    click.option("--tolerance", type=float, help="Norm of the hands' error that ends the motion, m  [0.01]"),
    click.option("--max-time", type=float, help="Longest motion, s  [60]"),
)
"""These are the options of the methods; each method takes those that it has a field for."""


def has_method_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options of the methods."""
    for decorate in reversed(METHOD_OPTIONS):
        function = decorate(function)
    return function


def method_options(method: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options that were given, if the method has them.

    Raises:
        InvalidInput: If there is no such method.
        click.UsageError: If it has no such option.
    """
    if method not in METHODS:
        as_method(method)  # says what there is
    given = {name: value for name, value in options.items() if value is not None}
    for name in given:
        if method not in (who := methods_with(name)):
            option = f"--{name.replace('_', '-')}"
            raise click.UsageError(f"{option} is not an option of the method {method}, but of {' and '.join(who)}")
    return given


def methods_with(option: str) -> list[str]:
    """Return the names of the methods that have an option."""
    return [name for name, method in METHODS.items() if option in signature(method).parameters]


def method_of(method: str | None, options: Mapping[str, Any]) -> PlanningMethod:
    """Return the method that was asked for, `auto` if none was."""
    name = Auto.name if method is None else method
    return METHODS[name](**method_options(name, options)) if name in METHODS else as_method(name)


def case_method_name(method: str | None) -> str:
    """Return the name of the method for a case of the paper, which is gradient projection if none was asked for."""
    return GradientProjection.name if method is None else method


def retiming_options(retimed: bool, options: Mapping[str, float | None]) -> dict[str, float]:
    """Return the arguments of the retiming that were given.

    Raises:
        click.UsageError: If there are some, but nothing is to be retimed.
    """
    given = {name: value for name, value in options.items() if value is not None}
    if given and not retimed:
        raise click.UsageError(f"--{next(iter(given)).replace('_', '-')} needs --retime")
    return given
