"""`wholearm check-hand`: whether a hand on the graph keeps to the contract."""

from dataclasses import asdict
from typing import Annotated

import typer
from rich.markup import escape

from wholearm_ros.cli.options import JsonOption, scenario_argument
from wholearm_ros.cli.output import err, finish, print_plain, write_json
from wholearm_ros.launcher.hand_check import check_hand as examine
from wholearm_ros.launcher.hand_check import plan_of_motion
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.package_share import scenario_path

EPILOG = 'Exit codes: 0 nothing failed, 1 something failed, 2 bad input, or no hand was heard.'
SAID = {True: 'pass', False: 'FAIL', None: '-'}


def check_hand(
    scenario: Annotated[
        str,
        scenario_argument('With the lengths, masses and limits of the hand.'),
    ] = '',
    move: Annotated[
        bool, typer.Option('--move', help='Move each finger by a little, too: keep clear.')
    ] = False,
    seconds: Annotated[
        float, typer.Option('--seconds', min=0.5, max=600.0, help='Of listening.')
    ] = 3.0,
    rate: Annotated[
        float, typer.Option('--rate', min=1.0, max=5000.0, help='Of the motors, expected [Hz].')
    ] = 1000.0,
    json_out: JsonOption = None,
) -> None:
    """Check a running hand against the contract: rate, stamps, units; with --move, signs, watchdog.

    Example: wholearm check-hand asymmetric_hexagon --rate 250
    """
    told = load_scenario(scenario_path(scenario))
    if move:
        print_plain(plan_of_motion(told))
    checks = examine(told, rate, seconds, move, lambda line: err.print(escape(line)))
    for check in checks:
        print_plain(f'{SAID[check.passed]:4}  {check.name}: {check.measured}')
        if check.passed is False:
            print_plain(f'      {check.advice}')
    if json_out is not None:
        write_json(json_out, {'checks': [asdict(check) for check in checks]})
    finish(all(check.passed is not False for check in checks))
