"""Feels what lies in the hand before anything is planned: the loop and the generator alone."""

from collections.abc import Callable

from wholearm_ros.launcher.client import Client
from wholearm_ros.launcher.launcher import (
    LOCKSTEP_SLOWNESS,
    LONGEST_SILENCE,
    START_WITHIN,
    RunOptions,
    node_parameters,
    running_graph,
)
from wholearm_ros.model.choices import Pacing
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
    with running_graph(parameters) as client:
        return _feel(client, options, tell)


def _feel(client: Client, options: RunOptions, tell: Callable[[str], None]) -> dict[str, str]:
    tell('starting the nodes')
    client.wait_for_subscribers(
        START_WITHIN,
        (
            (channels.JOINT_STATES, 3),
            (channels.JOINT_COMMANDS, 1),
            (channels.MANIPULATION_TRAJECTORY, 2),
            (channels.GOAL, 1),
            (channels.GOAL_STATUS, 1),
        ),
    )
    client.wait(
        lambda: bool(client.latest.progress.get('angles')), START_WITHIN, channels.PROGRESS.name
    )
    tell('feeling')
    client.feel()
    slowness = LOCKSTEP_SLOWNESS if options.pacing == Pacing.lockstep.value else 1.0
    client.wait(
        lambda: bool(client.latest.result), slowness * LONGEST_SILENCE, channels.RESULT.name
    )
    return dict(client.latest.result)
