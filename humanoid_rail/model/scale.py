"""What makes numbers that were chosen for the paper's robot suit robots of other sizes.

The one characteristic is how far the arms reach, as a share of the 2 m of the paper's robot, for which every number is
the paper's, to the last bit.
"""

from __future__ import annotations

from math import prod

from humanoid_rail.model.robot import Robot

PAPER_REACH = 2.0
"""The arms of the paper's robot reach this far, m."""


def manipulability_gain(robot: Robot) -> float:
    """Return what c_mu is where it is not given: 1 for arms that reach as far as the paper's.

    mu of eq. 3.4 is a product over the arms of volumes, each of lengths to the third power. In units of what the arms
    reach it is the same number for robots of all sizes, so that its gradient has the same weight for all.
    """
    return float(prod((PAPER_REACH / reach) ** 3 for reach in robot.arm_reaches))


def relative_reach(robot: Robot) -> float:
    """Return the reach of the shortest arm, as a share of that of the paper's robot.

    Singular values of Jacobians are lengths, m/rad. So what is singular is a share of what an arm reaches.
    """
    return min(robot.arm_reaches) / PAPER_REACH
