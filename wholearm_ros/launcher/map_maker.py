"""The map of an object, made in the background: `wholearm map` as a process beside whoever uses
it.
"""

import json
import os
import signal
import subprocess
import sys
from contextlib import suppress

from wholearm_ros.launcher.processes import STOP_WITHIN, die_with_parent
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.scenario_file import scenario_to_dict
from wholearm_ros.planner.map_store import MapStore

POLITE = 19  # niceness: whatever else wants the processors comes first


class MapMaker:
    """One process that makes the map of the object of `scenario` with so many `jobs`, into
    `directory`; it keeps each way as soon as that is done, so it may end at any time.
    """

    def __init__(self, scenario: Scenario, jobs: int) -> None:
        self.directory = MapStore(scenario).directory
        command = [sys.executable, '-m', 'wholearm_ros', 'map', '/dev/stdin', '--jobs', str(jobs)]
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            preexec_fn=_polite_child,
            text=True,
        )
        assert self._process.stdin is not None
        with suppress(BrokenPipeError), self._process.stdin as told:  # it may have ended already
            json.dump(scenario_to_dict(scenario), told)

    @property
    def making(self) -> bool:
        """Whether it is still at work."""
        return self._process.poll() is None

    def stop(self) -> None:
        """End it, and its workers with it."""
        if self.making:
            os.killpg(self._process.pid, signal.SIGINT)
            try:
                self._process.wait(STOP_WITHIN / 6)
            except subprocess.TimeoutExpired:
                os.killpg(self._process.pid, signal.SIGKILL)
                self._process.wait()


def _polite_child() -> None:
    os.nice(POLITE)
    die_with_parent()
