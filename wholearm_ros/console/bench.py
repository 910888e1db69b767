"""The thread that owns the graph: starts it or joins it, shows it, passes commands on."""

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from wholearm_ros.console.commands import Answer, Commands
from wholearm_ros.console.recording import Recording
from wholearm_ros.console.watcher import Watcher
from wholearm_ros.errors import WholeArmError
from wholearm_ros.launcher.client import Client
from wholearm_ros.launcher.launcher import RunOptions, node_parameters, running_graph
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.scenario_file import scenario_to_dict

FRAME_PERIOD = 1.0 / 30.0  # [s]
LOOK_PERIOD = 0.1  # [s] between two looks at what has changed
LOOP_PERIOD = 0.5  # [s]; a page that hears nothing for three of them has lost us
MAP_PERIOD = 2.0  # [s] between two looks at the map on disk
SPIN = 0.005  # [s] for which a command may wait at most
STARTING, WAITING, READY, FAILED = 'starting', 'waiting', 'ready', 'failed'
Publish = Callable[[dict[str, Any]], None]


class Bench:
    """options: of the graph that is started; scenario: whose object is in the hand; join: whether a
    graph that runs is taken instead; runs: where bags go; publish: is given what pages shall know;
    watched: whether anybody looks.
    """

    def __init__(
        self, options: RunOptions, scenario: Scenario, join: bool, runs: Path, publish: Publish
    ) -> None:
        self.options, self.scenario, self.join = options, scenario, join
        self.publish, self.recording = publish, Recording(runs)
        self.commands: Commands | None = None
        self.status, self.watched = '', False
        self._text = ''
        self._work: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._again, self._leaving = False, False
        self._thread = threading.Thread(target=self._run, name='bench', daemon=True)

    # -- of any thread

    def start(self) -> None:
        """The graph comes up in the background."""
        self._thread.start()

    def submit(self, work: Callable[[], None]) -> None:
        """Called in the bench's thread, within a few milliseconds."""
        self._work.put(work)

    def command(self, work: Callable[[Commands], None], answer: Answer) -> None:
        """The same of what needs a graph; without one the answer says so."""

        def done() -> None:
            if self.commands is None:
                answer(False, f'the graph is not there: {self.status}')
            else:
                work(self.commands)

        self.submit(done)

    def end(self) -> None:
        """Stops what was started, and returns when it has ended."""
        self._leaving = True
        self._thread.join()

    # -- of its own thread

    def restart(self, scenario: Scenario | None = None) -> str:
        """The graph anew, with the object of another scenario if one is given; '' or why not."""
        if self.join:
            return 'the graph was joined, not started here; allowed: start it anew where it runs'
        self.scenario = scenario or self.scenario
        self._again = True
        return ''

    def record(self, on: bool, answer: Answer) -> None:
        """Begins or ends a bag; the end is waited for in a thread of its own, a stop may come."""
        directory, end = self.recording.directory, None
        try:
            if on:
                directory = self.recording.begin()
            else:
                end = self.recording.released()
        except WholeArmError as error:
            answer(False, str(error))
            return
        self.tell_recording()

        def finish() -> None:
            if end is not None:
                end()
            told = f'{"recording into" if on else "recorded"} {directory}'
            answer(directory is not None, told if directory else 'nothing was being recorded')

        threading.Thread(target=finish, daemon=True).start()

    def tell_recording(self) -> None:
        """Whether a bag is being recorded, and where."""
        directory = self.recording.directory
        self.publish({'type': 'recording', 'bag': '' if directory is None else str(directory)})

    def _run(self) -> None:
        while not self._leaving:
            self._again = False
            try:
                with self._graph() as client:
                    self._serve(client)
            except WholeArmError as error:
                self._say(FAILED, str(error))
            self.commands = None
            while not (self._again or self._leaving):  # it has failed
                self._do_work()
                self.publish({'type': 'loop', 'age': None, 'figures': {}, 'nodes': {}})
                time.sleep(LOOP_PERIOD)

    @contextmanager
    def _graph(self) -> Iterator[Client]:
        self._say(WAITING if self.join else STARTING, '')
        if self.join:
            client = Client(name='wholearm_console')
            try:
                yield client
            finally:
                client.close()
            return
        text = json.dumps(scenario_to_dict(self.scenario))
        with running_graph(node_parameters(replace(self.options, scenario=text))) as client:
            yield client

    def _serve(self, client: Client) -> None:
        commands = Commands(client, self.scenario, known_start=not self.join)
        watcher = Watcher(client, self.scenario, commands, self.publish)
        self.commands = commands
        watcher.show_scene()
        self.tell_recording()
        frames, looks = _Every(FRAME_PERIOD), _Every(LOOK_PERIOD)
        maps, loops = _Every(MAP_PERIOD), _Every(LOOP_PERIOD)
        with self.recording, closing(watcher), closing(commands):
            while not (self._again or self._leaving):
                client.spin(SPIN)
                self._do_work()
                commands.tick()
                if frames.due():
                    watcher.show_frame()
                if looks.due():
                    client.watch()
                    watcher.look()
                if maps.due():
                    watcher.look_at_map()
                if loops.due():
                    self._check(watcher)
                    watcher.show_loop(self.recording.directory is not None)

    def _check(self, watcher: Watcher) -> None:
        missing = watcher.missing()
        waiting = WAITING if self.join else STARTING
        self._say(waiting if missing else READY, ', '.join(missing))
        try:
            self.recording.check()
        except WholeArmError as error:
            self.publish({'type': 'note', 'level': 'error', 'text': str(error)})
            self.tell_recording()

    def _do_work(self) -> None:
        while True:
            try:
                work = self._work.get_nowait()
            except Empty:
                return
            work()

    def _say(self, status: str, text: str) -> None:
        """When it has changed."""
        if (status, text) != (self.status, self._text):
            self.status, self._text = status, text
            self.publish({'type': 'graph', 'status': status, 'text': text, 'join': self.join})


class _Every:
    """Whether a period [s] has passed since it was due last."""

    def __init__(self, period: float) -> None:
        self._period, self._next = period, 0.0

    def due(self) -> bool:
        """At most once a period; what was missed is not made up for."""
        now = time.monotonic()
        if now < self._next:
            return False
        self._next = max(self._next + self._period, now)
        return True
