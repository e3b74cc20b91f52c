"""Motion planning for redundant two-armed robots, after Kacprzak and Pajak (2019).

>>> from humanoid_rail import load_robot, load_scene, plan
>>> trajectory = plan(load_robot(), load_scene("scenes/paper.yaml"))
"""

from humanoid_rail.planning.batch import WorkerDied, plan_many
from humanoid_rail.collision.certificate import Certificate, Contact
from humanoid_rail.model.library import build_urdf
from humanoid_rail.errors import HumanoidRailError, InvalidInput
from humanoid_rail.io.trajectory_files import read_trajectory, write_trajectory
from humanoid_rail.kinematics.kinematics import Kinematics, State
from humanoid_rail.kinematics.joint_limits import Violation
from humanoid_rail.scene.obstacles import Box, Capsule, HalfSpace, Mesh, Sphere
from humanoid_rail.paper.cases import paper_scene, plan_case
from humanoid_rail.planning.planner import plan
from humanoid_rail.resolution.velocity import Gains
from humanoid_rail.retiming.retiming import retime
from humanoid_rail.model.robot import Hand, Robot, load_robot, robot_from_urdf
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.scene.scene import Scene, load_scene, make_scene
from humanoid_rail.scene.targets import Pose
from humanoid_rail.timing import Peak, Timing
from humanoid_rail.trajectory import Status, Trajectory
from humanoid_rail.planning.verification import verify

__version__ = "0.1.0"

__all__ = [
    "Box",
    "Capsule",
    "Certificate",
    "Contact",
    "Gains",
    "HalfSpace",
    "Hand",
    "HumanoidRailError",
    "InvalidInput",
    "Kinematics",
    "Mesh",
    "Peak",
    "Pose",
    "Robot",
    "Safety",
    "Scene",
    "Sphere",
    "State",
    "Status",
    "Timing",
    "Trajectory",
    "Violation",
    "WorkerDied",
    "build_urdf",
    "load_robot",
    "load_scene",
    "make_scene",
    "paper_scene",
    "plan",
    "plan_case",
    "plan_many",
    "read_trajectory",
    "retime",
    "robot_from_urdf",
    "verify",
    "write_trajectory",
]
