"""The transport: what the environment makes of it, that no publish waits for newcomers, and who can listen."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from ros_graph import udp_sockets

from wholearm_ros.launcher.client import Client
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.messages import values_of
from wholearm_ros.ros.interface.transport import (
    DISCOVERY,
    LOOPBACK,
    NETWORK,
    PROFILE,
    choose_transport,
)

NEWCOMERS = 12
STALL = 200.0  # [ms]; the health check of a port in shared memory takes 333 ms, or a multiple of it
HARDWARE = {'motor_rate': 500.0, 'backend': 'planar', 'priority': 20, 'diagnostics_rate': 10.0}


@pytest.mark.parametrize('discovery', [{}, {DISCOVERY: ''}, {DISCOVERY: 'LOCALHOST'}])
def test_a_process_binds_the_loopback_unless_told_otherwise(discovery):
    environment = {**discovery, 'ROS_LOCALHOST_ONLY': '1'}
    assert 'this machine only' in choose_transport(environment)
    chosen = {PROFILE: LOOPBACK, DISCOVERY: 'SYSTEM_DEFAULT'}
    assert environment == chosen
    assert 'this machine only' in choose_transport(environment) and environment == chosen, (
        'a process started by it follows'
    )


@pytest.mark.parametrize('network, discovery', [(True, ''), (True, 'LOCALHOST'), (False, 'SUBNET')])
def test_the_user_opens_the_network(network, discovery):
    environment = {DISCOVERY: discovery}
    assert 'every interface' in choose_transport(environment, network)
    assert environment == {PROFILE: NETWORK, DISCOVERY: 'SUBNET'}
    assert 'every interface' in choose_transport(environment)


@pytest.mark.parametrize(
    'name, value',
    [
        (PROFILE, '/mine.xml'),
        ('FASTDDS_DEFAULT_PROFILES_FILE', '/mine.xml'),
        ('FASTDDS_BUILTIN_TRANSPORTS', 'DEFAULT'),
        ('RMW_IMPLEMENTATION', 'rmw_cyclonedds_cpp'),
    ],
)
def test_what_the_user_chose_stays_and_discovery_is_closed(name, value):
    environment = {name: value}
    assert f'{name}={value}' in choose_transport(environment)
    assert environment == {name: value, DISCOVERY: 'LOCALHOST'}
    environment = {name: value, DISCOVERY: 'SUBNET'}
    choose_transport(environment)
    assert environment == {name: value, DISCOVERY: 'SUBNET'}


@pytest.mark.parametrize('profile', [LOOPBACK, NETWORK])
def test_the_profiles_are_read(profile, domain):
    """Fast DDS tells of what it does not understand on standard error, and goes on without."""
    code = 'import rclpy; rclpy.init(); rclpy.create_node("reader"); rclpy.shutdown()'
    environment = {**os.environ, PROFILE: profile, DISCOVERY: 'SYSTEM_DEFAULT'}
    done = subprocess.run(
        [sys.executable, '-c', code], env=environment, capture_output=True, text=True, timeout=100
    )
    assert done.returncode == 0 and not done.stdout + done.stderr


def test_no_publish_waits_for_participants_that_come_and_go(graph):
    graph.start(('hand_hardware',), 'realtime', hand_hardware=HARDWARE)
    states, said = graph.listen(channels.JOINT_STATES), graph.listen(channels.DIAGNOSTICS)
    graph.wait(lambda: len(states) > 100, 'joint_states')
    for k in range(NEWCOMERS):
        newcomer, heard = Client(name=f'newcomer_{k}'), []
        topic = channels.JOINT_STATES
        newcomer.node.create_subscription(topic.type, topic.name, heard.append, topic.qos)
        newcomer.wait(lambda heard=heard: len(heard) > 10, 100.0, 'joint_states')
        newcomer.close()
    said.clear()
    graph.wait(lambda: said, 'diagnostics')
    told = values_of(said[-1].status[0])
    assert float(told['longest publish ms']) < STALL, told['longest publish topic']


def test_a_node_binds_nothing_but_the_loopback_interface(graph):
    graph.start(('hand_hardware',), 'realtime', hand_hardware=HARDWARE)
    states = graph.listen(channels.JOINT_STATES)
    graph.wait(lambda: states, 'joint_states')
    pid = graph.processes.pid('hand_hardware')
    assert {address for address, _ in udp_sockets(pid)} == {'127.0.0.1'}
    assert '/dev/shm/fastrtps' not in Path(f'/proc/{pid}/maps').read_text(), (
        'shared memory is in use'
    )


@pytest.mark.parametrize('discovery', ['LOCALHOST', None])
def test_a_process_of_somebody_else_on_this_machine_hears_and_is_heard(graph, discovery):
    """One with Fast DDS's own transports: shared memory, every interface, multicast."""
    graph.start(('hand_hardware',), 'realtime', hand_hardware=HARDWARE)
    code = """
import rclpy
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
rclpy.init()
node, heard = rclpy.create_node('stranger'), []
node.create_subscription(JointState, '/wholearm/joint_states', heard.append, 10)
reset = node.create_client(Trigger, '/wholearm/hand_hardware/reset')
assert reset.wait_for_service(100.0)
future = reset.call_async(Trigger.Request())
while not (heard and future.done()):
    rclpy.spin_once(node, timeout_sec=0.1)
"""
    environment = {
        key: value for key, value in os.environ.items() if key not in (PROFILE, DISCOVERY)
    }
    if discovery:
        environment[DISCOVERY] = discovery
    done = subprocess.run(
        [sys.executable, '-c', code], env=environment, capture_output=True, text=True, timeout=140
    )
    assert done.returncode == 0, done.stderr
