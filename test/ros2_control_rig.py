"""Drives under ros2_control, for tests: one process that behaves on DDS as controller_manager with
joint_state_broadcaster, forward_command_controller (effort) and JointStateTopicSystem do.

Written after their sources (docs/your_hand.md names the lines); none of the originals is here. Their
joints: a wrist that is not ours, and two fingers in a convention of their own, which the robot
behind the topics does not share, as if a transmission lay between.

Usage: ros2_control_rig.py RATE [--plain] [--no-effort]; --plain: the robot's own names and signs;
--no-effort: joints without an effort state interface.
"""

import os
import sys
import threading
from contextlib import suppress

import numpy as np
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.qos import QoSPresetProfiles, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from wholearm_ros.control.periodic_timer import PeriodicTimer
from wholearm_ros.ros.interface.transport import choose_transport

ROBOT = ('left_finger_joint', 'right_finger_joint', 'wrist_joint')
OURS = {'joints': ['thumb', 'index'], 'signs': [-1.0, 1.0], 'offsets': [1.5, -0.25]}
PLAIN = {'joints': list(ROBOT[:2]), 'signs': [1.0, 1.0], 'offsets': [0.0, 0.0]}


class ControllerManager(Node):
    """read, update, write at `rate` [Hz]."""

    def __init__(self, rate, told, effort):
        super().__init__('controller_manager')
        self.names = ['wrist_joint', *told['joints']]
        self.signs, self.offsets = np.array(told['signs']), np.array(told['offsets'])
        self.effort = effort
        self.latest = JointState()  # JointStateTopicSystem: the newest one, however old
        self.state = np.full((3, 3), np.nan)  # [position, velocity, effort][robot's joint]
        self.command = np.full(2, np.nan)  # command interfaces before the first command
        self.forwarded = []
        self.robot = self.create_publisher(JointState, '/robot/joint_commands', QoSProfile(depth=1))
        self.create_subscription(
            JointState,
            '/robot/joint_states',
            self.on_robot,
            QoSPresetProfiles.SENSOR_DATA.value,
        )
        # SystemDefaultsQoS, with the depth that it gets: at depth 0 EventsExecutor takes nothing.
        defaults = QoSProfile(depth=1, reliability=ReliabilityPolicy.SYSTEM_DEFAULT)
        self.states = self.create_publisher(JointState, '/joint_states', defaults)
        self.create_subscription(
            Float64MultiArray, '/effort_controller/commands', self.on_commands, defaults
        )
        self.timer = PeriodicTimer(round(1e9 / rate))
        self.cycles = threading.Thread(target=self.run, daemon=True)
        self.cycles.start()

    def on_robot(self, message):
        self.latest = message

    def on_commands(self, message):
        """forward_command_controller drops a message with a number that is not finite."""
        if np.isfinite(message.data).all():
            self.forwarded = list(message.data)

    def run(self):
        while rclpy.ok():
            self.timer.wait()
            self.read()
            self.update()
            self.write()

    def read(self):
        """Of the joints it knows, what is finite; nothing tells how old it is."""
        latest = self.latest
        for place, name in enumerate(latest.name):
            if name not in ROBOT:
                continue
            for row, column in enumerate((latest.position, latest.velocity, latest.effort)):
                if len(column) and np.isfinite(column[place]):
                    self.state[row, ROBOT.index(name)] = column[place]

    def update(self):
        """The broadcaster: every joint in one message; the controller: the last command, for ever."""
        position, velocity, effort = self.state[:, :2]
        message = JointState(
            name=self.names,
            position=[0.25, *(self.signs * (position - self.offsets)).tolist()],
            velocity=[0.0, *(self.signs * velocity).tolist()],
            effort=[np.nan, *(self.signs * effort).tolist()] if self.effort else [np.nan] * 3,
        )
        message.header.stamp = self.get_clock().now().to_msg()
        self.states.publish(message)
        if len(self.forwarded) == 2:  # else the original deactivates itself with an error
            self.command = self.signs * self.forwarded

    def write(self):
        """trigger_joint_command_threshold -1: always, NaN before the first command, too."""
        message = JointState(name=ROBOT, effort=[*self.command.tolist(), 0.0])
        message.header.stamp = self.get_clock().now().to_msg()
        self.robot.publish(message)


if __name__ == '__main__':
    choose_transport()
    rclpy.init()
    sys.setswitchinterval(0.0005)
    options = sys.argv[2:]
    told = PLAIN if '--plain' in options else OURS
    with suppress(OSError):  # as controller_manager does, where it may
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(20))
    node = ControllerManager(float(sys.argv[1]), told, '--no-effort' not in options)
    executor = EventsExecutor()
    executor.add_node(node)
    while node.cycles.is_alive():  # spin() would hear nothing
        executor.spin_once(timeout_sec=1.0)
