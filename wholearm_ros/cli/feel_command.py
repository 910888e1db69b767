"""`wholearm feel`: what lies in the hand, before anything is planned."""

from typing import Annotated

import typer
from rich.markup import escape

from wholearm_ros.cli.options import (
    BackendOption,
    JsonOption,
    PacingOption,
    RateOption,
    scenario_argument,
)
from wholearm_ros.cli.output import err, finish, graph_at_work, out, print_plain, write_json
from wholearm_ros.launcher.feel import feel_graph
from wholearm_ros.launcher.launcher import RunOptions
from wholearm_ros.model.backends import DEFAULT_BACKEND
from wholearm_ros.model.choices import Backend, Pacing
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.package_share import scenario_path
from wholearm_ros.ros.interface.transport import choose_transport

EPILOG = 'Exit codes: 0 the object lies on a known edge, 1 nothing or not known, 2 bad input.'


def feel(
    scenario: Annotated[
        str,
        scenario_argument('Whose object is believed to be there; its start is not used.'),
    ] = '',
    in_hand: Annotated[
        str,
        typer.Option(
            '--in-hand',
            metavar='SCENARIO',
            help='What the simulated hand truly holds, if it is another.',
        ),
    ] = '',
    pacing: PacingOption = Pacing.realtime,
    rate: RateOption = 1000.0,
    backend: BackendOption = Backend(DEFAULT_BACKEND),
    json_out: JsonOption = None,
) -> None:
    """Feel what lies in the hand, before anything is planned: on which edge, where, how surely.

    Example: wholearm feel asymmetric_hexagon --pacing lockstep
    """
    choose_transport()
    path = scenario_path(scenario).absolute()
    held = scenario_path(in_hand).absolute() if in_hand else path
    for name in (path, held):
        load_scenario(name)
    options = RunOptions(str(path), pacing=pacing.value, rate=rate, hardware=backend.value)
    with graph_at_work():
        told = feel_graph(options, str(held), lambda line: err.print(escape(line)))
    known = bool(told.get('felt_edge'))
    out.print('[bold green]felt[/]' if known else '[bold red]not known[/]')
    reason = told.get('claim_reason') or told.get('reason', '')
    print_plain(reason.partition(': ')[0] if known else reason)  # of a goal nothing was asked
    if known:
        print_plain(
            f'edges {told["felt_edges"]}, x = {float(told["felt_x"]):+.4f} m '
            f'± {1e3 * float(told["felt_x_deviation"]):.1f} mm, '
            f'probability {float(told["felt_probability"]):.4f}'
        )
    if json_out is not None:
        write_json(json_out, dict(told))
    finish(known)
