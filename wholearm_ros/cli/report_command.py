"""`wholearm report`: what happened, as one HTML file."""

from pathlib import Path
from typing import Annotated

import typer

from wholearm_ros.cli.options import output_file
from wholearm_ros.cli.output import print_plain
from wholearm_ros.report.html.write import default_target, write_report

EPILOG = 'Exit codes: 0 the report was written, 2 bad input.'


def report(
    sources: Annotated[
        list[Path],
        typer.Argument(
            metavar='SOURCE...',
            help='A bag, the directory of a run, a document of `simulate --run` or `plan --json`, '
            'or results of `suite --json`, several for several levels of perturbation.',
        ),
    ],
    target: Annotated[
        Path | None,
        output_file(
            '-o',
            'The HTML file to write.',
            default='report.html in the directory of a run, else SOURCE.html',
        ),
    ] = None,
) -> None:
    """Write what happened as one HTML file that needs no network: animation, torques, contact
    states, errors.

    Example: wholearm report runs/first -o first.html
    """
    written = write_report(sources, target or default_target(sources[0]))
    print_plain(f'{written}  ({written.stat().st_size / 1e6:.1f} MB)')
