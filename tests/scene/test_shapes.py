"""What coal keeps to itself does not show."""

import subprocess
import sys

FIRST = """
import sys
import numpy as np
from humanoid_rail import Kinematics, Box, load_robot
robot = load_robot()
if sys.argv[1] == "tilted":
    Kinematics(robot, (Box(center=(1.0, 1.0, 3.0), size=(1.0, 1.0, 1.0), rpy=(0.1, 0.2, 0.3)),)).measure(robot.initial)
rng = np.random.default_rng(1)
straight = Kinematics(robot, (Box(center=(0.9, 2.0, 3.0), size=(0.5, 1.0, 1.0)),))
print(sum(straight.measure(q).clearance.sum() for q in rng.uniform(robot.lower, robot.upper, (300, robot.n))).hex())
"""


def test_distances_do_not_depend_on_what_is_measured_first() -> None:
    printed = [
        subprocess.run([sys.executable, "-c", FIRST, argument], capture_output=True, text=True, check=True).stdout
        for argument in ("tilted", "straight")
    ]
    assert printed[0] == printed[1] != ""
