"""Messages to model nouns and back: the only file that knows both."""

import math
import uuid
from collections.abc import Iterable, Sequence
from typing import Any, Optional

import numpy as np
from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from builtin_interfaces.msg import Duration, Time
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import Pose, PoseStamped, PoseWithCovarianceStamped, Quaternion
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from wholearm_ros.control.setpoints import Joints, TorqueSetpoint, VelocitySetpoint
from wholearm_ros.model.hand import JOINT_NAMES
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.ros.interface.channels import PALM_FRAME
from wholearm_ros.ros.interface.joint_state_serialization import (
    NANOSECONDS,
    JointReading,
    MessageError,
    nanoseconds,
    write_joints,
)

PLANNER_BUSY = 'busy with another plan; allowed: one at a time'  # answer of plan_scenario
NO_GOAL = bytes(16)  # a cancel with it means: whatever is running
# A goal of the generator that only feels what lies in the hand.
FEEL_GOAL = uuid.uuid5(uuid.NAMESPACE_OID, 'wholearm: feel').bytes
_NAME_OF = [(name,) for name in JOINT_NAMES]
PLANAR_TILT = 1e-3  # [rad] how far a pose's rotation may be from one about z


# -- time


def to_nanoseconds(stamp: Time) -> int:
    """[ns]; raises MessageError."""
    return nanoseconds(stamp.sec, stamp.nanosec)


def set_stamp(stamp: Time, nanoseconds: int) -> None:
    """The fields of `stamp` from `nanoseconds`."""
    stamp.sec, stamp.nanosec = divmod(nanoseconds, NANOSECONDS)


# -- joints


def joint_states_bytes(
    stamp: int, angles: np.ndarray, velocities: np.ndarray, efforts: np.ndarray
) -> bytes:
    """joint_states at `stamp` [ns]; the three are (2,) [rad, rad/s, N m], left then right."""
    return write_joints(
        stamp, PALM_FRAME, JOINT_NAMES, angles.tolist(), velocities.tolist(), efforts.tolist()
    )


def to_joints(message: JointReading, names: Sequence[str] = JOINT_NAMES) -> tuple[int, Joints]:
    """Stamp [ns] and the joints of `names`, left then right, wherever among others they are in the
    message.

    Efforts that are left out, or NaN, were not measured; that is how joint_state_broadcaster tells
    of drives without an effort interface. Angles and velocities that are not finite come through:
    it is for the mode switch to stop on them. Raises MessageError.
    """
    places = places_of(names, message.name, 'joint_states')
    angles, velocities = (_column(message, field, places) for field in ('position', 'velocity'))
    efforts = _column(message, 'effort', places) if message.effort else np.full(2, np.nan)
    if np.isinf(efforts).any():
        raise MessageError(
            f'joint_states.effort: got {_shown(list(message.effort))}; '
            'allowed: finite numbers, NaN where none is measured'
        )
    return message.stamp, Joints(message.stamp / NANOSECONDS, angles, velocities, efforts)


def places_of(wanted: Sequence[str], names: Sequence[str], channel: str) -> list[int]:
    """Where each of `wanted` is in `names`, once and only once. Raises MessageError."""
    if any(names.count(name) != 1 for name in wanted):
        raise MessageError(
            f'{channel}.name: got {_shown(names)}; allowed: {list(wanted)}, once each, among others'
        )
    return [names.index(name) for name in wanted]


def _column(message: JointReading, field: str, places: list[int]) -> np.ndarray:
    values = getattr(message, field)
    if len(values) != len(message.name):
        raise MessageError(
            f'joint_states.{field}: got {len(values)} numbers; allowed: {len(message.name)}, '
            'one for each name'
        )
    return np.array([values[place] for place in places])


def velocity_setpoint_bytes(stamp: int, setpoint: VelocitySetpoint) -> bytes:
    """The serialized velocity_setpoint at `stamp` [ns]."""
    return write_joints(
        stamp,
        PALM_FRAME,
        _NAME_OF[setpoint.joint],
        [setpoint.angle],
        [setpoint.velocity],
        [setpoint.feedforward],
    )


