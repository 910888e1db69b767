"""Every topic and service of the graph: name (relative to /wholearm), type, quality of service."""

from dataclasses import dataclass
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatusArray
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, TransformStamped
from nav_msgs.srv import GetPlan
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import MarkerArray

NAMESPACE = 'wholearm'
PALM_FRAME, OBJECT_FRAME = 'palm', 'object'
FINGER_FRAMES = ('left_finger', 'right_finger')


def frame_in(namespace: str, frame: str) -> str:
    """The name of a hand's frame on /tf, which all hands share: 'palm' in the default namespace,
    'left/palm' in /left.
    """
    space = namespace.strip('/')
    return frame if space in ('', NAMESPACE) else f'{space}/{frame}'


def _qos(depth: int, reliable: bool = True, latched: bool = False) -> QoSProfile:
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


REMEMBERED = 10  # ended goals in a status, and their results
RELIABLE, LATCHED, BEST_EFFORT = _qos(10), _qos(1, latched=True), _qos(5, reliable=False)
RESULTS = _qos(REMEMBERED, latched=True)  # a rejection does not replace the result before it
NEWEST = _qos(1)  # setpoints and commands: only the newest counts
# How the nodes of the loop listen to joint states, setpoints and commands.
NO_RESENDING = _qos(10, reliable=False)
NEWEST_STATE = _qos(1, reliable=False)  # joint states for those that look at a few of them


@dataclass(frozen=True, eq=False)
class Topic:
    """A topic; what it carries and from whom to whom is in docs/ros.md.

    steady: whoever publishes it never pauses, so that silence is a fault. Setpoints and commands
    are not: they come with a run, and the drives' watchdog tells when they end.
    """

    name: str
    type: type
    qos: QoSProfile
    steady: bool = False


@dataclass(frozen=True, eq=False)
class Service:
    """A service."""

    name: str
    type: Any  # its class, which holds those of request and response


PLAN = Service('contact_state_planner/plan', GetPlan)
PLAN_SCENARIO = Service('contact_state_planner/plan_scenario', Trigger)
CONTACT_PLAN = Topic('contact_state_planner/contact_plan', String, LATCHED)
PLANNER_STATUS = Topic('contact_state_planner/status', DiagnosticStatus, LATCHED)
FACE_MAP = Topic('contact_state_planner/map', String, LATCHED)

GOAL = Topic('trajectory_generator/goal', GoalInfo, RELIABLE)
CANCEL = Topic('trajectory_generator/cancel', GoalInfo, RELIABLE)
GOAL_STATUS = Topic('trajectory_generator/status', GoalStatusArray, LATCHED)
FEEDBACK = Topic('trajectory_generator/feedback', DiagnosticStatus, RELIABLE)
RESULT = Topic('trajectory_generator/result', DiagnosticStatus, RESULTS)
JOINT_TRAJECTORY = Topic('trajectory_generator/joint_trajectory', JointTrajectory, LATCHED)
MANIPULATION_TRAJECTORY = Topic('trajectory_generator/manipulation_trajectory', String, LATCHED)

REORIENTATION_GOAL = Topic('reorientation/goal', GoalInfo, RELIABLE)
REORIENTATION_CANCEL = Topic('reorientation/cancel', GoalInfo, RELIABLE)
REORIENTATION_STATUS = Topic('reorientation/status', GoalStatusArray, LATCHED)
REORIENTATION_FEEDBACK = Topic('reorientation/feedback', DiagnosticStatus, RELIABLE)
REORIENTATION_RESULT = Topic('reorientation/result', DiagnosticStatus, RESULTS)

MODE = Topic('mode_switcher/mode', String, LATCHED)
PROGRESS = Topic('mode_switcher/progress', DiagnosticStatus, RELIABLE)
STOP = Service('mode_switcher/stop', Trigger)
VELOCITY_SETPOINT = Topic('velocity_setpoint', JointState, NEWEST)
TORQUE_SETPOINT = Topic('torque_setpoint', JointState, NEWEST)

JOINT_COMMANDS = Topic('joint_commands', JointState, _qos(2))  # two publishers, one joint a message
JOINT_STATES = Topic('joint_states', JointState, RELIABLE, steady=True)
OBJECT_POSE = Topic('object_pose', PoseStamped, BEST_EFFORT)
OBJECT_ESTIMATE = Topic('object_estimate', PoseWithCovarianceStamped, RELIABLE)
CONTACT_STATE = Topic('object_observer/contact_state', DiagnosticStatus, RELIABLE)
ROBOT_DESCRIPTION = Topic('robot_description', String, LATCHED)
MARKERS = Topic('markers', MarkerArray, LATCHED)
# /tf itself where tf2_msgs can be imported.
TRANSFORMS = Topic('transforms', TransformStamped, BEST_EFFORT)
RESET = Service('hand_hardware/reset', Trigger)
HARDWARE_STOP = Service('hand_hardware/stop', Trigger)

CLOCK = Topic('/clock', Clock, BEST_EFFORT)
DIAGNOSTICS = Topic('/diagnostics', DiagnosticArray, RELIABLE)
PERTURBATION = 'perturbation'  # in the diagnostics of a simulated hand: its errors, JSON
GOAL_LISTENERS = 'goal listeners'  # in the diagnostics of reorientation, of `GOAL`

TOPICS = tuple(v for v in list(globals().values()) if isinstance(v, Topic))
SERVICES = tuple(v for v in list(globals().values()) if isinstance(v, Service))
RECORDED = tuple(t for t in TOPICS if t is not TRANSFORMS)
