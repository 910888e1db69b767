"""From the bench to the pages: what each has still to be sent, frames only the newest."""

import asyncio
import json
from collections import deque
from typing import Any

MOST_WAITING = 1000  # messages for one page; one that takes no more is cut off
LOG_LINES = 200  # that a new page is shown
KEPT = ('graph', 'scene', 'state', 'faces', 'control', 'recording', 'job')  # for new pages


class Outbox:
    """Of one page. Everything in order, but of frames only the newest, which is sent last."""

    def __init__(self) -> None:
        self._messages: deque[str] = deque()
        self._frame: str | None = None
        self._filled = asyncio.Event()
        self.overflown = False

    def put(self, text: str) -> None:
        """One message more."""
        self.overflown = self.overflown or len(self._messages) >= MOST_WAITING
        if not self.overflown:
            self._messages.append(text)
        self._filled.set()

    def show(self, frame: str) -> None:
        """The newest frame; one that was not sent yet is forgotten."""
        self._frame = frame
        self._filled.set()

    async def next(self) -> str:
        """What is to be sent next, as soon as there is something."""
        while not self._messages and self._frame is None:
            self._filled.clear()
            await self._filled.wait()
        if self._messages:
            return self._messages.popleft()
        frame, self._frame = self._frame, None
        assert frame is not None
        return frame


class Hub:
    """All pages, by their numbers, and what a new one has to know."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._kept: dict[str, str] = {}
        self._log: deque[dict[str, Any]] = deque(maxlen=LOG_LINES)
        self.pages: dict[int, Outbox] = {}

    def publish(self, message: dict[str, Any]) -> None:
        """To every page, from any thread."""
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self.spread, message)

    def spread(self, message: dict[str, Any]) -> None:
        """The same, from the loop's own thread."""
        kind, text = message['type'], encoded(message)
        if kind in KEPT:
            self._kept[kind] = text
        if kind == 'log':
            self._log.extend(message['lines'])
        for outbox in self.pages.values():
            (outbox.show if kind == 'frame' else outbox.put)(text)

    def enter(self, page: int, hello: dict[str, Any]) -> Outbox:
        """A new page, which is told what there is."""
        outbox = self.pages[page] = Outbox()
        outbox.put(encoded(hello))
        for kind in KEPT:
            if kind in self._kept:
                outbox.put(self._kept[kind])
        outbox.put(encoded({'type': 'log', 'lines': list(self._log)}))
        return outbox

    def leave(self, page: int) -> None:
        """A page that has gone."""
        self.pages.pop(page, None)


def encoded(message: dict[str, Any]) -> str:
    """As it goes over the wire."""
    return json.dumps(message, separators=(',', ':'), allow_nan=False)
