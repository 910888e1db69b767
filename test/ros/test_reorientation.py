"""The supervisor on the real graph: a goal to its end, refused, canceled and ended in each phase; a probe before any plan."""

import json
import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from action_msgs.msg import GoalInfo
from builtin_interfaces.msg import Time
from ros_graph import ALL, LOOP, WHOLE
from unique_identifier_msgs.msg import UUID

from wholearm_ros.model.perturbation import draw_perturbation
from wholearm_ros.model.scenario_file import load_scenario, scenario_to_dict
from wholearm_ros.report.bag_run import read_runs
from wholearm_ros.report.html.write import write_report
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.goals import CANCELED, EXECUTING
from wholearm_ros.ros.interface.messages import (
    FEEL_GOAL,
    NO_GOAL,
    goal_message,
    goal_name,
    values_of,
)

pytestmark = pytest.mark.timeout(280)
QUICK = {
    'hand_hardware': {'motor_rate': 250.0, 'backend': 'planar'},
    'torque_controller': {'motor_rate': 250.0},
}


def reached(graph) -> dict:
    """The result of the goal that was sent last."""
    graph.wait(lambda: graph.client.latest.reached, 'reorientation/result')
    return graph.client.latest.reached


def in_phase(graph, phase: str, mode: str = '') -> None:
    """Waits until the goal is there."""

    def there():
        told = graph.client.latest.reorientation
        return told.get('phase') == phase and mode in told.get('mode', '')

    graph.wait(there, f'{phase} {mode}')


def supervised(graph, **more) -> None:
    """The whole graph, the supervisor ready for goals."""
    graph.start(WHOLE, **{**QUICK, **more})
    graph.client.wait_for_graph(120.0)
    topic = channels.REORIENTATION_GOAL.name
    graph.wait(lambda: graph.node.count_subscribers(topic) > 0, topic)


def test_a_goal_is_refused_canceled_in_each_phase_and_reached(graph):
    supervised(graph)
    graph.client.reorient()
    in_phase(graph, 'planning')
    graph.client.cancel_reorientation()
    result = reached(graph)
    assert (result['outcome'], result['reason']) == ('canceled', 'canceled while planning')

    graph.client.reorient()  # though the planner may be busy with the plan of the other one
    in_phase(graph, 'executing', 'quasi_static')
    first = graph.client._reorient_id
    second = graph.client.reorient()  # while busy
    result = reached(graph)
    assert result['outcome'] == 'rejected' and f'busy with goal {first}' in result['reason']
    assert second != first
    graph.client.cancel_reorientation()
    graph.wait(lambda: graph.client.latest.mode == 'stopped', 'the hand to hold')

    assert graph.client.call(channels.RESET, 60.0).success
    graph.client.reorient()
    result = reached(graph)
    assert result['outcome'] == 'succeeded', result
    assert (result['claimed'], result['felt_edge'], result['attempts']) == ('at_goal', '5', '1')
    tries = json.loads(result['tries'])
    assert len(tries) == 1 and tries[0]['goal_id'] == graph.client.latest.plan.id
    assert tries[0]['stamp'] == result['stamp']


def test_a_planner_that_dies_ends_the_goal(graph):
    supervised(graph)
    graph.client.watch = lambda: None
    graph.client.reorient()
    in_phase(graph, 'planning')
    os.kill(graph.processes.pid('contact_state_planner'), signal.SIGKILL)
    result = reached(graph)
    assert result['outcome'] == 'aborted' and 'contact_state_planner is gone' in result['reason']


def test_a_stop_while_probing_ends_the_goal(graph):
    supervised(graph)
    graph.client.reorient()
    in_phase(graph, 'executing', 'probing')
    assert graph.client.call(channels.STOP, 60.0).success
    result = reached(graph)
    assert result['outcome'] == 'aborted' and 'stop' in result['reason']
    assert result['tries'] and not json.loads(result['tries'])[0]['claimed']


def test_what_lies_in_the_hand_is_felt_before_anything_is_planned(graph):
    """By the generator's goal of that id; the planner is not needed."""
    graph.start((*LOOP, 'trajectory_generator'), **QUICK)
    assert 'contact_state_planner' in ALL
    goal = graph.talk(channels.GOAL)
    graph.wait(lambda: graph.client.latest.progress.get('angles'), 'where the fingers are')
    graph.client._request_stamp = ''
    goal.publish(goal_message(FEEL_GOAL, graph.node.get_clock().now().to_msg()))
    graph.wait(lambda: graph.client.latest.result, 'result')
    result = graph.client.latest.result
    assert result['goal_id'] == goal_name(FEEL_GOAL)
    assert (result['claimed'], result['felt_edge']) == ('elsewhere', '0'), result
    assert float(result['felt_x']) == pytest.approx(-0.02, abs=2e-3)

    goal.publish(GoalInfo(goal_id=UUID(uuid=[7] * 16)))
    heard = heard_late(graph, channels.RESULT, 2)
    assert [told['outcome'] for told in heard] == [result['outcome'], 'rejected']
    assert heard[0] == result


