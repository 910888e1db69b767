"""Listens to a hand on the graph, moves its fingers a little where asked, and has it judged."""

import time
from collections.abc import Callable

import numpy as np
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState

from wholearm_ros.control.hand_checks import (
    HOLD_TIME,
    Check,
    Push,
    Sample,
    Silence,
    check_listening,
    check_moving,
    in_order,
    not_moved,
)
from wholearm_ros.launcher.client import Client, GraphError
from wholearm_ros.model.hand import CLOSING, JOINT_NAMES, LEFT, RIGHT, Finger
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.weight import bearing_torques
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import (
    JointReading,
    MessageError,
    read_joints,
)
from wholearm_ros.ros.interface.messages import effort_bytes, to_joints
from wholearm_ros.ros.interface.transport import choose_transport

HEARD_WITHIN = 10.0  # [s] for the first state
STEP = 0.05  # of the torque limit, beyond the finger's weight; less for a light finger:
ACCELERATION = 15.0  # [rad/s²] at most
ENOUGH = 0.02  # [rad] after which a push ends
FURTHEST, FASTEST = 0.1, 1.5  # [rad], [rad/s] beyond which every command ends
ROOM = 0.15  # [rad] to the angle limit towards which a finger is pushed
SETTLE, PUSH, BRAKE = 0.3, 0.4, 0.3  # [s]
SILENCE = HOLD_TIME + 0.5  # [s]
STOPPED = 0.3  # [s] of commands after the stop
STIFFNESS, DAMPING = 100.0, 20.0  # of the inertia, in the hold between pushes [1/s²], [1/s]
RESET_WITHIN, STOP_WITHIN = 20.0, 3.0  # [s] for the answer


class Aborted(Exception):
    """A finger went further or faster than it may, or the states ended."""


def plan_of_motion(scenario: Scenario) -> str:
    """What `check_hand` will do to the hand, for its user to read before."""
    steps = [_step(scenario.hand[k]) for k in (LEFT, RIGHT)]
    return (
        '--move: calls hand_hardware/reset before each step, pushes the fingers one after the '
        f'other by {ENOUGH} rad with {steps[0]:.2f} and {steps[1]:.2f} N m beyond their weight for '
        f'at most {PUSH} s, stops commanding for {SILENCE:.1f} s (the torque then is zero: fingers '
        'may fall), calls hand_hardware/stop, and leaves the hand stopped. '
        f'Ends at {FURTHEST} rad or {FASTEST} rad/s.'
    )


def _step(finger: Finger) -> float:
    """[N m]"""
    return min(STEP * finger.torque_limit, ACCELERATION * finger.inertia)


def check_hand(
    scenario: Scenario, rate: float, seconds: float, move: bool, tell: Callable[[str], None]
) -> list[Check]:
    """Raises GraphError when no hand is heard, or when others command it and it shall move."""
    choose_transport()
    client = Client(name='wholearm_check_hand')
    try:
        return _Examiner(client, scenario, tell).examine(rate, seconds, move)
    finally:
        client.close()


def _ours(reading: JointReading) -> JointReading:
    """Our two joints in order; the reading itself where it does not hold them."""
    try:
        stamp, joints = to_joints(reading)
    except MessageError:
        return reading
    columns = (joints.angles, joints.velocities, joints.efforts)
    return JointReading(stamp, JOINT_NAMES, *(tuple(column.tolist()) for column in columns))


