"""The command line. Commands import what they need when called: --help is quick."""

import sys
from pathlib import Path
from typing import List, Optional

import typer
from rich.console import Console
from typer.core import TyperCommand, TyperGroup

from wholearm_ros.errors import SolverError, WholeArmError
from wholearm_ros.model.choices import BAD_INPUT, FAILED, OK, Backend, Search, Transition

out, err = Console(highlight=False), Console(stderr=True, highlight=False)


class _Commands(TyperGroup):
    """`run` needs ROS 2 and is only imported when it is asked for."""

    def list_commands(self, ctx):
        return [*super().list_commands(ctx), 'run']

    def get_command(self, ctx, name):
        return _run_command() if name == 'run' else super().get_command(ctx, name)

    def invoke(self, ctx):
        try:
            return super().invoke(ctx)
        except WholeArmError as error:
            err.print(f'[bold red]error:[/] {_escape(error)}', soft_wrap=True)
            ctx.exit(FAILED if isinstance(error, SolverError) else BAD_INPUT)


HELP = {'help_option_names': ['-h', '--help']}
app = typer.Typer(
    cls=_Commands,
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode='rich',
    context_settings=HELP,
)

EXIT_CODES = (
    'Exit codes: 0 success, 1 honest failure (no plan; object not at its goal), 2 bad input.'
)

ScenarioArgument = typer.Argument(..., metavar='SCENARIO', help='Scenario file, YAML or JSON.')
SeedOption = typer.Option(
    0, '--seed', min=0, help='Of the search and of what is drawn at random; same seed, same result.'
)
SearchOption = typer.Option(
    Search.best, '--search', help="best: widest margins first; random: the paper's search."
)
TransitionOption = typer.Option(
    Transition.auto,
    '--transition',
    help='How torque ranges that do not overlap are crossed; auto: what proves more robust.',
)
BudgetOption = typer.Option(
    180.0, '--time-budget', min=0.0, help='Seconds for a plan, its verification included.'
)
BackendOption = typer.Option(
    Backend.pybullet, '--backend', help='Stand-in of the hand; planar needs no PyBullet.'
)
PerturbOption = typer.Option(
    0.0,
    '--perturb',
    min=0.0,
    max=10.0,
    metavar='LEVEL',
    help='Draw mass, shape, friction, delay, torque and noise that the planner is not told of; '
    '1: ±5 %, ±0.5 mm, 0-0.05, 0-3 ms, ±3 %, 0.2 mrad.',
)


def _writable(path: Optional[Path]) -> Optional[Path]:
    """Refused before the work, not after it."""
    if path is not None and not path.absolute().parent.is_dir():
        raise typer.BadParameter(f'{path.absolute().parent} is not a directory')
    return path


JsonOption = typer.Option(
    None,
    '--json',
    metavar='OUT',
    dir_okay=False,
    writable=True,
    callback=_writable,
    help='Write the result here as JSON.',
)


@app.callback()
def about():
    """Whole-arm manipulation of a slippery polygon by two fingers and a palm: planned, verified and executed.

    [bold]Examples[/]

      wholearm plan config/asymmetric_hexagon.yaml --json plan.json
      wholearm simulate plan.json
      wholearm simulate config/regular_hexagon.yaml --perturb 1 --seed 3
      wholearm run --record runs/first          (needs ROS 2)
      wholearm report runs/first

    Exit codes: 0 success, 1 honest failure (no plan; object not at its goal), 2 bad input.
    """


@app.command(epilog=EXIT_CODES)
def plan(
    scenario: Path = ScenarioArgument,
    seed: int = SeedOption,
    search: Search = SearchOption,
    transition: Transition = TransitionOption,
    time_budget: float = BudgetOption,
    json_out: Optional[Path] = JsonOption,
):
    """Plan a scenario: contact states from start to goal, the trajectory through them, verified.

    Example: wholearm plan config/asymmetric_hexagon.yaml --seed 1 --json plan.json
    """
    answer = _offer(_scenario(scenario), seed, search, transition, time_budget)
    if json_out:
        _write(json_out, answer.plan.to_json())
    _show_answer(answer)
    raise typer.Exit(OK if answer.trajectory is not None else FAILED)


