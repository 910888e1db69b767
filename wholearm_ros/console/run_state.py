"""What goes on in the graph, as the page tells it: said anew whenever it has changed."""

import json
from typing import Any

from wholearm_ros.console.recording import RECORDER
from wholearm_ros.console.signals import Signals
from wholearm_ros.launcher.client import LatestMessages
from wholearm_ros.launcher.launcher import attempt_line
from wholearm_ros.model.scenario import StartOnEdge

SILENT, SILENT_AFTER = 'silent', 3.0  # [s]
LEVEL_NAMES = ('ok', 'warning', 'error', 'stale')
# of the hand's report, in the order in which they are shown
LOOP = (
    'command latency p50 ms',
    'command latency p99 ms',
    'command applied p99 ms',
    'late commands',
    'overruns',
    'slipped ms',
    'watchdog trips',
    'refused messages',
)


def run_state(latest: LatestMessages, place: StartOnEdge | None) -> dict[str, Any]:
    """Mode, the supervisor's phase and attempts, the last results, where the object was felt."""
    reached, now = latest.reached, latest.reorientation
    tries = json.loads((reached or now).get('tries') or '[]')
    running = bool(now) and not reached
    return {
        'type': 'state',
        'mode': latest.mode,
        'reason': latest.progress.get('reason', ''),
        'phase': now.get('phase', '') if running else '',
        'attempt': now.get('attempt', '') if running else '',
        'attempts': now.get('max_attempts', '') if running else '',
        'progress': round(float(now.get('progress') or 0.0), 2) if running else 0.0,
        'tries': [
            {'text': attempt_line(k, one), 'claimed': one['claimed']}
            for k, one in enumerate(tries, 1)
        ],
        'reached': latest.reached_message if reached else '',
        'outcome': reached.get('outcome', ''),
        'felt': _felt(latest.result, place),
        'planner': latest.planner.get('message', ''),
        'place': None if place is None else {'edge': place.edge, 'x': round(1e3 * place.x, 1)},
    }


def _felt(result: dict[str, str], place: StartOnEdge | None) -> str:
    """What came of feeling, beside the place, where that is known: its goal plays no part."""
    if not result:
        return ''
    return 'felt' if place is not None else result.get('reason', '')


class LoopMeasure:
    """Rate of the joint states and what the nodes report of themselves."""

    def __init__(self) -> None:
        self._last: tuple[float, int] | None = None  # [s], steps
        self._rate: float | None = None

    def told(self, signals: Signals, now: float, recording: bool) -> dict[str, Any]:
        """now [s]: on the machine's clock; recording: whether our recorder runs; once it has ended,
        its silence is none. age [s]: of the newest joint states.
        """
        health = signals.health
        hand = health.get('hand_hardware') or health.get('ros2_control_bridge')
        if hand and hand['values'].get('steps', '').isdecimal():
            self._count(hand['at'], int(hand['values']['steps']))
        values = hand['values'] if hand else {}
        return {
            'type': 'loop',
            'age': None if signals.joints_at is None else round(now - signals.joints_at, 2),
            'drives': values.get('state', ''),
            'rate': self._rate,
            'figures': {name: values[name] for name in LOOP if name in values},
            'nodes': {
                name: {
                    'level': SILENT if silent else LEVEL_NAMES[min(report['level'], 3)],
                    'message': report['message'],
                }
                for name, report in sorted(signals.health.items())
                if not (silent := now - report['at'] > SILENT_AFTER)
                or recording
                or name != RECORDER
            },
        }

    def _count(self, at: float, steps: int) -> None:
        if self._last is None or steps < self._last[1]:
            self._last = at, steps
        elif at - self._last[0] > 0.9:
            self._rate = round((steps - self._last[1]) / (at - self._last[0]), 1)
            self._last = at, steps
