"""One page's connection: what it sends is read and answered, what happens is sent to it."""

import asyncio
from typing import Any

from aiohttp import WSCloseCode, WSMsgType, web

from wholearm_ros.console.desk import Desk
from wholearm_ros.console.hub import Outbox, encoded
from wholearm_ros.console.messages import MOST_BYTES, id_of, read_message
from wholearm_ros.errors import WholeArmError

SEND_WITHIN = 5.0  # [s] for a page to take a message; one that reads nothing is cut off
LEAVE_WITHIN = 0.5  # [s] for a page to say goodbye when the console ends
HEARTBEAT = 5.0  # [s] between two pings
BURST, A_SECOND = 50, 100.0  # messages of one page; what is more waits


class PageSocket:
    """number: of the page, which it is told."""

    def __init__(self, number: int, desk: Desk) -> None:
        self.number, self.desk = number, desk
        self._outbox: Outbox | None = None
        self._socket: web.WebSocketResponse | None = None

    async def close(self) -> None:
        """The console ends."""
        if self._socket is not None:
            await self._socket.close(code=WSCloseCode.GOING_AWAY)

    async def serve(self, request: web.Request) -> web.WebSocketResponse:
        """Until the page goes."""
        socket = self._socket = web.WebSocketResponse(
            heartbeat=HEARTBEAT, max_msg_size=MOST_BYTES, timeout=LEAVE_WITHIN
        )
        await socket.prepare(request)
        files = self.desk.scenarios.names()
        hello = {'type': 'hello', 'page': self.number, 'scenarios': files}
        outbox = self._outbox = self.desk.hub.enter(self.number, hello)
        self.desk.arrived()
        writing = asyncio.create_task(_write(socket, outbox, request))
        try:
            await self._read(socket)
        finally:
            self.desk.gone(self.number)
            writing.cancel()
            await asyncio.gather(writing, return_exceptions=True)
        return socket

    async def _read(self, socket: web.WebSocketResponse) -> None:
        """Every message is answered; a flood of them waits, and only this page with it."""
        loop = asyncio.get_running_loop()
        credit, since = float(BURST), loop.time()
        async for message in socket:
            now = loop.time()
            credit, since = min(BURST, credit + A_SECOND * (now - since)) - 1.0, now
            if credit < 0.0:
                await asyncio.sleep(-credit / A_SECOND)
            if message.type is WSMsgType.TEXT:
                await self._answer(message.data)
            elif message.type is WSMsgType.BINARY:
                self._say(None, False, 'message: got bytes; allowed: a JSON text')
            else:
                return  # damaged, or too large: the connection is closed already

    async def _answer(self, text: str) -> None:
        number: int | None = None
        try:
            message = read_message(text)
            number = message.id

            def reply(success: bool, line: str = '', **more: Any) -> None:
                loop.call_soon_threadsafe(self._say, number, success, line, more)

            loop = asyncio.get_running_loop()
            await self.desk.handle(self.number, message, reply)
        except WholeArmError as error:
            self._say(number if number is not None else id_of(text), False, str(error))

    def _say(
        self, number: int | None, success: bool, line: str, more: dict[str, Any] | None = None
    ) -> None:
        answer = {'type': 'answer', 'id': number, 'ok': success, 'message': line}
        if self._outbox is not None:
            self._outbox.put(encoded({**answer, **(more or {})}))


async def _write(socket: web.WebSocketResponse, outbox: Outbox, request: web.Request) -> None:
    """A page that takes nothing for SEND_WITHIN, or falls behind by too much, is cut off."""
    try:
        while not outbox.overflown:
            await asyncio.wait_for(socket.send_str(await outbox.next()), SEND_WITHIN)
    except ConnectionError:
        return  # it has gone
    except asyncio.TimeoutError:
        pass
    if request.transport is not None:
        request.transport.abort()
