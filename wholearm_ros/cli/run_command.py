"""`wholearm run`: plan and execute on the ROS 2 graph, each node a process of its own."""

import json
import os
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from wholearm_ros.cli.options import (
    TIME_BUDGET,
    BackendOption,
    BudgetOption,
    GoalEdgeOption,
    HandErrorsOption,
    PacingOption,
    PerturbOption,
    RateOption,
    SearchOption,
    SeedOption,
    TransitionOption,
    ViewOption,
    scenario_argument,
)
from wholearm_ros.cli.output import finish, graph_at_work, out
from wholearm_ros.cli.planning import advice_for, load_asked
from wholearm_ros.errors import WholeArmError
from wholearm_ros.launcher.figures import figures_of, figures_without_a_plan
from wholearm_ros.launcher.launcher import RunOptions, RunReport, attempt_line, run_graph
from wholearm_ros.launcher.live_view import view_on
from wholearm_ros.model.backends import DEFAULT_BACKEND
from wholearm_ros.model.choices import Backend, Hardware, Pacing, Search, Storage, Transition
from wholearm_ros.model.outcomes import AT_GOAL
from wholearm_ros.model.scenario import GoalOnEdge, Scenario
from wholearm_ros.model.scenario_file import scenario_to_dict
from wholearm_ros.package_share import scenario_path
from wholearm_ros.planner.supervision import MAX_ATTEMPTS
from wholearm_ros.ros.interface.transport import choose_transport


def run(
    scenario: Annotated[
        str,
        scenario_argument('Scenario file, YAML or JSON, or the name of a shipped one.'),
    ] = '',
    goal_edge: GoalEdgeOption = None,
    sequence: Annotated[
        str,
        typer.Option(
            '--sequence',
            metavar='K,K,...',
            help='Faces on which the object is laid one after the other, without a reset, instead '
            'of the goal.',
        ),
    ] = '',
    pacing: PacingOption = Pacing.realtime,
    seed: SeedOption = 0,
    record: Annotated[
        Path | None, typer.Option('--record', metavar='DIR', help='Record a bag; DIR is made.')
    ] = None,
    figures: Annotated[
        Path | None,
        typer.Option('--figures', metavar='DIR', help='Draw the run into DIR; needs --record.'),
    ] = None,
    storage: Annotated[
        Storage, typer.Option('--storage', help='Format of the bag.')
    ] = Storage.mcap,
    view: ViewOption = False,
    rate: RateOption = 1000.0,
    backend: BackendOption = Backend(DEFAULT_BACKEND),
    perturb: PerturbOption = 0.0,
    hand_errors: HandErrorsOption = 0.0,
    search: SearchOption = Search.best,
    transition: TransitionOption = Transition.auto,
    time_budget: BudgetOption = TIME_BUDGET,
    probe: Annotated[bool, typer.Option(help='Feel where the object lies in the end.')] = True,
    attempts: Annotated[
        int,
        typer.Option(
            '--attempts',
            min=1,
            max=20,
            help='Trajectories at most: felt elsewhere, planned again from there.',
        ),
    ] = MAX_ATTEMPTS,
    hardware: Annotated[
        Hardware | None,
        typer.Option(
            '--hardware',
            help='A simulated hand, by its physics; none: a hand of yours is there; ros2_control: '
            'drives of yours under ros2_control, by our bridge.',
            show_default=DEFAULT_BACKEND,
        ),
    ] = None,
    no_hardware: Annotated[
        bool, typer.Option('--no-hardware', help='The same as --hardware none.')
    ] = False,
    params: Annotated[
        Path | None,
        typer.Option(
            '--params',
            metavar='FILE',
            exists=True,
            dir_okay=False,
            help='ROS parameter file for the nodes: joints of your drives, gains.',
        ),
    ] = None,
    network: Annotated[
        bool,
        typer.Option(
            '--network',
            help='Let other machines take part, and command the drives; else only this one.',
        ),
    ] = False,
) -> None:
    """Plan and execute on the ROS 2 graph: every node a process, a simulated hand as hardware.

    Example: wholearm run regular_hexagon --pacing lockstep --record runs/first
    """
    _refuse_early(record, figures, view)
    choose_transport(network=network)
    path = scenario_path(scenario).absolute()
    faces = _faces(sequence)
    first, then = (faces[0], faces[1:]) if faces else (goal_edge, [])
    if sequence and goal_edge is not None:
        raise WholeArmError('--sequence and --goal-edge: allowed: one of the two')
    asked = load_asked(str(path), first)
    for face in then:
        load_asked(str(path), face)  # refused before anything is started
    options = RunOptions(
        str(path) if first is None else json.dumps(scenario_to_dict(asked)),
        pacing=pacing.value,
        seed=seed,
        record=record and record.absolute(),
        storage=storage.value,
        view=view,
        rate=rate,
        search=search.value,
        transition=transition.value,
        time_budget=time_budget,
        probe=probe,
        attempts=attempts,
        hardware=_hardware(hardware, no_hardware, backend),
        params=params and params.absolute(),
        then=tuple(then),
        perturb=perturb,
        hand_errors=hand_errors,
    )
    report = _run(asked, options)
    _print(report, options, str(path))
    if figures is not None and options.record is not None:
        drawn = (
            figures_of(options.record, figures)
            if report.planned
            else figures_without_a_plan(asked, report.message, figures)
        )
        for written in drawn:
            _line('report' if written.suffix == '.html' else 'figure', written)
    finish(report.success)