def heard_late(graph, topic: channels.Topic, number: int) -> list[dict]:
    """What a subscriber hears that comes after so many results."""
    first, late = graph.listen(topic), []
    graph.wait(lambda: len(first) == number, topic.name)
    graph.node.create_subscription(topic.type, topic.name, late.append, topic.qos)
    graph.wait(lambda: len(late) == number, topic.name)
    return [values_of(message) for message in late]


def test_a_rejection_hides_no_result_and_each_names_its_request(graph):
    """A goal that is canceled while its planner is looked for, the same id again, one of no id."""
    graph.start(('reorientation',))
    goal, cancel = (
        graph.talk(channels.REORIENTATION_GOAL),
        graph.talk(channels.REORIENTATION_CANCEL),
    )
    status = graph.listen(channels.REORIENTATION_STATUS)

    def latest() -> int:
        return status[-1].status_list[-1].status if status and status[-1].status_list else 0

    for second in (1, 2):
        goal.publish(goal_message(bytes([7] * 16), Time(sec=second)))
        graph.wait(lambda: latest() == EXECUTING, 'executing')
        if second == 1:
            cancel.publish(goal_message(NO_GOAL, Time()))
            graph.wait(lambda: latest() == CANCELED, 'canceled')
    goal.publish(goal_message(NO_GOAL, Time(sec=3)))
    heard = heard_late(graph, channels.REORIENTATION_RESULT, 2)
    told = [(h['goal_id'], h['outcome'], int(h['request_stamp']) // 10**9) for h in heard]
    assert told == [
        (goal_name(bytes([7] * 16)), 'canceled', 1),
        (goal_name(NO_GOAL), 'rejected', 3),
    ]


@pytest.mark.parametrize('in_hand, felt', [('', 'felt on edge 0'), ('regular_hexagon', 'no edge')])
def test_the_command_says_what_lies_in_the_hand(in_hand, felt, domain):
    """Another object than the scenario's is said to be so."""
    other = ['--in-hand', in_hand] if in_hand else []
    done = subprocess.run(
        [sys.executable, '-m', 'wholearm_ros', 'feel', '--pacing', 'lockstep']
        + ['--rate', '250', '--backend', 'planar', *other],
        capture_output=True,
        text=True,
        timeout=200,
    )
    assert done.returncode == (1 if in_hand else 0) and felt in done.stdout, (
        done.stdout + done.stderr
    )


def test_a_start_that_nobody_told_is_felt_and_turned_onto_an_edge_by_any_way(graph):
    asked = scenario_to_dict(load_scenario('asymmetric_hexagon'))
    asked |= {'start': {'edge': 0, 'x': 0.01, 'felt': True}, 'goal': {'edge': 5}}
    told = {'scenario': json.dumps(asked)}
    supervised(
        graph,
        **{node: {**QUICK.get(node, {}), **told} for node in ('hand_hardware', 'reorientation')},
    )
    graph.client.reorient()
    result = reached(graph)
    assert result['outcome'] == 'succeeded', result
    assert (result['claimed'], result['felt_edge']) == ('at_goal', '5')
    tries = json.loads(result['tries'])
    assert [one['planned'] for one in tries] == [False, True]
    assert tries[0]['felt_edge'] == '0' and float(tries[0]['felt_x']) == pytest.approx(
        0.01, abs=2e-3
    )
    assert graph.client.latest.plan.scenario.goal.direction == 'ccw'


def test_what_did_not_arrive_is_felt_planned_again_and_told_in_a_row(graph, tmp_path):
    """Another outline lies in the hand than everybody believes, some millimetres off at its vertices."""
    believed = load_scenario('asymmetric_hexagon')
    truth = draw_perturbation(np.random.default_rng(12), 6.0, believed).applied(believed)
    graph.start(('bag_recorder',), bag_recorder={'path': str(tmp_path / 'bag')})
    supervised(
        graph,
        hand_hardware={**QUICK['hand_hardware'], 'scenario': json.dumps(scenario_to_dict(truth))},
    )
    graph.client.reorient()
    result = reached(graph)
    tries = json.loads(result['tries'])
    assert int(result['attempts']) == sum(one['planned'] for one in tries) >= 2, tries
    assert tries[0]['claimed'] == 'elsewhere' and tries[0]['felt_edge'] != '5'
    graph.client.watch = lambda: None
    graph.processes.stop()
    recorded = read_runs(tmp_path / 'bag')
    assert len(recorded.runs) == int(result['attempts'])
    assert [m['claimed'] for m in recorded.motions] == [one['claimed'] for one in tries]
    starts = [plan.scenario.start.edge for plan, _, _ in recorded.runs]
    assert starts[:2] == [believed.start.edge, int(tries[0]['felt_edge'])]
    written = write_report([tmp_path / 'bag'], tmp_path / 'report.html').read_text()
    assert written.count('data-page="') == len(tries)