def effort_bytes(stamp: int, joint: int, effort: float) -> bytes:
    """A torque setpoint or a joint command."""
    return write_joints(stamp, PALM_FRAME, _NAME_OF[joint], effort=[effort])


def to_velocity_setpoint(message: JointReading) -> VelocitySetpoint:
    """Raises MessageError."""
    joint = _one_joint('velocity_setpoint', message, ('position', 'velocity', 'effort'))
    return VelocitySetpoint(joint, message.position[0], message.velocity[0], message.effort[0])


def to_torque_setpoint(message: JointReading) -> TorqueSetpoint:
    """Raises MessageError."""
    joint = _one_joint('torque_setpoint', message, ('effort',))
    return TorqueSetpoint(joint, message.effort[0])


def to_commands(message: JointReading) -> list[tuple[int, float]]:
    """(joint, effort [N m]) of each of our joints in the message, other joints beside them left
    out. Raises MessageError, and then none of them counts.
    """
    if len(message.effort) != len(message.name):
        raise MessageError(
            f'joint_commands.effort: got {len(message.effort)} numbers; '
            f'allowed: {len(message.name)}, one for each name'
        )
    commands = [
        (JOINT_NAMES.index(name), effort)
        for name, effort in zip(message.name, message.effort)
        if name in JOINT_NAMES
    ]
    if not commands or len(dict(commands)) != len(commands):
        raise MessageError(
            f'joint_commands.name: got {_shown(message.name)}; '
            f'allowed: one or both of {list(JOINT_NAMES)}, once each, among others'
        )
    if not all(math.isfinite(effort) for _, effort in commands):
        raise MessageError(
            f'joint_commands.effort: got {_shown(list(message.effort))}; allowed: finite numbers'
        )
    return commands


def _one_joint(channel: str, message: JointReading, fields: tuple[str, ...]) -> int:
    if len(message.name) != 1 or message.name[0] not in JOINT_NAMES:
        raise MessageError(
            f'{channel}.name: got {_shown(message.name)}; allowed: one of {list(JOINT_NAMES)}'
        )
    for field in fields:
        values = getattr(message, field)
        if len(values) != 1 or not math.isfinite(values[0]):
            raise MessageError(
                f'{channel}.{field}: got {_shown(list(values))}; allowed: one finite number'
            )
    return JOINT_NAMES.index(message.name[0])


# -- the object's pose: (x, y, rotation) in the palm's frame [m, m, rad]


def to_planar(message: PoseStamped, field: str, frame: str = PALM_FRAME) -> np.ndarray:
    """(3,) of a pose in the palm's frame, `frame`; the rotation lies in (-π, π].

    field: what the message is called in a MessageError, which is raised for another frame, numbers
    that are not finite, and rotations that are not about z.
    """
    if message.header.frame_id not in ('', frame):
        raise MessageError(
            f'{field}.header.frame_id: got {_shown(message.header.frame_id)}; allowed: {frame!r}'
        )
    p, q = message.pose.position, message.pose.orientation
    if not all(map(math.isfinite, (p.x, p.y, p.z, q.x, q.y, q.z, q.w))):
        raise MessageError(
            f'{field}.pose: got a number that is not finite; allowed: finite numbers'
        )
    if abs(math.hypot(q.x, q.y, q.z, q.w) - 1.0) > 1e-3 or math.hypot(q.x, q.y) > PLANAR_TILT:
        raise MessageError(
            f'{field}.pose.orientation: got ({q.x}, {q.y}, {q.z}, {q.w}); '
            'allowed: a unit quaternion about z'
        )
    return np.array([p.x, p.y, math.atan2(2 * q.w * q.z, q.w**2 - q.z**2)])


def fill_pose(pose: Pose, planar: np.ndarray) -> None:
    """planar: (3,) x, y [m], rotation [rad]."""
    pose.position.x, pose.position.y = float(planar[0]), float(planar[1])
    fill_rotation(pose.orientation, planar[2])


def fill_rotation(quaternion: Quaternion, angle: float) -> None:
    """angle [rad] about z."""
    quaternion.z, quaternion.w = math.sin(angle / 2), math.cos(angle / 2)