class _Examiner:
    """Answers each joint state with what `law` says of it, [N m] for both joints; None: nothing."""

    def __init__(self, client: Client, scenario: Scenario, tell: Callable[[str], None]) -> None:
        self.client, self.scenario, self.tell = client, scenario, tell
        self.samples: list[Sample] = []
        self.law: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None
        self.abort = ''
        self.centre = np.zeros(2)
        self.commands: Publisher | None = None
        client.node.create_subscription(
            JointState, channels.JOINT_STATES.name, self._on_state, channels.NO_RESENDING, raw=True
        )

    def _on_state(self, data: bytes) -> None:
        try:
            reading = read_joints(data)
        except MessageError:
            return
        sample = Sample(self.client.node.get_clock().now().nanoseconds, *_ours(reading))
        self.samples.append(sample)
        if self.law is None or self.abort or self.commands is None:
            return
        if (
            sample.names != JOINT_NAMES
            or not np.isfinite([*sample.position, *sample.velocity]).all()
        ):
            self.abort = 'aborted: a state that cannot be used'
            return
        angles, velocities = np.array(sample.position), np.array(sample.velocity)
        if (np.abs(angles - self.centre) > FURTHEST).any():
            self.abort = f'aborted: moved more than {FURTHEST} rad'
        elif (np.abs(velocities) > FASTEST).any():
            self.abort = f'aborted: faster than {FASTEST} rad/s'
        efforts = np.zeros(2) if self.abort else self.law(angles, velocities)
        for joint, effort in enumerate(efforts):
            self.commands.publish(effort_bytes(sample.stamp, joint, float(effort)))

    def examine(self, rate: float, seconds: float, move: bool) -> list[Check]:
        """All of it."""
        topic = channels.JOINT_STATES.name
        self.client.wait(lambda: len(self.samples) > 1, HEARD_WITHIN, f'no hand heard on {topic}')
        self.tell(f'listening for {seconds:.0f} s')
        self.samples.clear()
        self._spin(seconds)
        if len(self.samples) < 2:
            raise GraphError(f'no hand heard on {topic}: {len(self.samples)} states')
        checks = check_listening(self.samples, self.scenario.hand, rate)
        if not move:
            return checks + not_moved()
        if not all(c.passed for c in checks if c.name not in ('rate', 'jitter')):
            return checks + not_moved('not tried: unsafe before the checks above pass')
        return checks + self._move()

    def _move(self) -> list[Check]:
        if self.client.node.count_publishers(channels.JOINT_COMMANDS.name):
            raise GraphError(
                f'{channels.JOINT_COMMANDS.name}: another node commands this hand; --move needs it '
                'alone'
            )
        topic = channels.JOINT_COMMANDS
        self.commands = self.client.node.create_publisher(topic.type, topic.name, topic.qos)
        self.client.wait_for_subscribers(HEARD_WITHIN, ((topic, 1),))
        try:
            return self._phases()
        finally:
            self.law = None
            self._call_stop()

    def _call_stop(self) -> bool:
        """Whether the hand said that it stopped."""
        try:
            return bool(self.client.call(channels.HARDWARE_STOP, STOP_WITHIN).success)
        except GraphError:
            return False

    def _phases(self) -> list[Check]:
        pushes, silence, stop = [], None, None
        for joint in (LEFT, RIGHT):
            self.tell(f'pushing {JOINT_NAMES[joint]}')
            self._begin()
            pushes.append(self._push(joint))
            if self.abort:
                break
        hand = self.scenario.hand
        checks = check_moving(pushes, None, None, hand)
        if not any(c.passed is False for c in checks if c.name.startswith(('motion', 'sign'))):
            self.tell('no commands: the watchdog')
            self._begin()
            silence = self._silence()
            self.tell('stop service')
            self._begin()
            stop = self._stop()
        return check_moving(pushes, silence, stop, hand)

    def _begin(self) -> None:
        """Reset, then hold both fingers where they are."""
        self.law, self.abort = None, ''
        self.client.call(channels.RESET, RESET_WITHIN)
        self._spin(0.1)
        self.samples.clear()
        self.client.wait(lambda: self.samples, HEARD_WITHIN, channels.JOINT_STATES.name)
        self.centre = in_order(self.samples[-1:])[0][0]
        self.law = self._hold
        self._spin(SETTLE)

    def _push(self, joint: int) -> Push:
        """Until it has moved ENOUGH either way; then it is braked."""
        step = self._away(joint)
        extra = np.where(np.arange(2) == joint, step, 0.0)
        before, start = len(self.samples) - 1, self.samples[-1].position
        self.law = lambda q, v: np.where(
            np.arange(2) == joint, self._weights(q) + extra, self._hold(q, v)
        )
        began = self.client.node.get_clock().now().nanoseconds
        self._spin(
            PUSH, lambda: np.abs(np.subtract(self.samples[-1].position, start)).max() > ENOUGH
        )
        samples, aborted = self.samples[before:], self.abort
        self.law = self._hold
        self._spin(BRAKE)
        return Push(joint, step, began, samples, aborted)

    def _silence(self) -> Silence:
        """After a last command that moves both fingers: without a watchdog they run on, and are
        stopped.
        """
        extra = np.array([self._away(LEFT), self._away(RIGHT)])
        heard = len(self.samples)
        self.law = lambda q, v: self._weights(q) + extra
        self._spin(SETTLE, lambda: len(self.samples) > heard)
        self.law = None
        began, before = self.client.node.get_clock().now().nanoseconds, len(self.samples)
        until_zero = time.monotonic() + HOLD_TIME
        self._spin(SILENCE, lambda: time.monotonic() < until_zero and self._far())
        if self._far() and time.monotonic() < until_zero:
            self._call_stop()
        return Silence(began, self.samples[before:])

    def _stop(self) -> Silence:
        answered = self._call_stop()
        began, before = self.client.node.get_clock().now().nanoseconds, len(self.samples)
        extra = np.array([self._away(LEFT), self._away(RIGHT)])
        self.law = lambda q, v: self._weights(q) + extra
        self._spin(STOPPED)
        self.law = None
        return Silence(began, self.samples[before:], answered)

    def _far(self) -> bool:
        return bool((np.abs(in_order(self.samples[-1:])[0][0] - self.centre) > FURTHEST).any())

    def _away(self, joint: int) -> float:
        """[N m] of the step: opening, or closing where there is no room to open."""
        finger, sign = self.scenario.hand[joint], -CLOSING[joint]
        low, high = finger.angle_limits
        angle = self.centre[joint]
        if (high - angle if sign > 0 else angle - low) < ROOM:
            sign = -sign
        return float(sign * _step(finger))

    def _weights(self, angles: np.ndarray) -> np.ndarray:
        """(2,) [N m] that bear the fingers at `angles`."""
        return bearing_torques(self.scenario.finger_weights, angles)

    def _hold(self, angles: np.ndarray, velocities: np.ndarray) -> np.ndarray:
        """(2,) [N m]: weight, and a soft spring to where the phase began, cut to the step."""
        fingers = [self.scenario.hand[k] for k in (LEFT, RIGHT)]
        inertia = np.array([f.inertia for f in fingers])
        most = np.array([_step(f) for f in fingers])
        pull = inertia * (STIFFNESS * (self.centre - angles) - DAMPING * velocities)
        efforts: np.ndarray = self._weights(angles) + np.clip(pull, -most, most)
        return efforts

    def _spin(self, seconds: float, until: Callable[[], bool] = lambda: False) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end and not until() and not self.abort:
            self.client.executor.spin_once(timeout_sec=0.01)