@app.command(epilog=EXIT_CODES)
def simulate(
    source: Path = typer.Argument(
        ...,
        metavar='PLAN_OR_SCENARIO',
        help='A plan written by `wholearm plan --json`, or a scenario file.',
    ),
    seed: int = SeedOption,
    perturb: float = PerturbOption,
    search: Search = SearchOption,
    transition: Transition = TransitionOption,
    time_budget: float = BudgetOption,
    backend: Backend = BackendOption,
    rate: float = typer.Option(1000.0, '--rate', min=50.0, max=10000.0, help='Control rate in Hz.'),
    view: bool = typer.Option(False, '--view', help="PyBullet's window, where there is a screen."),
    run_out: Optional[Path] = typer.Option(
        None,
        '--run',
        metavar='OUT',
        dir_okay=False,
        writable=True,
        callback=_writable,
        help='Write the whole run here, for `report`.',
    ),
    json_out: Optional[Path] = JsonOption,
):
    """Execute a plan on a stand-in of the hand, without ROS; a scenario is planned first.

    Example: wholearm simulate config/asymmetric_hexagon.yaml --perturb 1 --seed 3
    """
    from wholearm_ros.suite.suite import SuiteOptions
    from wholearm_ros.suite.summary import judged_run, show_run

    planned = _plan_document(source)
    if planned is None:
        answer = _offer(_scenario(source), seed, search, transition, time_budget)
        _show_answer(answer)
        plan_made, trajectory = answer.plan, answer.trajectory
    else:
        plan_made, trajectory = planned
    task = plan_made.scenario
    if trajectory is None:
        raise typer.Exit(FAILED)
    options = SuiteOptions(seed=seed, perturb=perturb, backend=backend.value, rate=rate)
    record, judged, document = judged_run(task, trajectory, options, view)
    if json_out:
        _write_json(json_out, document)
    if run_out:
        from wholearm_ros.report.run_document import run_document

        _write(
            run_out,
            run_document(
                plan_made,
                trajectory,
                record,
                {'source': 'wholearm simulate', 'backend': backend.value, 'perturbation': perturb},
            ),
        )
    show_run(out, record, judged)
    raise typer.Exit(OK if judged.executed else FAILED)


@app.command(
    epilog='Exit codes: 0 every task was worked on, 1 an error in at least one of them, 2 bad input.'
)
def suite(
    file: Path = typer.Argument(..., metavar='FILE', help='A wholearm-suite/1 document.'),
    seed: int = SeedOption,
    perturb: float = PerturbOption,
    draws: int = typer.Option(1, '--draws', min=1, max=1000, help='Perturbed runs of each plan.'),
    jobs: int = typer.Option(1, '--jobs', min=1, max=256, help='Processes of this machine.'),
    scheduler: Optional[str] = typer.Option(
        None,
        '--scheduler',
        metavar='ADDRESS',
        help='Work on the workers of this Dask scheduler instead, e.g. tcp://127.0.0.1:8786.',
    ),
    search: Search = SearchOption,
    transition: Transition = TransitionOption,
    time_budget: float = BudgetOption,
    backend: Backend = BackendOption,
    json_out: Optional[Path] = JsonOption,
):
    """Plan and execute many scenarios, and count what was planned and what reached its goal.

    Example: wholearm suite benchmarks/suite.json --perturb 1 --draws 5 --jobs 2 --json result.json
    """
    from wholearm_ros.suite.suite import SuiteOptions, run_suite, summarize
    from wholearm_ros.suite.suite_file import load_suite
    from wholearm_ros.suite.summary import show_suite, suite_document, with_progress

    tasks = load_suite(file)
    options = SuiteOptions(
        seed=seed,
        perturb=perturb,
        draws=draws,
        search=search.value,
        transition=transition.value,
        time_budget=time_budget,
        backend=backend.value,
    )
    results = with_progress(
        err, tasks, lambda heard: run_suite(tasks, options, jobs, heard, scheduler)
    )
    summary = summarize(results)
    if json_out:
        _write_json(json_out, suite_document(str(file), tasks, options, results, summary))
    show_suite(out, results, summary)
    raise typer.Exit(FAILED if summary['errors'] else OK)


