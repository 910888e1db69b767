"""What each message of a page does: who may, and what the answer is."""

import asyncio
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from wholearm_ros.console import bags, outline
from wholearm_ros.console.bench import Bench
from wholearm_ros.console.control import Control
from wholearm_ros.console.hub import Hub
from wholearm_ros.console.map_job import MapJob
from wholearm_ros.console.messages import (
    NEED_CONTROL,
    Check,
    FromPage,
    Import,
    Load,
    MakeMap,
    Open,
    Record,
    Replay,
    Save,
    Simple,
    Stop,
    Turn,
)
from wholearm_ros.console.messages import Control as Controlling
from wholearm_ros.errors import WholeArmError

# What takes a while, one after the other: figures are not made in two threads at once.
SLOW = ThreadPoolExecutor(1, 'console_files')
Reply = Callable[..., None]  # (success, one line, what else the page is told)


class Desk:
    """In the loop's thread. bench: of the graph; directory: where scenarios are saved."""

    def __init__(self, bench: Bench, hub: Hub, scenarios: outline.Scenarios) -> None:
        self.bench, self.hub, self.scenarios = bench, hub, scenarios
        self.control = Control()
        self.job = MapJob(hub.spread)
        self.tell_control()

    async def handle(self, page: int, message: FromPage, reply: Reply) -> None:
        """Raises WholeArmError where the answer is a refusal."""
        if isinstance(message, NEED_CONTROL):
            refusal = self.control.refusal(page)
            if refusal:
                raise WholeArmError(refusal)
        if isinstance(message, Stop):
            drives = message.drives
            self.bench.command(lambda c: c.stop(reply, drives), reply)
        elif isinstance(message, Controlling):
            self.on_control(page, message.how, reply)
        elif isinstance(message, Turn):
            edge = message.edge
            self.bench.command(lambda c: c.turn(edge, reply), reply)
        elif isinstance(message, Simple):
            self.on_simple(message.type, reply)
        elif isinstance(message, (Record, Load)):
            self.on_bench(message, reply)
        else:
            await self.on_file(message, reply)

    def on_control(self, page: int, how: str, reply: Reply) -> None:
        """Asked for, taken over, or given up."""
        refusal = ''
        if how == 'release':
            self.control = self.control.released(page)
        else:
            self.control, refusal = self.control.asked(page, take=how == 'take')
        self.tell_control()
        reply(not refusal, refusal or ('this page looks on' if how == 'release' else 'in control'))

    def arrived(self) -> None:
        """One page more looks."""
        self.bench.watched = True
        self.tell_control()

    def gone(self, page: int) -> None:
        """A page that has left controls no more."""
        self.hub.leave(page)
        self.bench.watched = bool(self.hub.pages)
        self.control = self.control.released(page)
        self.tell_control()

    def tell_control(self) -> None:
        """Every page is told who has control and how many look."""
        self.hub.spread(
            {'type': 'control', 'holder': self.control.holder, 'pages': len(self.hub.pages)}
        )

    def on_simple(self, command: str, reply: Reply) -> None:
        """Without more to say."""
        bench = self.bench
        if command == 'restart':
            bench.submit(lambda: _said(reply, bench.restart(), 'the graph starts anew'))
        elif command == 'feel':
            bench.command(lambda c: c.feel(reply), reply)
        elif command == 'cancel':
            bench.command(lambda c: c.cancel(reply), reply)
        else:
            bench.command(lambda c: c.reset(reply), reply)

    def on_bench(self, message: Record | Load, reply: Reply) -> None:
        """What the bench does between two messages of the graph."""
        bench = self.bench
        if isinstance(message, Load):
            scenario = outline.read(message.scenario)
            bench.submit(
                lambda: _said(reply, bench.restart(scenario), 'the graph starts with this object')
            )
            return
        on = message.on
        bench.command(lambda _: bench.record(on, reply), reply)

    async def on_file(self, message: Any, reply: Reply) -> None:
        """What reads or writes files; the slow ones in a thread of their own."""
        if isinstance(message, Check):
            reply(True, '', checked=outline.check(message.scenario))
        elif isinstance(message, Open):
            reply(True, '', scenario=self.scenarios.open(message.name))
        elif isinstance(message, Save):
            reply(True, self.scenarios.save(message.name, message.scenario, message.replace))
        elif isinstance(message, Import):
            points = await _aside(lambda: _imported(message.kind, message.text))
            reply(True, f'{len(points)} vertices', vertices=points)
        elif isinstance(message, MakeMap):
            told = message.scenario
            scenario = self.bench.scenario if told is None else outline.read(told)
            reply(True, await (self.job.begin(scenario) if message.on else self.job.end()))
        elif isinstance(message, Replay):
            run = await _aside(lambda: bags.replay(self.bench.recording.runs, message.bag))
            reply(True, '', run=run)
        else:
            found = await _aside(lambda: bags.listed(self.bench.recording.runs))
            reply(True, '', bags=found, scenarios=self.scenarios.names())


def _said(reply: Reply, refusal: str, done: str) -> None:
    reply(not refusal, refusal or done)


def _imported(kind: str, text: str) -> list[list[float]]:
    from wholearm_ros.console.outline_import import imported  # its parsers take a second to load

    return imported(kind, text)


def _aside(work: Callable[[], Any]) -> Awaitable[Any]:
    return asyncio.get_running_loop().run_in_executor(SLOW, work)
