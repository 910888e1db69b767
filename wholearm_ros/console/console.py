"""`wholearm console`: bench, hub and server together, until a signal."""

import asyncio
import os
import signal
import sys
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from aiohttp import web

from wholearm_ros.console.access import Access
from wholearm_ros.console.bench import Bench
from wholearm_ros.console.desk import Desk
from wholearm_ros.console.hub import Hub
from wholearm_ros.console.outline import Scenarios
from wholearm_ros.console.server import Server
from wholearm_ros.errors import WholeArmError
from wholearm_ros.launcher.launcher import RunOptions
from wholearm_ros.model.scenario import Scenario

# [s] for which a thread that draws a report may keep a stop waiting
SWITCH_INTERVAL = 0.001


@dataclass(frozen=True)
class ConsoleOptions:
    """run: of the graph; join: take one that runs; port: 0 for any; browser: whether one is opened;
    runs, scenarios: where bags and scenarios are kept.
    """

    run: RunOptions
    join: bool
    port: int
    browser: bool
    runs: Path
    scenarios: Path


def serve(
    options: ConsoleOptions, scenario: Scenario, access: Access, tell: Callable[[str], None]
) -> None:
    """Until SIGINT or SIGTERM; then what was started has ended. Raises WholeArmError when the port
    is taken. `tell` is given the page's address.
    """
    sys.setswitchinterval(SWITCH_INTERVAL)
    asyncio.run(_serve(options, scenario, access, tell))


async def _serve(
    options: ConsoleOptions, scenario: Scenario, access: Access, tell: Callable[[str], None]
) -> None:
    loop, ended = asyncio.get_running_loop(), asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, ended.set)
    hub = Hub(loop)
    bench = Bench(options.run, scenario, options.join, options.runs, hub.publish)
    desk = Desk(bench, hub, Scenarios(options.scenarios))
    runner = web.AppRunner(
        Server(access, desk).application(), access_log=None, shutdown_timeout=1.0
    )
    await runner.setup()
    site = web.TCPSite(runner, access.address, options.port)
    try:
        await site.start()
    except OSError as error:
        await runner.cleanup()
        raise WholeArmError(
            f'--port {options.port}: {error.strerror or error}; allowed: a free one, or 0 for any'
        ) from error
    bench.start()
    address = _address(access, runner.addresses[0][1])
    tell(address)
    if options.browser and _has_screen():
        loop.run_in_executor(None, webbrowser.open, address)
    try:
        await ended.wait()
    finally:
        await desk.job.end()
        await runner.cleanup()
        await loop.run_in_executor(None, bench.end)


def _address(access: Access, port: int) -> str:
    """With the token behind the '#', which a browser sends to nobody."""
    name = f'[{access.address}]' if ':' in access.address else access.address
    return f'http://{name}:{port}/' + (f'#{access.token}' if access.token else '')


def _has_screen() -> bool:
    return any(os.environ.get(name) for name in ('DISPLAY', 'WAYLAND_DISPLAY'))