@app.command(epilog='Exit codes: 0 the report was written, 2 bad input.')
def report(
    sources: List[Path] = typer.Argument(
        ...,
        metavar='BAG_OR_RUN...',
        help='A bag, the directory of a run, a document of `simulate --run`, or '
        'results of `suite --json`, several for several levels.',
    ),
    target: Optional[Path] = typer.Option(
        None,
        '-o',
        '--output',
        metavar='OUT',
        dir_okay=False,
        writable=True,
        callback=_writable,
        show_default='report.html beside the source',
        help='The HTML file to write.',
    ),
):
    """Write what happened as one HTML file that needs no network: animation, torques, contact states, errors.

    Example: wholearm report runs/first -o first.html
    """
    from wholearm_ros.report.html.write import default_target, write_report

    written = write_report(sources, target or default_target(sources[0]))
    out.print(f'{written}  ({written.stat().st_size / 1e6:.1f} MB)', soft_wrap=True)


@app.command()
def version():
    """The version of wholearm_ros."""
    from importlib.metadata import PackageNotFoundError
    from importlib.metadata import version as installed

    try:
        out.print(f'wholearm_ros {installed("wholearm_ros")}')
    except PackageNotFoundError:
        out.print('wholearm_ros, not installed (a source tree)')


def main():
    """Entry point of `wholearm`."""
    app(prog_name='wholearm')


# ---------------------------------------------------------------------- what the commands share
def _run_command() -> TyperCommand:
    """`wholearm run`, or, where ROS 2 cannot be imported, a command that says so, whatever its options are."""
    settings = dict(HELP)
    try:
        from wholearm_ros.cli.run_command import run
    except ImportError as error:
        if (error.name or '').partition('.')[0] == 'wholearm_ros':
            raise  # a mistake of ours, not a missing ROS
        missing, settings = (
            str(error),
            {**HELP, 'ignore_unknown_options': True, 'allow_extra_args': True},
        )

        def run():
            """Plan and execute on the ROS 2 graph (needs ROS 2, which cannot be imported here)."""
            err.print(
                f'[bold red]error:[/] run: {_escape(missing)}; allowed: a sourced ROS 2 Jazzy, or its wheels '
                'installed. `wholearm simulate` does without ROS.',
                soft_wrap=True,
            )
            raise typer.Exit(BAD_INPUT)

    single = typer.Typer(add_completion=False, rich_markup_mode='rich', context_settings=HELP)
    single.command('run', epilog=EXIT_CODES, context_settings=settings)(run)
    return typer.main.get_command(single)


def _scenario(path: Path):
    from wholearm_ros.model.scenario_file import load_scenario

    return load_scenario(path)


def _offer(scenario, seed, search, transition, time_budget):
    from wholearm_ros.planner.planner import plan_and_verify
    from wholearm_ros.planner.request import PlanRequest

    request = PlanRequest(
        search=search.value, seed=seed, transition=transition.value, time_budget=time_budget
    )
    with err.status('planning') as status:
        return plan_and_verify(
            scenario, request, progress=lambda line: status.update(f'planning: {_escape(line)}')
        )


def _plan_document(path: Path):
    """(plan, trajectory) of the plan document at `path`; None when it is not one."""
    from wholearm_ros.model.plan import FORMAT, ContactPlan
    from wholearm_ros.model.yaml_text import read_text
    from wholearm_ros.suite.suite_file import MAX_BYTES

    text = read_text(path, MAX_BYTES)
    if FORMAT not in text[:200]:
        return None
    from wholearm_ros.trajectory.main_trajectory import generate

    read = ContactPlan.from_json(text)
    if not read.found:
        raise WholeArmError(f'{path}: holds no plan: {read.reason}; allowed: a plan that was found')
    return read, generate(read.scenario, read)


def _show_answer(answer):
    found = answer.trajectory is not None
    out.print(_escape(answer.plan.summary()), soft_wrap=True)
    if not found and answer.plan.found:
        out.print('no trajectory of it survives verification', soft_wrap=True)
    if answer.verification is not None:
        told = answer.verification.to_dict()
        out.print(
            f'verified: {told["survived"]} of {told["copies"]} simulated copies reach the goal'
        )
    out.print(
        ', '.join(
            f'{name.removesuffix("_ms")} {value:.0f} ms' for name, value in answer.timings.items()
        )
    )


def _write_json(path: Path, document: dict):
    import json

    _write(path, json.dumps(document, indent=1, allow_nan=False) + '\n')


def _write(path: Path, text: str):
    try:
        path.write_text(text)
    except OSError as error:
        raise WholeArmError(
            f'--json {path}: cannot be written: {error.strerror or error}'
        ) from error


def _escape(text) -> str:
    return str(text).replace('[', r'\[')


if __name__ == '__main__':
    sys.exit(main())
