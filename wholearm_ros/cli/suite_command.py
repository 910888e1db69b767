"""`wholearm suite`: plan and execute many scenarios; a line for each as soon as it is done."""

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from wholearm_ros.cli.options import (
    MIN_SUCCESS,
    TIME_BUDGET,
    BudgetOption,
    HandErrorsOption,
    JsonOption,
    JudgeOption,
    PerturbOption,
    SearchOption,
    SeedOption,
    SuccessOption,
    TransitionOption,
)
from wholearm_ros.cli.output import err, finish, print_plain, write_json
from wholearm_ros.model.backends import DEFAULT_BACKEND
from wholearm_ros.model.choices import Search, Transition
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.suite.jury_summary import jury_lines
from wholearm_ros.suite.result_document import suite_document
from wholearm_ros.suite.statistics import TIMES, summarize
from wholearm_ros.suite.suite import run_suite
from wholearm_ros.suite.suite_file import SuiteEntry, load_suite
from wholearm_ros.suite.suite_options import SuiteOptions

EPILOG = 'Exit codes: 0 every task was worked on, 1 an error in at least one of them, 2 bad input.'


def suite(
    file: Annotated[Path, typer.Argument(metavar='FILE', help='A wholearm-suite/1 document.')],
    seed: SeedOption = 0,
    perturb: PerturbOption = 0.0,
    hand_errors: HandErrorsOption = 0.0,
    draws: Annotated[
        int, typer.Option('--draws', min=1, max=1000, help='Perturbed runs of each plan.')
    ] = 1,
    attempts: Annotated[
        int,
        typer.Option(
            '--attempts',
            min=1,
            max=20,
            help='Trajectories at most in a run: felt elsewhere, planned again from there.',
        ),
    ] = 1,
    probe: Annotated[bool, typer.Option(help='Feel where the object lies after each run.')] = True,
    jobs: Annotated[
        int, typer.Option('--jobs', min=1, max=256, help='Processes of this machine.')
    ] = 1,
    scheduler: Annotated[
        str | None,
        typer.Option(
            '--scheduler',
            metavar='ADDRESS',
            help='Use the workers of this Dask scheduler instead, e.g. tcp://127.0.0.1:8786.',
        ),
    ] = None,
    search: SearchOption = Search.best,
    transition: TransitionOption = Transition.auto,
    time_budget: BudgetOption = TIME_BUDGET,
    min_success: SuccessOption = MIN_SUCCESS,
    backend: JudgeOption = DEFAULT_BACKEND,
    json_out: JsonOption = None,
) -> None:
    """Plan and execute many scenarios, and count what was planned and what reached its goal.

    Example: wholearm suite benchmarks/suite.json --perturb 1 --draws 5 --jobs 2 --json result.json
    """
    tasks = load_suite(file)
    request = PlanRequest(
        search=search.value,
        seed=seed,
        transition=transition.value,
        time_budget=time_budget,
        min_success=min_success,
    )
    options = SuiteOptions(
        request, perturb, draws, backend, attempts=attempts, probe=probe, hand_errors=hand_errors
    )
    results = _run_with_progress(tasks, options, jobs, scheduler)
    summary = summarize(results)
    if json_out:
        write_json(json_out, suite_document(str(file), tasks, options, results, summary))
    _print_summary(summary)
    finish(not summary['errors'])


def _run_with_progress(
    tasks: tuple[SuiteEntry, ...], options: SuiteOptions, jobs: int, scheduler: str | None
) -> list[dict[str, Any]]:
    """Results in the tasks' order; a row is printed when its task is done, in a pipe as well."""
    width = max(4, *(len(task.name) for task in tasks))
    print_plain(f'{"task":{width}}  planned  executed    plan ms  verify ms')
    columns = TextColumn('suite'), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*columns, console=err, transient=True) as progress:
        bar = progress.add_task('suite', total=len(tasks))

        def on_result(result: dict[str, Any]) -> None:
            print_plain(_row(result, width))
            progress.advance(bar)

        return run_suite(tasks, options, jobs, on_result, scheduler)


def _row(result: dict[str, Any], width: int) -> str:
    done = [draw['executed'] for draw in result['draws']]
    executed = f'{sum(done)}/{len(done)}' if len(done) > 1 else _yes(result['executed'])
    plan_ms, verify_ms = (
        '' if result[name] is None else f'{result[name]:.1f}' for name in ('plan_ms', 'verify_ms')
    )
    row = f'{result["name"]:{width}}  {_yes(result["planned"]):7}  {executed:8}'
    row = f'{row} {plan_ms:>10} {verify_ms:>10}'
    return row if result['executed'] else f'{row}  {_why(result)}'


def _why(result: dict[str, Any]) -> str:
    if 'error' in result:
        return 'ERROR ' + str(result['error']).strip().splitlines()[-1]
    reasons = dict.fromkeys(draw['reason'] for draw in result['draws'] if draw['reason'])
    return str(result['reason']) or '; '.join(reasons)


def _print_summary(summary: dict[str, Any]) -> None:
    success = 'nothing planned' if summary['sound'] is None else f'{summary["sound"]:.3f}'
    print_plain(
        f'{summary["tasks"]} tasks: {summary["planned"]} planned, {summary["executed"]} executed '
        f'({summary["executed_runs"]} of {summary["runs"]} runs, share {success}), '
        f'{summary["errors"]} errors'
    )
    for line in jury_lines(summary['jury']) if summary['jury'] else ():
        print_plain(line)
    if summary['felt_runs']:
        print_plain(
            f'felt {summary["felt_runs"]} runs: {summary["false_success"]} false successes, '
            f'{summary["false_failure"]} false failures, {summary["lost"]} lost, '
            f'{summary["unknown"]} not known'
        )
    for name in TIMES:
        if summary[name]:
            median, p95 = summary[name]['median'], summary[name]['p95']
            print_plain(
                f'{name.removesuffix("_ms")}: median {median:.1f} ms, 95th percentile {p95:.1f} ms'
            )


def _yes(value: bool) -> str:
    return 'yes' if value else 'no'
