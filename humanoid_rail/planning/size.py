"""Whether lengths in metres make sense for the size of a robot.

Options are in metres whatever the robot's size is, and so are some tolerances of the engine, such as those of inverse
kinematics (1e-7 m) and of distances (1e-6 m). Both mean something only for arms within a range of sizes.
"""

from __future__ import annotations

from humanoid_rail.errors import InvalidInput, told_apart
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.options import PlanningMethod
from humanoid_rail.result import Status

SHORTEST_REACH = 0.1
"""Arms have to reach at least this far, m."""
LONGEST_REACH = 1000.0
"""Arms may reach at most this far, m."""
LARGEST_SHARES = {"tolerance": 0.25, "safety_distance": 1.0}
"""These options, in m, may be at most such shares of what the shortest arm reaches."""
LARGE = 5.0
"""From arms of this reach on, manipulability, which grows with lengths, outweighs the task where its gain is 1, m."""


def check_size(robot: Robot, method: PlanningMethod) -> None:
    """Check that a robot is of a size that can be planned for, and that the method's lengths suit it.

    Raises:
        InvalidInput: If not.
    """
    reaches = dict(zip(robot.hand_names, robot.arm_reaches, strict=True))
    for name, reach in reaches.items():
        if reach < SHORTEST_REACH or reach > LONGEST_REACH:
            bounds = f"{told_apart(SHORTEST_REACH, reach)} to {told_apart(LONGEST_REACH, reach)} m"
            valid = f"an arm that reaches {bounds}; choose another unit of length for robot and scene, such as mm"
            raise InvalidInput(f"the reach of the arm of hands.{name}", reach, valid)
    shortest = min(reaches.values())
    for option, share in LARGEST_SHARES.items():
        value, most = float(getattr(method, option, 0.0)), share * shortest
        if value > most:
            valid = f"at most {told_apart(most, value)} m, {share:g} times what the arms reach"
            raise InvalidInput(option, value, valid)


def size_hint(robot: Robot, method: PlanningMethod, status: Status) -> str:
    """Return what may help if a motion by eq. 4.9 does not arrive because arms are large; nothing otherwise."""
    longest = max(robot.arm_reaches)
    arrived = status not in (Status.STALLED, Status.TIME_LIMIT)
    if arrived or longest < LARGE or not method.gains.c_mu:
        return ""
    return f"; c_mu = {method.gains.c_mu:g} is much for arms that reach {longest:.4g} m: try less, or auto"
