"""What the page asks of the graph: each command is sent at once, its answer comes later."""

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wholearm_ros.control.command_watchdog import WAITING_FOR_RESET
from wholearm_ros.estimation.claim import Claim
from wholearm_ros.launcher.client import Client
from wholearm_ros.mechanics.contacts import start_configuration
from wholearm_ros.model.scenario import GoalOnEdge, Scenario, StartOnEdge
from wholearm_ros.model.scenario_file import scenario_to_dict
from wholearm_ros.ros.interface import channels

STOP_WITHIN = 0.25  # [s] for the mode switcher; then the drives themselves are stopped
ANSWER_WITHIN = 5.0  # [s] for any other service
RESET_FIRST = 'the drives take no command; allowed: Reset first'
SAME_ANGLES = 0.02  # [rad]
Answer = Callable[[bool, str], None]  # success, one line


@dataclass
class _Asked:
    """A service that was called: then(response), or then(None) when `until` [s] has passed."""

    future: Any
    until: float
    then: Callable[[Any], None]


class Commands:
    """Of the thread that owns the client, and never waiting.

    scenario: whose object is in the hand; place: where it lies as far as is known, None when it has
    to be felt first; known_start: whether a reset puts it at its start, as a simulated hand's does;
    drives: their state as the hand reports it; angles: (2,) [rad] of the fingers now, None before
    they are heard.
    """

    def __init__(self, client: Client, scenario: Scenario, known_start: bool) -> None:
        self.client, self.scenario, self.known_start = client, scenario, known_start
        self.place: StartOnEdge | None = None
        self.drives = ''
        self.angles: np.ndarray | None = None
        self._asked: list[_Asked] = []
        self._stops = 0
        self.at_the_start()

    def tick(self) -> None:
        """Answers that have come, or come no more."""
        now, waiting = time.monotonic(), self._asked
        self._asked = []
        for asked in waiting:
            if asked.future.done():
                asked.then(asked.future.result())
            elif now > asked.until:
                asked.then(None)
            else:
                self._asked.append(asked)

    def close(self) -> None:
        """The graph ends: what was asked is not answered any more."""
        asked, self._asked = self._asked, []
        for one in asked:
            one.then(None)

    def stop(self, answer: Answer, drives: bool = False) -> None:
        """mode_switcher/stop, and where that does not answer at once, hand_hardware/stop; nothing
        that was asked for before goes on.
        """
        self._stops, self.place = self._stops + 1, None
        if drives or not self.client.offered(channels.STOP):
            self._stop_drives(answer)
        else:
            self._stop_by_switcher(_once(answer))
        self.client.cancel_reorientation()
        self.client.cancel()

    def reset(self, answer: Answer) -> None:
        """hand_hardware/reset: the drives take commands again."""

        def done(told: Any) -> None:
            if told is not None and told.success:
                self.angles = None  # those before it
                self.at_the_start()
            _answered(channels.RESET, answer)(told)

        self._ask(channels.RESET, ANSWER_WITHIN, done)

    def feel(self, answer: Answer) -> None:
        """Where the object lies; the result comes as the generator's."""
        if self.drives in WAITING_FOR_RESET:
            answer(False, RESET_FIRST)
            return
        self.place, latest = None, self.client.latest
        latest.reorientation, latest.reached = {}, {}  # of an earlier goal
        self.client.feel()
        answer(True, 'feeling what lies in the hand')

    def cancel(self, answer: Answer) -> None:
        """Whatever the supervisor and the generator pursue; the hand holds."""
        self.client.cancel_reorientation()
        self.client.cancel()
        answer(True, 'canceled: the hand comes to a hold')

    def turn(self, edge: int, answer: Answer) -> None:
        """Lay the object on `edge`, from where it is known to lie, else it is felt first."""
        if self.drives in WAITING_FOR_RESET:
            answer(False, RESET_FIRST)
            return
        start = self._known_place() or self._unknown_start()
        asked = replace(self.scenario, start=start, goal=GoalOnEdge(edge))
        stops = self._stops

        def told(response: Any) -> None:
            if response is None:
                answer(False, 'reorientation: no answer; allowed: a supervisor that runs')
            elif not response.results[0].successful:
                answer(False, response.results[0].reason)
            elif self._stops != stops:
                answer(False, 'stopped before the goal was sent')
            else:
                self.place = None
                self.client.reorient()
                answer(True, f'goal: edge {edge}')

        document = json.dumps(scenario_to_dict(asked))
        self._expect(self.client.tell_supervisor(document), ANSWER_WITHIN, told)

    def felt(self, values: dict[str, str]) -> None:
        """A result has told where the object lies, or that nobody knows."""
        self.place = Claim.from_dict(values).place

    def at_the_start(self) -> None:
        """The object is where the scenario says, if anybody can know that."""
        start = self.scenario.start
        known = self.known_start and isinstance(start, StartOnEdge) and not start.felt
        self.place = start if known and isinstance(start, StartOnEdge) else None

    def _known_place(self) -> StartOnEdge | None:
        """The place, but for a start from which the fingers have moved: who knows what they did."""
        if self.place is None or self.place != self.scenario.start or self.angles is None:
            return self.place
        moved = np.abs(self.angles - start_configuration(self.scenario)[3:]).max()
        return self.place if moved < SAME_ANGLES else None

    def _unknown_start(self) -> StartOnEdge:
        start = self.scenario.start
        if isinstance(start, StartOnEdge):
            return replace(start, felt=True)
        return StartOnEdge(self.scenario.object.polygon.resting_edges[0], 0.0, felt=True)

    def _stop_by_switcher(self, answer: Answer) -> None:
        """The drives are stopped, too, where it is late; whoever answers first is believed."""
        future = self.client.ask(channels.STOP)

        def late(told: Any) -> None:
            if told is not None and told.success:
                answer(True, f'{told.message}; the drives were asked to hold, too: {RESET_FIRST}')

        def in_time(told: Any) -> None:
            if told is not None and told.success:
                answer(True, told.message)
            else:
                self._stop_drives(answer)
                self._expect(future, ANSWER_WITHIN, late)

        self._expect(future, STOP_WITHIN, in_time)

    def _stop_drives(self, answer: Answer) -> None:
        if not self.client.offered(channels.HARDWARE_STOP):
            answer(False, 'nobody answers a stop: use the emergency stop of your hand')
            return
        self._ask(channels.HARDWARE_STOP, ANSWER_WITHIN, _answered(channels.HARDWARE_STOP, answer))

    def _ask(self, service: channels.Service, within: float, then: Callable[[Any], None]) -> None:
        self._expect(self.client.ask(service), within, then)

    def _expect(self, future: Any, within: float, then: Callable[[Any], None]) -> None:
        self._asked.append(_Asked(future, time.monotonic() + within, then))


def _answered(service: channels.Service, answer: Answer) -> Callable[[Any], None]:
    """Passes on what a Trigger says; None is no answer in time."""

    def told(response: Any) -> None:
        if response is None:
            answer(False, f'{service.name}: no answer for {ANSWER_WITHIN:.0f} s')
        else:
            answer(bool(response.success), response.message)

    return told


def _once(answer: Answer) -> Answer:
    """Passes on the first answer only."""
    given: list[bool] = []

    def first(success: bool, line: str) -> None:
        if not given:
            given.append(success)
            answer(success, line)

    return first
