"""The main job on the real graph: plan, execute in lockstep, record; the same every time."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from wholearm_ros.bag.reader import Bag, stamp_of
from wholearm_ros.bag.types import jazzy_typestore
from wholearm_ros.model.scenario import CCW, GoalOnEdge, StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario, scenario_to_dict
from wholearm_ros.planner.map_making import MapOptions, make_way
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.report.bag_run import read_runs
from wholearm_ros.ros.interface import channels

pytestmark = pytest.mark.timeout(280)


RUN = """
import json, sys
from pathlib import Path
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.launcher.launcher import RunOptions, run_graph
path, more = sys.argv[1], json.loads(sys.argv[2])
more['record'] = more.get('record') and Path(more['record'])
report = run_graph(load_scenario(path), RunOptions(path, 'lockstep', **more), lambda *_: None)
print(json.dumps([report.success, report.message, report.judged.pose.tolist(), report.judged.angle_error]))
"""


def lockstep(config, name, **more):
    """(success, message, pose (3,), angle error) of a run by a launcher of its own, as every user's."""
    told = json.dumps(
        {key: str(value) if key == 'record' else value for key, value in more.items()}
    )
    done = subprocess.run(
        [sys.executable, '-c', RUN, str(config / f'{name}.yaml'), told],
        capture_output=True,
        text=True,
        timeout=130,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_the_asymmetric_hexagon_reaches_its_goal_and_the_bag_has_it_all(config, tmp_path, domain):
    success, message, pose, angle_error = lockstep(
        config, 'asymmetric_hexagon', rate=500.0, record=tmp_path / 'bag'
    )
    assert success, message
    assert abs(angle_error) <= 0.03
    with AnyReader([tmp_path / 'bag']) as reader:
        counts = {c.topic: c.msgcount for c in reader.connections}
        hashes = {c.msgtype: c.digest for c in reader.connections}
    cancels = {'trajectory_generator/cancel', 'reorientation/cancel'}
    silent = {*cancels, channels.FACE_MAP.name}  # a map is told with goals without a direction
    for topic in channels.RECORDED:
        name = topic.name if topic.name.startswith('/') else f'/wholearm/{topic.name}'
        assert name in counts
        assert counts[name] > 0 or topic.name in silent, name
    store = jazzy_typestore()
    assert all(digest == store.hash_rihs01(name) for name, digest in hashes.items())
    with Bag(tmp_path / 'bag') as bag:
        states = sorted({stamp_of(m) for m in bag.messages('joint_states')})
        setpoints = sorted({stamp_of(m) for m in bag.messages('velocity_setpoint')})
        commands = [stamp_of(m) for m in bag.messages('joint_commands')]
    assert set(np.diff(states)) == {2_000_000}, 'a joint state is missing in the bag'
    assert set(np.diff(setpoints)) == {2_000_000}
    assert set(setpoints) <= set(commands) and len(commands) >= 2 * len(setpoints)

    again = lockstep(config, 'asymmetric_hexagon', rate=500.0)[2]
    np.testing.assert_allclose(again, pose, rtol=0, atol=1e-9)


def test_the_regular_hexagon_at_1000_hz_on_the_planar_stand_in(config, domain):
    success, message, _, _ = lockstep(
        config, 'regular_hexagon', hardware='planar', seed=3, probe=False
    )
    assert success, message


def test_the_command_runs_in_real_time_with_every_option(tmp_path, domain):
    """Whether the object arrives in real time depends on the load of the machine; that it runs and tells does not."""
    done = subprocess.run(
        [
            sys.executable,
            '-m',
            'wholearm_ros',
            'run',
            'regular_hexagon',
            '--pacing',
            'realtime',
            '--rate',
            '200',
            '--backend',
            'planar',
            '--seed',
            '2',
            '--search',
            'best',
            '--transition',
            'dwell',
            '--record',
            str(tmp_path / 'bag'),
            '--storage',
            'sqlite3',
        ],
        capture_output=True,
        text=True,
        timeout=250,
    )
    assert done.returncode in (0, 1) and 'failed: ' not in done.stdout, done.stdout + done.stderr
    with AnyReader([tmp_path / 'bag']) as reader:
        assert reader.message_count > 100


def test_the_command_refuses_bad_input_and_leaves_nothing(tmp_path, domain):
    bad = tmp_path / 'bad.yaml'
    bad.write_text('object: {}')
    done = subprocess.run(
        [sys.executable, '-m', 'wholearm_ros', 'run', str(bad)],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 2 and 'bad.yaml' in done.stderr


def commanded(*arguments):
    """`wholearm run` with these arguments, in lockstep at 250 Hz on the planar hand."""
    fixed = ['--pacing', 'lockstep', '--rate', '250', '--backend', 'planar']
    return subprocess.run(
        [sys.executable, '-m', 'wholearm_ros', 'run', *map(str, arguments), *fixed],
        capture_output=True,
        text=True,
        timeout=250,
    )


def test_a_run_with_errors_of_the_hand_is_judged_by_the_true_object(tmp_path, domain):
    """Whether it arrives is not told here, but that what is said of the end is true of it."""
    done = commanded('--perturb', 2, '--seed', 3, '--record', tmp_path / 'bag')
    assert done.returncode in (0, 1), done.stdout + done.stderr
    run = read_runs(tmp_path / 'bag').runs[-1][2]
    assert (done.returncode == 0) == run.judged.executed
    assert abs(run.judged.gap) < 1e-4, 'judged with another outline than the true one'


def test_the_command_lays_the_object_on_one_face_after_the_other(tmp_path, domain):
    done = commanded('asymmetric_hexagon', '--sequence', '5,1', '--record', tmp_path / 'bag')
    assert done.returncode == 0, done.stdout + done.stderr
    assert '2 of 2 faces reached' in done.stdout
    assert 'edge 5 after 1 attempt: succeeded' in done.stdout
    assert 'edge 1 after 1 attempt: succeeded' in done.stdout
    starts = [plan.scenario.start for plan, _, _ in read_runs(tmp_path / 'bag').runs]
    assert [start.edge for start in starts] == [0, 5]


def test_a_slide_to_where_a_known_turn_begins_is_not_felt_and_the_turn_is(
    tmp_path, domain, monkeypatch
):
    monkeypatch.setenv('WHOLEARM_MAPS', str(tmp_path / 'maps'))
    believed = load_scenario('asymmetric_hexagon')
    turn = replace(believed, start=StartOnEdge(0, 0.0), goal=GoalOnEdge(5, CCW))
    known = make_way(turn, MapOptions(PlanRequest(moves=0)))
    MapStore(believed).save(turn, known)
    away = tmp_path / 'away.json'
    away.write_text(json.dumps(scenario_to_dict(replace(believed, start=StartOnEdge(0, 0.025)))))
    done = commanded(away, '--goal-edge', 5)
    assert done.returncode == 0, done.stdout + done.stderr
    assert '1. attempt (to edge 0, on the way): unverified: led along the palm' in done.stdout
    assert '2. attempt: at_goal: felt on edge 5' in done.stdout


@pytest.mark.parametrize(
    'more, said',
    [
        (['--sequence', '5;1'], 'numbers of edges'),
        (['--sequence', '5,9'], 'edge'),
        (['--sequence', '5', '--goal-edge', '1'], 'one of the two'),
    ],
)
def test_a_bad_sequence_is_refused_before_anything_starts(more, said):
    done = subprocess.run(
        [sys.executable, '-m', 'wholearm_ros', 'run', 'asymmetric_hexagon', *more],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 2 and said in done.stderr
