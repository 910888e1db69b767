"""The simulated hand as a node, in real time or in lockstep. Replace it with yours."""

import json
import sys
import threading
import time
from typing import Optional

import numpy as np
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import Trigger

from wholearm_ros.control.command_watchdog import BRAKE, DRIVEN, CommandWatchdog
from wholearm_ros.control.periodic_timer import PeriodicTimer
from wholearm_ros.model.backends import BACKENDS, DEFAULT_BACKEND
from wholearm_ros.model.choices import CommandStamps, Pacing, values
from wholearm_ros.model.perturbation import numbered_perturbation
from wholearm_ros.rollout.initial_state import perturbed_start
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.common_parameters import (
    COMMAND_TIMEOUT,
    HOLD_TIME,
    PACING,
    SCENARIO,
    scenario_of,
)
from wholearm_ros.ros.interface.frames import Frames
from wholearm_ros.ros.interface.joint_state_serialization import NANOSECONDS, JointReading
from wholearm_ros.ros.interface.messages import (
    fill_pose,
    joint_states_bytes,
    pose_message,
    set_stamp,
    to_commands,
)
from wholearm_ros.ros.interface.parameters import Declared, ParameterError
from wholearm_ros.ros.node.drives_health import drives_health
from wholearm_ros.ros.node.loop_meter import LoopMeter
from wholearm_ros.ros.node.node import WARN, Health, WholeArmNode
from wholearm_ros.ros.node.run import run_node
from wholearm_ros.ros.visualization.markers import state_markers
from wholearm_ros.ros.visualization.robot_description import urdf
from wholearm_ros.simulation.factory import make_hand

DECLARED = (
    SCENARIO,
    PACING,
    Declared('backend', DEFAULT_BACKEND, 'the physics; planar is always there', choices=BACKENDS),
    Declared('view', False, "PyBullet's window, where there is a screen"),
    Declared(
        'perturb',
        0.0,
        'level of errors unknown to everybody else: mass, shape, friction, delay, torque, noise',
        0.0,
        10.0,
    ),
    Declared(
        'hand_errors',
        0.0,
        'level of errors of joints, encoder zeros, axes, gravity and start x, likewise',
        0.0,
        10.0,
    ),
    Declared('perturb_number', 0, 'which of the draws at these levels', 0, 1_000_000),
    Declared('motor_rate', 1000.0, 'of joint_states and of the motors [Hz]', 50.0, 2000.0),
    Declared('object_pose_rate', 100.0, 'of the truth on object_pose [Hz]', 1.0, 2000.0),
    COMMAND_TIMEOUT,
    Declared(
        'command_stamps',
        CommandStamps.answered.value,
        'answered: of the joint states they answer; arrival: any within stamp_tolerance of the '
        "clock, or 0, as ros2_control's are; realtime only",
        choices=values(CommandStamps),
    ),
    Declared(
        'stamp_tolerance', 0.1, 'of the stamps of commands that count on arrival [s]', 0.0, 10.0
    ),
    HOLD_TIME,
    Declared(
        'lockstep_timeout',
        10.0,
        'wait for the commands of a step after which the wait is reported [s]',
        0.1,
        600.0,
    ),
)
FIRST_STAMP = NANOSECONDS  # of simulated time: zero means "no time yet" in ROS
# [s] for which another thread of this process may keep the motors' thread waiting.
SWITCH_INTERVAL = 0.0002
REPEAT_PERIOD = 0.05  # [s] between two sendings of one state while lockstep waits
MOTORS_END_WITHIN = 0.5  # [s]; a few periods, unless the machine does not run them
SHOW_PERIOD = 0.1  # [s] between two sendings of markers and transforms