def pose_message(stamp: Time, planar: np.ndarray, frame: str = PALM_FRAME) -> PoseStamped:
    """planar: (3,) x, y [m], rotation [rad] in the palm's frame, `frame`."""
    message = PoseStamped()
    message.header.frame_id, message.header.stamp = frame, stamp
    fill_pose(message.pose, planar)
    return message


def estimate_message(
    stamp: int, planar: np.ndarray, deviations: np.ndarray, frame: str = PALM_FRAME
) -> PoseWithCovarianceStamped:
    """planar (3,) [m, m, rad] in the palm's frame, `frame`, and its standard deviations (3,) at
    `stamp` [ns].

    What is not planar has a variance of zero.
    """
    message = PoseWithCovarianceStamped()
    message.header.frame_id = frame
    set_stamp(message.header.stamp, stamp)
    fill_pose(message.pose.pose, planar)
    covariance = np.zeros((6, 6))
    covariance[[0, 1, 5], [0, 1, 5]] = deviations**2
    message.pose.covariance = covariance.ravel()
    return message


# -- goals


def to_goal_id(plan_id: str) -> bytes:
    """16 bytes of a plan's UUID."""
    try:
        return uuid.UUID(plan_id).bytes
    except (ValueError, AttributeError, TypeError) as error:
        raise MessageError(f'plan id: got {_shown(plan_id)}; allowed: a UUID') from error


def goal_message(goal_id: bytes, stamp: Time) -> GoalInfo:
    """goal_id: 16 bytes."""
    message = GoalInfo(stamp=stamp)
    message.goal_id.uuid = np.frombuffer(goal_id, dtype=np.uint8)
    return message


def goal_id_of(message: GoalInfo) -> bytes:
    """16 bytes."""
    return bytes(bytearray(message.goal_id.uuid))


def goal_name(goal_id: bytes) -> str:
    """The UUID as text, which is the id of a plan."""
    return str(uuid.UUID(bytes=goal_id))


def goal_statuses(entries: Iterable[tuple[GoalInfo, int]]) -> GoalStatusArray:
    """entries: (GoalInfo, status) pairs."""
    return GoalStatusArray(
        status_list=[GoalStatus(goal_info=info, status=status) for info, status in entries]
    )


# -- trajectories


def to_joint_trajectory(
    trajectory: ManipulationTrajectory, stamp: Time, frame: str = PALM_FRAME
) -> JointTrajectory:
    """Positions, velocities and efforts of both joints, from `stamp` on; frame: of the palm."""
    message = JointTrajectory(joint_names=list(JOINT_NAMES))
    message.header.frame_id, message.header.stamp = frame, stamp
    rows = zip(
        trajectory.times.tolist(),
        trajectory.angles.tolist(),
        trajectory.velocities.tolist(),
        trajectory.efforts.tolist(),
    )
    for t, angles, velocities, efforts in rows:
        sec, nanosec = divmod(round(t * NANOSECONDS), NANOSECONDS)
        message.points.append(
            JointTrajectoryPoint(
                positions=angles,
                velocities=velocities,
                effort=efforts,
                time_from_start=Duration(sec=sec, nanosec=nanosec),
            )
        )
    return message


# -- key/values


def status_message(
    name: str, level: bytes, message: str, values: Optional[dict[str, Any]] = None
) -> DiagnosticStatus:
    """level: DiagnosticStatus.OK, WARN, ERROR or STALE."""
    pairs = [KeyValue(key=str(k), value=_text(v)) for k, v in (values or {}).items()]
    return DiagnosticStatus(
        level=level, name=name, message=message, hardware_id='wholearm', values=pairs
    )


def parameter_request(name: str, text: str) -> SetParameters.Request:
    """Sets the parameter `name` of a node to a text."""
    value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=text)
    return SetParameters.Request(parameters=[Parameter(name=name, value=value)])


def values_of(message: DiagnosticStatus) -> dict[str, str]:
    """Key → value."""
    return {pair.key: pair.value for pair in message.values}


def _text(value: Any) -> str:
    return f'{value:.6g}' if isinstance(value, float) else str(value)


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 80 else text[:77] + '...'
