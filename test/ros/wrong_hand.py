"""A hand with one mistake: degrees, sign (of both angles' motion), or no watchdog."""

import sys

import numpy as np
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

import wholearm_ros as wa
from wholearm_ros.model.hand import JOINT_NAMES

DT = 1.0 / 250.0
START = np.full(2, np.pi / 2)  # upright: no weight to bear


class WrongHand(Node):
    """Two fingers in the air, their weight borne."""

    def __init__(self, wrong):
        super().__init__('hand_hardware', namespace='wholearm')
        self.wrong, scenario = wrong, wa.load_scenario('asymmetric_hexagon')
        fingers = scenario.hand.left, scenario.hand.right
        self.inertia = np.array([f.inertia for f in fingers])
        weights = [f.mass * scenario.gravity.in_plane * f.shape.length / 2 for f in fingers]
        self.weights = np.array(weights)
        timeout = 10**15 if wrong == 'watchdog' else 15_000_000
        self.guard = wa.CommandWatchdog([7.0, 7.0], timeout, 500_000_000)
        self.states = self.create_publisher(JointState, 'joint_states', 10)
        self.create_subscription(JointState, 'joint_commands', self.on_command, 10)
        self.create_service(Trigger, 'hand_hardware/reset', self.on_reset)
        self.create_service(Trigger, 'hand_hardware/stop', self.on_stop)
        self.reset()
        self.create_timer(DT, self.period)

    def reset(self):
        self.angles, self.velocities = START.copy(), np.zeros(2)
        self.guard.reset(self.get_clock().now().nanoseconds)

    def period(self):
        now = self.get_clock().now()
        torques, weights = self.guard.decide(now.nanoseconds), self.weights * np.cos(self.angles)
        if torques is None:
            torques, self.velocities = weights, np.zeros(2)
        else:
            sign = -1.0 if self.wrong == 'sign' else 1.0
            self.velocities = self.velocities + sign * (torques - weights) / self.inertia * DT
            self.angles = self.angles + self.velocities * DT
        unit = np.degrees if self.wrong == 'degrees' else np.array
        message = JointState(
            name=JOINT_NAMES,
            position=unit(self.angles).tolist(),
            velocity=unit(self.velocities).tolist(),
            effort=torques.tolist(),
        )
        message.header.stamp = now.to_msg()
        self.states.publish(message)

    def on_command(self, message):
        stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        joint, now = JOINT_NAMES.index(message.name[0]), self.get_clock().now().nanoseconds
        self.guard.command(joint, stamp, message.effort[0], now)

    def on_reset(self, _, response):
        self.reset()
        response.success = True
        return response

    def on_stop(self, _, response):
        self.guard.stop()
        response.success = True
        return response


rclpy.init()
rclpy.spin(WrongHand(sys.argv[1]))
