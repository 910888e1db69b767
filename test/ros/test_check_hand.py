"""`wholearm check-hand` on the graph: the stand-in passes, hands that are wrong fail where they are."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from wholearm_ros.ros.interface import channels

pytestmark = pytest.mark.timeout(280)
WRONG_HAND = Path(__file__).parent / 'wrong_hand.py'
RATE = 250.0


def check(tmp_path, *options):
    """Exit code, and the checks: name → passed."""
    told = tmp_path / 'checks.json'
    command = [sys.executable, '-m', 'wholearm_ros', 'check-hand', '--rate', str(RATE)]
    done = subprocess.run(
        [*command, '--json', told, *options], capture_output=True, text=True, timeout=120
    )
    checks = json.loads(told.read_text())['checks'] if told.exists() else []
    return done, {c['name']: c['passed'] for c in checks}


def mistakes(checks):
    """What failed, but for what a loaded machine does."""
    return {name for name, passed in checks.items() if passed is False} - {'jitter', 'rate'}


def test_the_stand_in_passes(graph, tmp_path):
    graph.start(
        ['hand_hardware'], 'realtime', hand_hardware={'backend': 'planar', 'motor_rate': RATE}
    )
    graph.client.wait_for_publishers(120.0, ((channels.JOINT_STATES, 1),))
    for _ in range(3):  # in real time a loaded machine may make any hand late
        done, checks = check(tmp_path, '--move')
        if not mistakes(checks):
            break
    assert not mistakes(checks) and None not in checks.values(), done.stdout


@pytest.mark.parametrize(
    ('wrong', 'expected'),
    [('degrees', {'angles'}), ('sign', {'sign of left_finger_joint'}), ('watchdog', {'watchdog'})],
)
def test_a_wrong_hand_fails(wrong, expected, domain, tmp_path):
    hand = subprocess.Popen([sys.executable, WRONG_HAND, wrong])
    try:
        done, checks = check(tmp_path, '--move')
    finally:
        hand.kill()
        hand.wait()
    assert done.returncode == 1 and mistakes(checks) >= expected, done.stdout + done.stderr
    if wrong == 'degrees':
        assert checks['watchdog'] is None  # nothing was moved


def test_no_hand_is_exit_code_2(domain, tmp_path):
    done, _ = check(tmp_path)
    assert done.returncode == 2 and 'no hand heard' in done.stderr
