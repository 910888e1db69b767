"""What a page is told of a graph: what was felt, and how the nodes do."""

from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy')

from wholearm_ros.console.run_state import LoopMeasure, run_state
from wholearm_ros.launcher.client import LatestMessages
from wholearm_ros.model.scenario import StartOnEdge


def test_what_feeling_found_is_told_without_the_goal_that_it_missed():
    result = {'outcome': 'aborted', 'reason': 'felt on edge 0: rotation is off by -1.1 rad'}
    latest = LatestMessages(result=result)
    told = run_state(latest, StartOnEdge(0, 0.0034))
    assert told['felt'] == 'felt' and told['place'] == {'edge': 0, 'x': 3.4}
    assert run_state(latest, None)['felt'] == result['reason']
    assert run_state(LatestMessages(), None)['felt'] == ''


def nodes(age, recording):
    report = {'level': 1, 'message': '', 'values': {}, 'at': 100.0 - age}
    signals = SimpleNamespace(
        health={'bag_recorder': report, 'mode_switcher': report}, joints_at=None
    )
    told = LoopMeasure().told(signals, 100.0, recording)['nodes']
    return {name: node['level'] for name, node in told.items()}


def test_a_silent_node_is_shown_but_for_a_recorder_that_has_ended():
    assert nodes(age=1.0, recording=False) == dict.fromkeys(
        ('bag_recorder', 'mode_switcher'), 'warning'
    )
    assert nodes(age=4.0, recording=True) == dict.fromkeys(
        ('bag_recorder', 'mode_switcher'), 'silent'
    )
    assert nodes(age=4.0, recording=False) == {'mode_switcher': 'silent'}