def _faces(sequence: str) -> list[int]:
    """Raises WholeArmError for anything but numbers with commas between them."""
    try:
        return [int(face) for face in sequence.split(',')] if sequence else []
    except ValueError:
        raise WholeArmError(
            f'--sequence {sequence!r}: allowed: numbers of edges with commas, as 3,5,0'
        ) from None


def _hardware(asked: Hardware | None, none: bool, backend: Backend) -> str:
    """What --hardware says; else what --no-hardware or --backend do."""
    if asked is not None:
        return asked.value
    return Hardware.none.value if none else backend.value


def _refuse_early(record: Path | None, figures: Path | None, view: bool) -> None:
    """What can be refused before anything is started."""
    if record is not None and record.exists():
        raise WholeArmError(
            f'--record {record}: exists already; allowed: a directory that does not exist yet'
        )
    if figures is not None and record is None:
        raise WholeArmError(
            '--figures: they are drawn from the bag; allowed: together with --record DIR'
        )
    if view and not os.environ.get('DISPLAY'):
        raise WholeArmError(
            '--view: there is no screen here (DISPLAY is not set); allowed: run without --view'
        )


def _run(scenario: Scenario, options: RunOptions) -> RunReport:
    """The run; ends the command when the graph breaks or is interrupted."""
    with graph_at_work(), view_on(out) as view:
        return run_graph(scenario, options, view, on_client_ready=view.on_client_ready)


def _print(report: RunReport, options: RunOptions, scenario: str) -> None:
    """The verdict first, then what led to it; of a sequence the last goal, and a line for each."""
    judged = report.judged
    sequence = (*report.before, report)
    if len(sequence) > 1 or report.left:
        good, all_of_them = sum(one.reached for one in sequence), len(sequence) + len(report.left)
        colour = 'green' if report.success else 'red'
        out.print(f'[bold {colour}]{good} of {all_of_them} faces reached[/]')
        for one in sequence:
            _line('goal', _face(one))
        for face in report.left:
            _line('goal', f'edge {face}: not tried: where the object lies is not known')
    elif report.success:
        out.print(f'[bold green]success:[/] {_arrival(report)}')
    elif report.attempts:
        truly = f' (truly: {judged.reason})' if judged and judged.reason else ''
        reason = f'{report.result.get("reason", "")}{truly}'
        out.print(f'[bold red]not at the goal:[/] {escape(reason)}', soft_wrap=True)
    else:
        out.print(f'[bold red]not executed:[/] {escape(report.message)}', soft_wrap=True)
    _line('scenario', scenario)
    if report.planned:
        _line('plan', report.message.removeprefix('plan '))
    elif not report.attempts:
        _line('next', advice_for(scenario))
    _line('timings', _timings(report))
    if report.attempts:
        modes = [f'{mode} {seconds:.2f} s' for mode, seconds in report.modes.items() if seconds]
        _line('path', f'{report.path_length} subgoals')
        _line('modes', ', '.join(modes))
        for place, attempt in enumerate(report.attempts, 1):
            _line('' if place > 1 else 'attempts', attempt_line(place, attempt))
        _line('goal', f'{report.result.get("outcome")}: {report.result.get("reason")}')
    if judged is not None:
        x, y, turn = judged.pose
        _line(
            'final pose',
            f'x {x:.6f} m, y {y:.6f} m, rotation {turn:.6f} rad; {judged.angle_error:+.4f} rad '
            f'from the goal, {1e3 * judged.gap:+.3f} mm from the palm',
        )
    if options.record:
        _line('bag', options.record)


def _face(report: RunReport) -> str:
    goal, attempts = report.scenario.goal, sum(one['planned'] for one in report.attempts)
    face = f'edge {goal.edge}' if isinstance(goal, GoalOnEdge) else 'pose'
    truly = ''
    if report.judged is not None and report.judged.executed != report.reached:
        truly = ', though the object is ' + ('there' if report.judged.executed else 'not there')
    said = f'{report.result.get("outcome")}{truly}: {report.result.get("reason")}'
    return f'{face} after {attempts} attempt{"" if attempts == 1 else "s"}: {said}'


def _arrival(report: RunReport) -> str:
    if report.judged is not None:
        return 'the object rests on its goal'
    if report.result.get('claimed') == AT_GOAL:
        return 'the object was felt at its goal'
    return 'the trajectory was led to its end; where the object lies was not felt'


def _timings(report: RunReport) -> str:
    times = ', '.join(f'{name} {seconds:.2f} s' for name, seconds in report.timings.items())
    search = ', '.join(
        f'{key.removesuffix("_ms")} {float(report.planner[key]):.0f} ms'
        for key in ('plan_ms', 'generate_ms', 'verify_ms')
        if key in report.planner
    )
    return f'{times} ({search})' if search else times


def _line(name: str, text: object) -> None:
    out.print(f'{name:12}{escape(str(text))}', soft_wrap=True)
