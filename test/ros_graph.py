"""A graph of real node processes and a client in it, for tests."""

import os
import time
from pathlib import Path

from wholearm_ros.launcher.client import Client
from wholearm_ros.launcher.processes import Processes
from wholearm_ros.ros.interface import channels

WAIT = 150.0  # [s] a bound, not a measure: machines may be loaded
LOOP = ('hand_hardware', 'mode_switcher', 'velocity_controller', 'torque_controller')
ALL = (*LOOP, 'trajectory_generator', 'contact_state_planner')
WHOLE = (*ALL, 'reorientation', 'object_observer')
PACED = ('hand_hardware', 'mode_switcher')


class Graph:
    """Node processes, a client, and what the client heard on the topics it was told to listen to."""

    def __init__(self, log_directory: Path, namespace: str = channels.NAMESPACE):
        self.processes, self.namespace = Processes(log_directory), namespace
        self.client = Client(name='test_client', namespace=namespace)
        self.node, self.heard = self.client.node, {}

    def start(self, nodes, pacing='lockstep', **parameters):
        """`parameters`: by node name, dictionaries."""
        for name in nodes:
            paced = {'pacing': pacing} if name in PACED else {}
            told = {**paced, **parameters.get(name, {})}
            self.processes.start(name, told, f'/{self.namespace}')
        self.client.watch = self.processes.check

    def listen(self, topic: channels.Topic) -> list:
        """A list that grows with every message of `topic`."""
        messages = self.heard.setdefault(topic.name, [])
        self.node.create_subscription(topic.type, topic.name, messages.append, topic.qos)
        return messages

    def talk(self, topic: channels.Topic, subscribers: int = 1):
        """A publisher that has found its subscribers."""
        publisher = self.node.create_publisher(topic.type, topic.name, topic.qos)
        self.wait(
            lambda: publisher.get_subscription_count() >= subscribers,
            f'subscribers of {topic.name}',
        )
        return publisher

    def wait(self, condition, what: str = 'condition', seconds: float = WAIT):
        self.client.wait(condition, seconds, what)

    def spin(self, seconds: float):
        """Only to give something unwanted the time to happen."""
        until = time.monotonic() + seconds
        self.client.wait(lambda: time.monotonic() > until, seconds + 1.0, 'time')

    def plan(self):
        """Calls plan_scenario and waits until its trajectory is here."""
        answer = self.client.call(channels.PLAN_SCENARIO, WAIT)
        assert answer.success, answer.message
        heard = self.client.latest
        self.wait(
            lambda: heard.plan and heard.trajectory and heard.trajectory.plan_id == heard.plan.id,
            'trajectory',
        )
        return heard.plan

    def execute(self, plan_id: str) -> dict:
        """Sends the goal and waits for its result."""
        self.client.send_goal(plan_id)
        self.wait(lambda: self.client.latest.result, 'result')
        return self.client.latest.result

    def close(self):
        self.client.close()
        self.processes.stop()


def udp_sockets(pid: int) -> set:
    """(local address, port) of the UDP sockets of process `pid`."""
    own = set()
    for descriptor in Path(f'/proc/{pid}/fd').iterdir():
        try:
            own.add(os.readlink(descriptor))
        except OSError:
            continue  # closed meanwhile
    rows = [line.split() for line in Path('/proc/net/udp').read_text().splitlines()[1:]]
    local = [row[1].split(':') for row in rows if f'socket:[{row[9]}]' in own]
    return {
        ('.'.join(str(byte) for byte in bytes.fromhex(address)[::-1]), int(port, 16))
        for address, port in local
    }
