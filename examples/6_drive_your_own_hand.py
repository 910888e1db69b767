"""Drive your own hand: the smallest node that stands in for `hand_hardware`.

Start the other nodes of the graph (mode_switcher, velocity_controller, torque_controller with
`motor_rate:=250.0`, trajectory_generator, contact_state_planner), each by `ros2 run wholearm_ros
NODE` or `python -m wholearm_ros.nodes.NODE`, then this file, and ask for a plan. For real motors
replace the class Motors and leave the rest.
"""

import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

import wholearm_ros as wa

JOINTS = ['left_finger_joint', 'right_finger_joint']
RATE = 250.0  # [Hz] of the motors; set `motor_rate` of torque_controller to the same
PERIOD = round(1e9 / RATE)  # [ns]


class Motors:
    """Yours go here. These are simulated, with the object between the fingers."""

    def __init__(self, scenario):
        self.hand = wa.make_hand('planar', scenario, rate=RATE)
        self.start = wa.start_configuration(scenario)
        self.hand.reset(self.start)
        self.hand.step(None)  # what must be compiled is compiled now, while nobody waits

    def reset(self):
        """The object lies at its start, the fingers are closed on it."""
        self.hand.reset(self.start)

    def read(self):
        """Angles (2,) [rad], velocities (2,) [rad/s], torques (2,) [N m]; left, right.

        An angle is the finger's direction from +x, counter-clockwise. Motors that measure no torque
        give the last one commanded.
        """
        return (*self.hand.joints(), self.hand.efforts())

    def write(self, torques):
        """For one period: torques (2,) [N m], gravity of the fingers included; None: hold them."""
        self.hand.step(torques)


class MyHand(Node):
    """joint_commands → motors → joint_states."""

    def __init__(self):
        super().__init__('hand_hardware', namespace='wholearm')
        # A real hand has no lockstep. It lets a simulated one wait until its state is answered.
        self.lockstep = self.declare_parameter('lockstep', False).value
        scenario = wa.load_scenario('asymmetric_hexagon')  # with your hand's lengths and limits
        self.motors = Motors(scenario)
        # Cuts torques to the limit, and knows what to do when commands are late: hold the fingers
        # after 15 ms, as long as this node runs.
        limits = [finger.torque_limit for finger in (scenario.hand.left, scenario.hand.right)]
        self.watchdog = wa.CommandWatchdog(limits, timeout=15_000_000)
        self.now = self.get_clock().now().nanoseconds
        self.states = self.create_publisher(JointState, 'joint_states', 10)
        self.create_subscription(JointState, 'joint_commands', self.on_command, 10)
        self.create_service(Trigger, 'hand_hardware/reset', self.on_reset)
        self.create_service(Trigger, 'hand_hardware/stop', self.on_stop)
        self.reset()
        if self.lockstep:
            self.create_timer(0.05, self.send)  # again, should a message have been lost
        else:
            self.create_timer(1.0 / RATE, self.period)

    def period(self):
        """One period of the motors, under what the watchdog decides."""
        self.motors.write(self.watchdog.decide(self.now))
        self.now += PERIOD  # real motors: the time of the measurement, get_clock().now()
        self.send()

    def send(self):
        """The state of both joints; its stamp comes back in the commands that answer it."""
        angles, velocities, torques = self.motors.read()
        message = JointState(
            name=JOINTS,
            position=angles.tolist(),
            velocity=velocities.tolist(),
            effort=torques.tolist(),
        )
        message.header.frame_id = 'palm'
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(self.now, 10**9)
        self.states.publish(message)

    def on_command(self, message):
        """The torque of one joint; whatever else somebody sends is ignored."""
        stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        for name, torque in zip(message.name, message.effort):
            if name in JOINTS and np.isfinite(torque):
                self.watchdog.command(JOINTS.index(name), stamp, torque, self.now)
        if self.lockstep and self.watchdog.both_at(self.now):
            self.period()

    def reset(self):
        """Object and fingers to the start; commands of before count no more."""
        self.motors.reset()
        self.now += PERIOD
        self.watchdog.reset(self.now)
        self.send()

    def on_reset(self, _, response):
        self.reset()
        response.success, response.message = True, 'back at the start'
        return response

    def on_stop(self, _, response):
        self.watchdog.stop()
        response.success, response.message = True, 'both fingers are held until the reset'
        return response


rclpy.init()
node = MyHand()
try:
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    pass
node.motors.write(np.zeros(2))  # no torque on the way out