class HandHardware(WholeArmNode):
    """joint_commands → physics → joint_states; object_pose is the truth, for evaluation only."""

    def __init__(self) -> None:
        super().__init__('hand_hardware', DECLARED)
        p, self.scenario = self.parameters, scenario_of(self.parameters)
        self.lockstep = p.pacing == Pacing.lockstep.value
        self.period = round(NANOSECONDS / p.motor_rate)  # [ns]
        self.by_arrival = p.command_stamps == CommandStamps.arrival.value
        if self.by_arrival and self.lockstep:
            raise ParameterError(
                'hand_hardware: command_stamps: got arrival in lockstep, which waits for commands '
                'with its own stamps; allowed: answered'
            )

        self.perturbation = numbered_perturbation(
            p.perturb, p.perturb_number, self.scenario, p.hand_errors
        )
        self.hand = make_hand(p.backend, self.scenario, p.motor_rate, self.perturbation, p.view)
        self.start = perturbed_start(self.scenario, self.hand.scenario)
        self.hand.step(np.zeros(2))  # whatever must be compiled is compiled now
        self.hand.reset(self.start)
        hand = self.scenario.hand
        self.guard = CommandWatchdog(
            [hand.left.torque_limit, hand.right.torque_limit],
            round(p.command_timeout * NANOSECONDS),
            round(p.hold_time * NANOSECONDS) or None,
            round(p.stamp_tolerance * NANOSECONDS) if self.by_arrival else None,
        )
        self.steps, self.told_state, self.meter = 0, BRAKE, LoopMeter()
        self.pose_every = max(1, round(p.motor_rate / p.object_pose_rate))
        self.now = FIRST_STAMP if self.lockstep else self.get_clock().now().nanoseconds
        self.guard.reset(self.now)
        self.answered = time.monotonic()
        self.lock, self.leaving = threading.Lock(), False
        self.motors: Optional[threading.Thread] = None

        self.joint_states = self.publisher(channels.JOINT_STATES)
        self.object_pose = self.publisher(channels.OBJECT_POSE)
        self.description = self.publisher(channels.ROBOT_DESCRIPTION)
        self.description.publish(String(data=urdf(self.scenario, namespace=self.get_namespace())))
        self.markers, self.frames = self.publisher(channels.MARKERS), Frames(self, self.scenario)
        self.clock = self.publisher(channels.CLOCK) if self.lockstep else None
        self.subscription(channels.JOINT_COMMANDS, self.on_command)
        self.service(channels.RESET, self.on_reset)
        self.service(channels.HARDWARE_STOP, self.on_stop)
        self.clock_message = Clock()
        self.palm = self.frame(channels.PALM_FRAME)
        self.pose_message = pose_message(
            self.clock_message.clock, self.hand.object_pose(), self.palm
        )

        self.every(SHOW_PERIOD, self.show)
        if self.lockstep:
            self.every(REPEAT_PERIOD, self.repeat)
        else:
            sys.setswitchinterval(SWITCH_INTERVAL)
            self.timer = PeriodicTimer(self.period)
            self.motors = threading.Thread(target=self.run_on_the_wall_clock, daemon=True)
            self.motors.start()

    def on_command(self, message: JointReading) -> None:
        """In lockstep the second command of a stamp lets time go on."""
        commands, stamp = to_commands(message), message.stamp
        with self.lock:
            if self.by_arrival and stamp:  # of the sender's clock; ours may lag behind it
                stamp += self.now - self.get_clock().now().nanoseconds
            taken = [self.guard.command(k, stamp, effort, self.now) for k, effort in commands]
            if any(taken):
                self.meter.answered(stamp)
            if any(taken) and self.lockstep and self.guard.both_at(self.now):
                self.answered = time.monotonic()
                self.advance(self.now + self.period, self.guard.decide(self.now))

    def advance(self, now: int, efforts: Optional[np.ndarray]) -> None:
        """One period of physics, which ends at `now` [ns]."""
        if efforts is not None:
            self.meter.acts(min(self.guard.newest))
        self.hand.step(efforts)
        self.steps += 1
        self.now = now
        self.publish_state(self.steps % self.pose_every == 0)
        if self.guard.state != self.told_state:
            self.told_state = self.guard.state
            self.report()

    def publish_state(self, with_pose: bool) -> None:
        """The joints' state now, and where the object truly is."""
        if self.clock is not None:
            set_stamp(self.clock_message.clock, self.now)
            self.clock.publish(self.clock_message)
        self.meter.sent(self.now)
        self.joint_states.publish(
            joint_states_bytes(self.now, *self.hand.joints(), self.hand.efforts())
        )
        if with_pose:
            set_stamp(self.pose_message.header.stamp, self.now)
            fill_pose(self.pose_message.pose, self.hand.object_pose())
            self.object_pose.publish(self.pose_message)

    def repeat(self) -> None:
        """Lockstep: the state again, while the commands of its stamp are not here."""
        with self.lock:
            if time.monotonic() - self.answered > REPEAT_PERIOD / 2:
                self.publish_state(True)

    def show(self) -> None:
        """For RViz and Foxglove, as often as people can see."""
        with self.lock:
            now, pose, contacts = self.now, self.hand.object_pose(), self.hand.contacts()
            angles, _ = self.hand.joints()
        self.frames.publish(now, pose, angles)
        self.markers.publish(state_markers(self.scenario, pose, contacts, self.palm))

    def run_on_the_wall_clock(self) -> None:
        """Stamps advance by one period a step."""
        while not self.leaving:
            self.timer.wait()
            with self.lock:
                self.advance(self.now + self.period, self.guard.decide(self.now))

    def on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Object and fingers to the start."""
        with self.lock:
            self.hand.reset(self.start)
            self.now += self.period
            self.guard.reset(self.now)
            self.answered = time.monotonic()
            self.publish_state(True)
        response.success = True
        response.message = 'object and fingers are back at the start, the drives hold'
        return response

    def on_stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Bypasses every other node, from the motors' next period on."""
        with self.lock:
            self.guard.stop()
        response.success = True
        response.message = (
            'the drives hold both fingers and take no command until hand_hardware/reset'
        )
        return response

    def health(self) -> Health:
        """State of the drives, figures of the loop; an error where they wait for a reset."""
        guard, waiting = self.guard, time.monotonic() - self.answered
        values = {
            **guard.figures(),
            'pacing': self.parameters.pacing,
            'stamp': self.now,
            'steps': self.steps,
            channels.PERTURBATION: json.dumps(self.perturbation.to_dict()),
            **self.meter.figures(),
        }
        if not self.lockstep:
            values.update(
                {
                    'overruns': self.timer.overruns,
                    'worst lateness ms': self.timer.worst_late / 1e6,
                    'behind the wall clock ms': self.timer.behind / 1e6,
                    'slipped ms': self.timer.slipped / 1e6,
                }
            )
        patient = waiting <= self.parameters.lockstep_timeout
        if self.lockstep and guard.state == DRIVEN and not patient:
            return WARN, f'waiting {waiting:.0f} s for the commands of one step', values
        return drives_health(guard, values)

    def leave(self) -> None:
        """Zero torque. The motors' thread ends first: the hand is disconnected after that."""
        self.leaving = True
        if self.motors:
            self.motors.join(MOTORS_END_WITHIN)
        with self.lock:
            self.hand.step(np.zeros(2))
            self.hand.disconnect()


def main() -> None:
    """The executable."""
    run_node(HandHardware)


if __name__ == '__main__':
    main()
