"""Drives that know only torques: watchdog and holding; and the map between two conventions."""

import numpy as np

from wholearm_ros import load_scenario
from wholearm_ros.control.command_watchdog import CommandWatchdog
from wholearm_ros.control.joint_map import JointMap
from wholearm_ros.control.setpoints import Joints, PdGains
from wholearm_ros.control.torque_drives import TorqueDrives

MS = 1_000_000  # [ns]
SCENARIO = load_scenario('asymmetric_hexagon')
WEIGHTS = np.array(
    [
        f.mass * SCENARIO.gravity.in_plane * f.shape.length / 2
        for f in (SCENARIO.hand.left, SCENARIO.hand.right)
    ]
)


def at(*angles, velocities=(0.0, 0.0)):
    return Joints(0.0, np.array(angles), np.array(velocities))


def drives():
    guard = CommandWatchdog([7.0, 7.0], 15 * MS, 500 * MS)
    return guard, TorqueDrives(SCENARIO, PdGains(10.0, 1.0), guard)


def test_holding_bears_the_weight_and_draws_back_to_where_it_began():
    _, held = drives()
    assert np.allclose(held.torques(1, at(1.0, 2.0)), WEIGHTS * np.cos([1.0, 2.0]))
    moved = held.torques(2, at(1.1, 2.0, velocities=(0.0, 0.5)))
    assert np.allclose(moved - WEIGHTS * np.cos([1.1, 2.0]), [-1.0, -0.5])
    held.release()
    assert np.allclose(held.torques(3, at(1.1, 2.0)), WEIGHTS * np.cos([1.1, 2.0]))
    assert abs(held.torques(4, at(9.0, -9.0))).tolist() == [7.0, 7.0]


def test_each_hold_begins_where_the_fingers_are_with_what_they_bore():
    guard, held = drives()
    held.torques(0, at(1.0, 2.0))
    for joint, torque in enumerate((3.0, -2.0)):
        guard.command(joint, MS, torque, MS)
    assert held.torques(MS, at(1.4, 1.8)).tolist() == [3.0, -2.0]
    assert np.allclose(held.torques(17 * MS, at(1.5, 1.7)), [3.0, -2.0])
    moved = held.torques(18 * MS, at(1.6, 1.7))
    weight = WEIGHTS[0] * (np.cos(1.6) - np.cos(1.5))
    assert np.allclose(moved, [3.0 - 10.0 * 0.1 + weight, -2.0])
    assert held.torques(600 * MS, at(1.5, 1.7)).tolist() == [0.0, 0.0]
    guard.reset(601 * MS)
    assert np.allclose(held.torques(601 * MS, at(1.5, 1.7)), WEIGHTS * np.cos([1.5, 1.7]))


def test_without_joints_there_is_no_torque_even_where_fresh_commands_are():
    guard, held = drives()
    for joint in (0, 1):
        guard.command(joint, MS, 1.0, MS)
    assert held.torques(MS, None).tolist() == held.torques(MS, at(np.nan, 1.0)).tolist() == [0, 0]


def test_power_and_angles_are_the_same_in_both_conventions():
    rng = np.random.default_rng(0)
    joint_map = JointMap(('a', 'b'), np.array([-1.0, 1.0]), np.array([0.4, -1.3]))
    theirs = Joints(1.0, *rng.normal(size=(3, 2)))
    ours, torque = joint_map.to_ours(theirs), rng.normal(size=2)
    assert np.allclose(ours.velocities * torque, theirs.velocities * joint_map.to_theirs(torque))
    assert np.allclose(joint_map.to_theirs(ours.efforts), theirs.efforts)
    assert np.allclose(ours.angles, [0.4 - theirs.angles[0], theirs.angles[1] - 1.3])
