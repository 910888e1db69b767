"""Feels what lies in the hand before anything is planned: the loop and the generator alone."""

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

from wholearm_ros.launcher.client import Client
from wholearm_ros.launcher.launcher import (
    LOCKSTEP_SLOWNESS,
    LONGEST_SILENCE,
    START_WITHIN,
    RunOptions,
    node_parameters,
)
from wholearm_ros.launcher.processes import Processes, alone_in_domain
from wholearm_ros.ros.interface import channels

NODES = (
    'hand_hardware',
    'mode_switcher',
    'velocity_controller',
    'torque_controller',
    'trajectory_generator',
)


def feel_graph(options: RunOptions, in_hand: str, tell: Callable[[str], None]) -> dict[str, str]:
    """The values of the generator's result: kind, edges, x and its deviation, probability, reason.

    in_hand: the scenario whose object the simulated hand truly has. Raises DomainTaken at the
    start, NodeDied or GraphError when the graph breaks.
    """
    parameters = {
        name: values for name, values in node_parameters(options).items() if name in NODES
    }
    parameters['hand_hardware']['scenario'] = in_hand
    with alone_in_domain(), tempfile.TemporaryDirectory(prefix='wholearm_') as scratch:
        with Processes(Path(scratch)) as processes:
            for node, values in parameters.items():
                processes.start(node, values)
            client = Client(watch=processes.check)
            try:
                return _feel(client, options, tell)
            finally:
                client.close()


def _feel(client: Client, options: RunOptions, tell: Callable[[str], None]) -> dict[str, str]:
    tell('starting the nodes')
    count = client.node.count_subscribers
    for topic, least in (
        (channels.JOINT_STATES, 3),
        (channels.JOINT_COMMANDS, 1),
        (channels.MANIPULATION_TRAJECTORY, 2),
        (channels.GOAL, 1),
        (channels.GOAL_STATUS, 1),
    ):
        client.wait(partial(_there, count, topic.name, least), START_WITHIN, f'topic {topic.name}')
    client.wait(
        lambda: bool(client.latest.progress.get('angles')), START_WITHIN, channels.PROGRESS.name
    )
    tell('feeling')
    client.feel()
    slowness = LOCKSTEP_SLOWNESS if options.pacing == 'lockstep' else 1.0
    client.wait(
        lambda: bool(client.latest.result), slowness * LONGEST_SILENCE, channels.RESULT.name
    )
    return dict(client.latest.result)


def _there(count: Callable[[str], int], topic: str, least: int) -> bool:
    return count(topic) >= least
