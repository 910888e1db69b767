"""`wholearm console`: a page in the browser that shows the hand live and commands it."""

from pathlib import Path
from typing import Annotated

import typer

from wholearm_ros.cli.options import (
    TIME_BUDGET,
    BackendOption,
    BudgetOption,
    PacingOption,
    RateOption,
    SeedOption,
    scenario_argument,
)
from wholearm_ros.cli.output import out, print_plain
from wholearm_ros.console.access import LOOPBACK, make_access
from wholearm_ros.console.console import ConsoleOptions, serve
from wholearm_ros.launcher.launcher import RunOptions
from wholearm_ros.model.backends import DEFAULT_BACKEND
from wholearm_ros.model.choices import Backend, Pacing
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.package_share import scenario_path
from wholearm_ros.ros.interface.transport import choose_transport

EPILOG = 'Exit codes: 0 ended by Ctrl-C, 2 bad input.'
PORT = 8470


def console(
    scenario: Annotated[
        str,
        scenario_argument('Whose object is in the hand: a file, or the name of a shipped one.'),
    ] = '',
    join: Annotated[
        bool, typer.Option('--join', help='Start no nodes: take the graph that runs already.')
    ] = False,
    port: Annotated[
        int, typer.Option('--port', min=0, max=65535, help='Of the page; 0: any free one.')
    ] = PORT,
    address: Annotated[
        str,
        typer.Option('--address', help='To listen on; another than the loopback needs --token.'),
    ] = LOOPBACK,
    token: Annotated[
        bool, typer.Option('--token', help='Print a token without which the page does not open.')
    ] = False,
    browser: Annotated[bool, typer.Option('--open/--no-open', help='Open the page.')] = True,
    runs: Annotated[
        Path, typer.Option('--runs', metavar='DIR', help='Where bags are recorded and listed.')
    ] = Path('runs'),
    scenarios: Annotated[
        Path, typer.Option('--scenarios', metavar='DIR', help='Where drawn scenarios are saved.')
    ] = Path('scenarios'),
    pacing: PacingOption = Pacing.realtime,
    rate: RateOption = 1000.0,
    backend: BackendOption = Backend(DEFAULT_BACKEND),
    seed: SeedOption = 0,
    time_budget: BudgetOption = TIME_BUDGET,
) -> None:
    """Open a page that shows the hand live and commands it: point at a face, press Turn.

    Example: wholearm console regular_hexagon --no-open
    """
    choose_transport()
    path = scenario_path(scenario).absolute()
    told, access = load_scenario(path), make_access(address, token)
    run = RunOptions(
        str(path),
        pacing=pacing.value,
        rate=rate,
        hardware=backend.value,
        seed=seed,
        time_budget=time_budget,
    )
    options = ConsoleOptions(run, join, port, browser, runs, scenarios)
    serve(options, told, access, lambda page: print_plain(f'console: {page}  (Ctrl-C ends it)'))
    out.print('ended' if join else 'ended: every node has been stopped')
