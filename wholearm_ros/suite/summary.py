"""What people and documents are told of a run and of a suite."""

from typing import Callable

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from wholearm_ros.model.perturbation import draw_perturbation
from wholearm_ros.simulation.closed_loop import RunRecord, run
from wholearm_ros.simulation.outcome import Outcome, outcome
from wholearm_ros.suite.suite import TIMES, SuiteOptions, perturbation_rng

RESULT_FORMAT = 'wholearm-suite-result/1'


def judged_run(scenario, trajectory, options: SuiteOptions, view: bool = False) -> tuple:
    """(record, outcome, document) of one run on a stand-in; the document is for --json."""
    perturbation = draw_perturbation(
        perturbation_rng(options, scenario.name, 0), options.perturb, scenario
    )
    record = run(
        scenario,
        trajectory,
        backend=options.backend,
        rate=options.rate,
        perturbation=perturbation,
        controls=options.controls,
        view=view,
    )
    judged = outcome(scenario, record)
    return (
        record,
        judged,
        {
            'name': scenario.name,
            'plan_id': trajectory.plan_id,
            'seed': options.seed,
            'perturb': options.perturb,
            'executed': judged.executed,
            'reason': judged.reason,
            'final_pose': judged.pose.tolist(),
            'angle_error': judged.angle_error,
            'gap': judged.gap,
            'modes': record.time_in_modes(),
            'perturbation': perturbation.to_dict(),
        },
    )


def show_run(console: Console, record: RunRecord, judged: Outcome) -> None:
    """A few lines for people."""
    x, y, turn = judged.pose
    console.print(
        'modes: '
        + ', '.join(f'{mode} {seconds:.2f} s' for mode, seconds in record.time_in_modes().items())
    )
    console.print(
        f'largest torques: left {np.abs(record.efforts[:, 0]).max():.2f}, '
        f'right {np.abs(record.efforts[:, 1]).max():.2f} N m'
    )
    console.print(
        f'final pose: x {x:.4f} m, y {y:.4f} m, {turn:.4f} rad; {judged.angle_error:+.4f} rad from the goal, '
        f'{1e3 * judged.gap:+.2f} mm from the palm'
    )
    console.print(
        '[bold green]at rest at the goal[/]'
        if judged.executed
        else f'[bold red]not at the goal:[/] {judged.reason}',
        soft_wrap=True,
    )


def with_progress(console: Console, tasks, work: Callable) -> list:
    """`work(on_result)` under a progress bar that counts results."""
    columns = (
        TextColumn('{task.description}'),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, transient=True) as progress:
        bar = progress.add_task('suite', total=len(tasks))

        def heard(result: dict) -> None:
            progress.update(bar, advance=1, description=result['name'])

        return work(heard)


def suite_document(file: str, tasks, options: SuiteOptions, results: list, summary: dict) -> dict:
    """`wholearm-suite-result/1`: the results, each with the scenario it is of."""
    return {
        'format': RESULT_FORMAT,
        'suite': file,
        'seed': options.seed,
        'perturb': options.perturb,
        'draws': options.draws,
        'search': options.search,
        'transition': options.transition,
        'time_budget': options.time_budget,
        'backend': options.backend,
        'rate': options.rate,
        'summary': summary,
        'tasks': [{**r, 'scenario': task.scenario} for task, r in zip(tasks, results)],
    }


def show_suite(console: Console, results: list, summary: dict) -> None:
    """A row a task, why those that were not executed were not, and the counts."""
    table = Table('task', 'planned', 'executed', 'plan ms', 'generate ms', 'verify ms', box=None)
    for r in results:
        times = ['' if r[name] is None else f'{r[name]:.1f}' for name in TIMES]
        table.add_row(r['name'], _yes(r['planned']), _runs(r), *times)
    console.print(table)
    for r in results:
        if not r['executed']:
            console.print(f'{r["name"]}: {_why(r)}', soft_wrap=True, markup=False)
    sound = 'nothing planned' if summary['sound'] is None else f'{summary["sound"]:.3f}'
    console.print(
        f'{summary["tasks"]} tasks: {summary["planned"]} planned, {summary["executed"]} executed '
        f'({summary["executed_runs"]} of {summary["runs"]} runs, sound {sound}), {summary["errors"]} errors'
    )
    for name in TIMES:
        if summary[name]:
            console.print(
                f'{name.removesuffix("_ms")}: median {summary[name]["median"]:.1f} ms, '
                f'p95 {summary[name]["p95"]:.1f} ms'
            )


def _yes(value: bool) -> str:
    return 'yes' if value else 'no'


def _runs(result: dict) -> str:
    draws = result['draws']
    return (
        _yes(result['executed'])
        if len(draws) < 2
        else f'{sum(d["executed"] for d in draws)}/{len(draws)}'
    )


def _why(result: dict) -> str:
    if 'error' in result:
        return 'ERROR ' + result['error'].strip().splitlines()[-1]
    return result['reason'] or '; '.join(
        dict.fromkeys(d['reason'] for d in result['draws'] if d['reason'])
    )
