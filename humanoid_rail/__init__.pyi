# The public names, imported by `__init__.py` when they are first used.
from .collision.certificate import Certificate, Contact
from .diagnosis import BlockingPair, Diagnosis, Miss, Remedy
from .errors import EngineMissing, HumanoidRailError, InvalidInput
from .events import Event
from .following.follower import Follower
from .following.state import CycleTimes, FollowerState, FollowerStatus, NearPair
from .io.export import export
from .io.plan_folder import Plan, read_plan, write_plan
from .io.trajectory_files import read_trajectory, write_trajectory
from .kinematics.joint_limits import Violation
from .kinematics.kept_tasks import AxisTask, DistanceTask, LineTask, OrientationTask
from .kinematics.kinematics import Kinematics
from .kinematics.native_kinematics import NativeKinematics
from .kinematics.state import State
from .kinematics.task import ConfigurationTask, DirectionTask, PointTask, RelativeTask, Task
from .kinematics.within_task import WithinTask
from .model.building import robot_from_urdf
from .model.hand_links import hand_bodies
from .model.humanoid import build_urdf
from .model.library import load_robot, robots
from .model.robot import Hand, Robot
from .paper.cases import paper_scene, plan_case
from .planning.batch import WorkerDied, plan_many
from .planning.methods import Auto, GradientProjection, SafeVelocity
from .planning.planner import plan, solve
from .planning.verification import verify
from .problem import Problem
from .resolution.qp import Safety
from .resolution.velocity import Gains
from .result import Motion, Optimisation, Peak, Provenance, Retiming, Status, Timing, Verdict
from .retiming.retiming import retime
from .samples import Samples
from .scene.covers import Cover, HeightField, PointCloud
from .scene.groups import Group, Repeat, Shelf, flat_obstacles
from .scene.obstacles import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere
from .scene.poses import AnyOf, Pose
from .scene.scene import Scene, load_robot_of_scene, load_scene, make_scene
from .trajectory import Trajectory
from .viewer.notebook import Page, view

__version__: str
__all__ = [
    "AnyOf",
    "Auto",
    "AxisTask",
    "BlockingPair",
    "Box",
    "Capsule",
    "Certificate",
    "ConfigurationTask",
    "Contact",
    "Cover",
    "CycleTimes",
    "Cylinder",
    "Diagnosis",
    "DirectionTask",
    "DistanceTask",
    "EngineMissing",
    "Event",
    "Follower",
    "FollowerState",
    "FollowerStatus",
    "Gains",
    "GradientProjection",
    "Group",
    "HalfSpace",
    "Hand",
    "HeightField",
    "HumanoidRailError",
    "InvalidInput",
    "Kinematics",
    "LineTask",
    "Mesh",
    "Miss",
    "Motion",
    "NativeKinematics",
    "NearPair",
    "Optimisation",
    "OrientationTask",
    "Page",
    "Peak",
    "Plan",
    "PointCloud",
    "PointTask",
    "Pose",
    "Problem",
    "Provenance",
    "RelativeTask",
    "Remedy",
    "Repeat",
    "Retiming",
    "Robot",
    "SafeVelocity",
    "Safety",
    "Samples",
    "Scene",
    "Shelf",
    "Sphere",
    "State",
    "Status",
    "Task",
    "Timing",
    "Trajectory",
    "Verdict",
    "Violation",
    "WithinTask",
    "WorkerDied",
    "build_urdf",
    "export",
    "flat_obstacles",
    "hand_bodies",
    "load_robot",
    "load_robot_of_scene",
    "load_scene",
    "make_scene",
    "paper_scene",
    "plan",
    "plan_case",
    "plan_many",
    "read_plan",
    "read_trajectory",
    "retime",
    "robot_from_urdf",
    "robots",
    "solve",
    "verify",
    "view",
    "write_plan",
    "write_trajectory",
]
