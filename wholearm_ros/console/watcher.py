"""What pages are told of a running graph: its scene, frames, and the rest when it has changed."""

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from wholearm_ros.console.commands import Commands
from wholearm_ros.console.faces import faces, map_line
from wholearm_ros.console.frame import frame
from wholearm_ros.console.run_state import LoopMeasure, run_state
from wholearm_ros.console.signals import Signals
from wholearm_ros.launcher.client import SUPERVISOR_PARAMETERS, Client
from wholearm_ros.mechanics.contacts import start_configuration
from wholearm_ros.model.modes import PLANNED_MODES
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.scenario_file import scenario_to_dict
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.report.figures.outlines import touching
from wholearm_ros.report.figures.palette import MODE_COLOURS, MODE_NAMES
from wholearm_ros.report.html.scene import numbers, scene
from wholearm_ros.ros.interface import channels

# [rad] to which both fingers may open or close and be seen whole
SEEN = ((0.75 * np.pi, 0.25 * np.pi), (0.5 * np.pi, 0.5 * np.pi))
Publish = Callable[[dict[str, Any]], None]


class Watcher:
    """Of one graph, in the thread of its client."""

    def __init__(
        self, client: Client, scenario: Scenario, commands: Commands, publish: Publish
    ) -> None:
        self._client, self._scenario, self._commands = client, scenario, commands
        self._publish, self._signals, self._loop = publish, Signals(client), LoopMeasure()
        self._maps, self._loading = MapStore(scenario), ThreadPoolExecutor(1, 'console_map')
        self._found = self._loading.submit(self._maps.load)
        self._told: dict[str, Any] = {}  # the last message of each type
        self._result: Any = client.latest.result
        self._reached: Any = client.latest.reached
        self._first_stamp: int | None = None
        self._shown_stamp = -1
        client.leave_truth_alone()

    def close(self) -> None:
        """Before the client is closed."""
        self._loading.shutdown(wait=False)
        self._signals.close()

    def missing(self) -> list[str]:
        """What the graph still lacks for commands, in words."""
        client, needed = self._client, []
        for name, there in (
            ('joint states of the hand', self._signals.joints_at is not None),
            ('mode switcher', client.offered(channels.STOP)),
            ('reset of the hand', client.offered(channels.RESET)),
            ('planner (the first time it compiles)', client.offered(channels.PLAN_SCENARIO)),
            ('supervisor', client.offered(SUPERVISOR_PARAMETERS)),
            ('trajectory generator', client.latest.goal_listeners > 0),
            ('goals of the supervisor', self._hears_goals()),
        ):
            needed += [] if there else [name]
        client.offered(channels.HARDWARE_STOP)  # found before it is needed
        return needed

    def _hears_goals(self) -> bool:
        return bool(self._client.node.count_subscribers(channels.REORIENTATION_GOAL.name))

    def show_scene(self) -> None:
        """The hand and the object, for as long as this graph runs."""
        where = start_configuration(self._scenario)
        touching(self._scenario, where)  # compiled before anybody waits for a stop
        left, right = self._scenario.hand.left, self._scenario.hand.right
        self._publish(
            {
                'type': 'scene',
                'scene': scene(self._scenario, where[None, :3], np.array([where[3:], *SEEN])),
                'pose': numbers(where[:3] * [1e3, 1e3, 180.0 / np.pi], 2),
                'angles': numbers(np.degrees(where[3:]), 2),
                'scenario': scenario_to_dict(self._scenario),
                'faces': list(self._scenario.object.polygon.resting_edges),
                'torque': max(left.torque_limit, right.torque_limit),
                'colours': MODE_COLOURS,
                'names': MODE_NAMES,
            }
        )

    def show_frame(self) -> None:
        """The newest joints, unless they were shown already."""
        now, signals = self._signals.joints(), self._signals
        if now is None or now[0] == self._shown_stamp:
            return
        stamp, joints = now
        if self._first_stamp is None:
            self._first_stamp = stamp
        if stamp < self._shown_stamp:  # the hand has begun anew, and so has its clock
            self._first_stamp = stamp
        self._shown_stamp, self._commands.angles = stamp, joints.angles
        told = self._client.latest, stamp, joints, signals.estimate(), signals.truth()
        self._publish(frame(self._scenario, *told))

    def look(self) -> None:
        """At what has changed; results say where the object lies."""
        latest, commands = self._client.latest, self._commands
        hand = self._signals.health.get('hand_hardware')
        commands.drives = hand['values'].get('state', '') if hand else ''
        if latest.mode in PLANNED_MODES:
            commands.place = None
        if latest.result is not self._result:
            self._result = latest.result
            self._take(latest.result)
        if latest.reached is not self._reached:
            self._reached = latest.reached
            self._take(latest.reached)
        self._tell(run_state(latest, commands.place))
        lines = list(self._signals.log)
        if lines:
            self._signals.log.clear()
            self._publish({'type': 'log', 'lines': lines})

    def look_at_map(self) -> None:
        """The map on disk may have grown, and the object may lie elsewhere; a large one is read in
        a thread of its own.
        """
        if not self._found.done():
            return
        found = self._found.result()
        self._found = self._loading.submit(self._maps.load)
        rows = faces(self._scenario, found, self._commands.place)
        self._tell({'type': 'faces', 'faces': rows, 'map': map_line(found)})

    def show_loop(self, recording: bool) -> None:
        """How the loop does; sent in any case, so that pages know that somebody is there."""
        self._publish(self._loop.told(self._signals, time.monotonic(), recording))

    def _take(self, values: dict[str, str]) -> None:
        """A result that is not older than this graph is to us."""
        stamp = values.get('stamp', '')
        first = self._first_stamp
        if values and first is not None and stamp.isdecimal() and int(stamp) >= first:
            self._commands.felt(values)
            self.look_at_map()

    def _tell(self, message: dict[str, Any]) -> None:
        """Unless it is what was told last."""
        if self._told.get(message['type']) != message:
            self._told[message['type']] = message
            self._publish(message)
