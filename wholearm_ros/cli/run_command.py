"""`wholearm run`: plan and execute on the ROS 2 graph, each node a process of its own."""

import os
import signal
from enum import Enum
from pathlib import Path
from typing import Optional

import typer
from rich.console import Console
from rich.markup import escape

from wholearm_ros.errors import WholeArmError
from wholearm_ros.launcher.figures import figures_of
from wholearm_ros.launcher.launcher import RunOptions, RunReport, run_graph
from wholearm_ros.launcher.live_view import view_on
from wholearm_ros.model.choices import FAILED, INTERRUPTED, OK, Backend, Search, Transition
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.package_share import scenario_path
from wholearm_ros.ros.interface.transport import choose_transport

out = Console(highlight=False)


class Pacing(str, Enum):
    realtime = 'realtime'
    lockstep = 'lockstep'


class Storage(str, Enum):
    mcap = 'mcap'
    sqlite3 = 'sqlite3'


def run(
    scenario: str = typer.Argument(
        '',
        metavar='[SCENARIO]',
        help='Scenario file, YAML or JSON, or the name of a shipped one.',
        show_default='asymmetric_hexagon',
    ),
    pacing: Pacing = typer.Option(
        Pacing.realtime,
        '--pacing',
        help='realtime: wall clock; lockstep: simulated time '
        'waits for every command, the same result on any machine.',
    ),
    seed: int = typer.Option(0, '--seed', min=0, help='Of everything drawn at random in planning.'),
    record: Optional[Path] = typer.Option(
        None, '--record', metavar='DIR', help='Record a bag; DIR is made.'
    ),
    figures: Optional[Path] = typer.Option(
        None, '--figures', metavar='DIR', help='Draw the run into DIR; needs --record.'
    ),
    storage: Storage = typer.Option(Storage.mcap, '--storage', help='Format of the bag.'),
    view: bool = typer.Option(False, '--view', help="PyBullet's window, where there is a screen."),
    rate: float = typer.Option(1000.0, '--rate', min=50.0, max=2000.0, help='Motor rate [Hz].'),
    backend: Backend = typer.Option(
        Backend.pybullet, '--backend', help='Physics; planar needs no PyBullet.'
    ),
    search: Search = typer.Option(
        Search.best, '--search', help="best: widest margins first; random: the paper's."
    ),
    transition: Transition = typer.Option(
        Transition.auto, '--transition', help='How torque ranges that do not overlap are crossed.'
    ),
    network: bool = typer.Option(
        False,
        '--network',
        help='Let other machines take part, and command the drives; else only this one.',
    ),
):
    """Plan and execute on the ROS 2 graph: every node a process, the hand's stand-in as hardware.

    Example: wholearm run regular_hexagon --pacing lockstep --record runs/first
    """
    path = scenario_path(scenario).absolute()
    if record is not None and record.exists():
        raise WholeArmError(
            f'--record {record}: exists already; allowed: a directory that does not exist yet'
        )
    if figures is not None and record is None:
        raise WholeArmError(
            '--figures: they are drawn from the bag; allowed: together with --record DIR'
        )
    _check_screen(view)
    choose_transport(network=network)
    options = RunOptions(
        str(path),
        pacing=pacing.value,
        seed=seed,
        record=record and record.absolute(),
        storage=storage.value,
        view=view,
        rate=rate,
        backend=backend.value,
        search=search.value,
        transition=transition.value,
    )
    task = load_scenario(path)
    _interrupt_on_sigterm()
    try:
        with view_on(out) as view:
            report = run_graph(task, options, view, attend=view.attend)
    except KeyboardInterrupt:
        out.print('interrupted: every node has been stopped')
        raise typer.Exit(INTERRUPTED) from None
    except WholeArmError as error:
        out.print(f'[bold red]failed:[/] {escape(str(error))}', soft_wrap=True)
        raise typer.Exit(FAILED) from None
    show(report, options)
    if figures is not None and report.judged is not None:
        for path in figures_of(options.record, figures):
            out.print(
                f'{"report" if path.suffix == ".html" else "figure":12}{path}', soft_wrap=True
            )
    raise typer.Exit(OK if report.success else FAILED)


def show(report: RunReport, options: RunOptions):
    """A summary for people."""

    def line(name, text):
        out.print(f'{name:12}{escape(text)}', soft_wrap=True)

    line('scenario', options.scenario)
    line('plan', report.message.removeprefix('plan '))
    times = ', '.join(f'{name} {seconds:.2f} s' for name, seconds in report.timings.items())
    search = ', '.join(
        f'{key.removesuffix("_ms")} {float(report.planner[key]):.0f} ms'
        for key in ('plan_ms', 'generate_ms', 'verify_ms')
        if key in report.planner
    )
    line('timings', f'{times} ({search})' if search else times)
    if report.judged is not None:
        line('path', f'{report.path_length} subgoals')
        line(
            'modes',
            ', '.join(
                f'{mode} {seconds:.2f} s' for mode, seconds in report.modes.items() if seconds
            ),
        )
        judged = report.judged
        x, y, turn = judged.pose
        line('goal', f'{report.result.get("outcome")}: {report.result.get("reason")}')
        line(
            'final pose',
            f'x {x:.6f} m, y {y:.6f} m, rotation {turn:.6f} rad; {judged.angle_error:+.4f} rad from the '
            f'goal, {1e3 * judged.gap:+.3f} mm from the palm',
        )
    if options.record:
        line('bag', str(options.record))
    if report.success:
        out.print('[bold green]success:[/] the object rests on its goal')
    elif report.judged is not None:
        out.print(
            f'[bold red]not at the goal:[/] {escape(report.judged.reason or report.result.get("reason", ""))}',
            soft_wrap=True,
        )


def _check_screen(view: bool):
    if view and not os.environ.get('DISPLAY'):
        raise WholeArmError(
            '--view: there is no screen here (DISPLAY is not set); allowed: run without --view'
        )


def _interrupt_on_sigterm():
    def interrupt(*_):
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, interrupt)
    signal.signal(signal.SIGTERM, interrupt)
