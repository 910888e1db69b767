"""What the hand says against what is: suites, levels of perturbation, one attempt and several, as one table.

    python benchmarks/feeling.py [SUITE ...] --json OUT [--levels 0 1 2 3] [--draws 5] [--attempts 4] [--jobs 2]
                                 [--tasks N] [--seed 0] [--backend pybullet] [--time-budget 180] [--stop-outside]

Each task is planned once and executed at every level (a level of 0 once, else `--draws` times) with up to `--attempts`
attempts; how the run would have ended after its first attempt is read off the same run. OUT gets a line a task as soon as
that is done: the same command goes on where it was interrupted, and OUT.md gets the table. A row of it: planned tasks, runs, the
share at the goal, claims that are wrong either way, objects out of the hand, runs of which nothing is claimed, wrong edges
among those felt, |felt x − true x| (median, 95 %), seconds that a probe takes, and runs at the goal before their first probe
that were not after it (spoiled) and the other way round (mended). Below it: what certificates promise against what came of one attempt,
and what planning costs. `--stop-outside` stops a run that leaves its band and feels, instead of
finishing it.
"""

import argparse
import json
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.outcomes import AT_GOAL, LOST, UNKNOWN
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.planner.legs import leg_of
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.simulation.closed_loop import LoopOptions
from wholearm_ros.simulation.outcome import outcome
from wholearm_ros.suite.attempts import Attempts
from wholearm_ros.suite.execution import execute
from wholearm_ros.suite.suite_file import SuiteEntry, load_suite
from wholearm_ros.suite.suite_options import SuiteOptions
from wholearm_ros.suite.workers import work_on

HERE = Path(__file__).parent
COLUMNS = (
    'suite', 'level', 'attempts', 'planned', 'runs', 'at the goal', 'false success', 'false failure',
    'lost', 'unknown', 'wrong edge', 'x error, mm (median, p95)', 'probe, s (median, p95)',
    'spoiled, mended', 'attempts made',
)  # fmt: skip
Task = tuple[str, SuiteEntry]


def measure(task: SuiteEntry, levels: list, draws: int, options: SuiteOptions) -> dict:
    """One task, planned once: {task, planned, reason, planning_s (of the processor), certificate, runs: [...]}."""
    told = {'task': task.name, 'planned': False, 'reason': '', 'runs': []}
    try:
        scenario = parse_scenario(task.scenario, task.name)
        began = time.process_time()
        found = plan_and_verify(scenario, options.request)
        told['planning_s'] = round(time.process_time() - began, 3)
        if found.trajectory is None:
            return {**told, 'reason': f'{found.plan.outcome}: {found.plan.reason}'}
        told['certificate'] = found.plan.certificate.to_dict()
        for level in levels:
            asked = replace(options, perturb=level)
            for draw in range(draws if level else 1):
                made = execute(scenario, leg_of(scenario, found), asked, draw, task.name)
                run = described(scenario, made.attempts, options.attempts)
                told['runs'].append({'level': level, 'draw': draw, **run})
    except WholeArmError as error:
        return {**told, 'reason': f'error: {error}'}
    return {**told, 'planned': True}


def described(scenario, attempts: Attempts, most: int) -> dict:
    """What came of a run after its first attempt and after all of them."""
    first = attempts.motions[0]
    return {
        'before_probe': outcome(scenario, first.before_probe).executed,
        'after_probe': outcome(scenario, first.record).executed,
        'probes': [round(motion.probing_time, 3) for motion in attempts.motions],
        'after': {
            str(most): {
                **(ended := attempts.first(most)).to_dict(),
                'executed': outcome(scenario, ended.last).executed,
            }
            for most in sorted({1, most})
        },
    }


def row(suite: str, level: float, attempts: int, tasks: list) -> dict:
    """The figures of one suite at one level."""
    runs = [run for task in tasks for run in task['runs'] if run['level'] == level]
    ends = [run['after'][str(attempts)] for run in runs]
    felt = [e for e in ends if e['felt_edge'] is not None and e['true_edge'] is not None]
    at_goal = [e['claimed'] == AT_GOAL for e in ends]
    done = [e['executed'] for e in ends]
    return {
        'suite': suite,
        'level': level,
        'attempts': attempts,
        'planned': sum(task['planned'] for task in tasks),
        'tasks': len(tasks),
        'runs': len(runs),
        'executed': sum(done),
        'false_success': sum(a and not d for a, d in zip(at_goal, done)),
        'false_failure': sum(d and not a for a, d in zip(at_goal, done)),
        'lost': sum(e['claimed'] == LOST for e in ends),
        'unknown': sum(e['claimed'] == UNKNOWN for e in ends),
        'wrong_edge': sum(e['true_edge'] not in e['felt_edges'] for e in felt),
        'x_error_mm': spread(
            1e3 * abs(e['felt_x'] - e['true_x']) for e in felt if e['felt_x'] is not None
        ),
        'probe_s': spread(run['probes'][0] for run in runs),
        'spoiled': sum(r['before_probe'] and not r['after_probe'] for r in runs),
        'mended': sum(r['after_probe'] and not r['before_probe'] for r in runs),
        'attempts_made': float(np.mean([e['attempts'] for e in ends])) if ends else None,
    }


def spread(values) -> list:
    """[median, 95th percentile]."""
    values = list(values)
    return np.percentile(values, [50, 95]).round(2).tolist() if values else [None, None]


def table(rows: list) -> str:
    """Markdown."""
    lines = ['| ' + ' | '.join(COLUMNS) + ' |', '|---' * len(COLUMNS) + '|']
    for r in rows:
        share = f'{r["executed"] / r["runs"]:.3f}' if r['runs'] else ''
        shown = (
            r['suite'], f'{r["level"]:g}', r['attempts'], f'{r["planned"]} of {r["tasks"]}', r['runs'],
            share, r['false_success'], r['false_failure'], r['lost'], r['unknown'], r['wrong_edge'],
            '{}, {}'.format(*r['x_error_mm']), '{}, {}'.format(*r['probe_s']),
            f'{r["spoiled"]}, {r["mended"]}', f'{r["attempts_made"] or 0:.2f}',
        )  # fmt: skip
        lines.append('| ' + ' | '.join(map(str, shown)) + ' |')
    return '\n'.join(lines) + '\n'


def calibration(tasks: list) -> str:
    """Markdown: what the certificates promise of one attempt at their level against what came of it, by bound."""
    runs = [
        (task['certificate'], run['before_probe'])
        for task in tasks
        for run in task['runs']
        if run['level'] == task['certificate']['level']
    ]
    bounds = np.array([certificate['lower_bound'] for certificate, _ in runs])
    done = np.array([done for _, done in runs], float)
    lines = ['| bound | runs | mean bound | at the goal |', '|---' * 4 + '|']
    for low, high in ((0.8, 0.875), (0.875, 0.94), (0.94, 1.0), (0.0, 1.0)):
        of = (low <= bounds) & (bounds < high)
        if of.any():
            told = f'{of.sum()} | {bounds[of].mean():.3f} | {done[of].mean():.3f}'
            lines.append(f'| {low:g} to {high:g} | {told} |')
    return '\n'.join(lines) + '\n'


def costs(tasks: list) -> str:
    """Processor seconds of planning: median and 95th percentile with a plan, and without one."""
    with_plan, without = (
        spread(t['planning_s'] for t in tasks if t['planned'] is told and 'planning_s' in t)
        for told in (True, False)
    )
    return 'planning, s of the processor: {}, {} with a plan; {}, {} without\n'.format(
        *with_plan, *without
    )


def rows_of(names: list, levels: list, attempts: int, done: list) -> list:
    """Every row: suite by suite, and all of them together when there are several."""
    groups = {name: [d for d in done if d['suite'] == name] for name in names}
    if len(names) > 1:
        groups['all'] = done
    return [
        row(name, level, most, tasks)
        for name, tasks in groups.items()
        for level in levels
        for most in sorted({1, attempts})
    ]


def before(file: Path, asked: dict) -> list:
    """The tasks that `file` already has; ends the program when they were measured otherwise."""
    if not file.exists():
        return []
    # A line that was being written when the program was killed is measured again.
    whole = [text for text in file.read_text().splitlines(keepends=True) if text.endswith('\n')]
    head, *lines = map(json.loads, whole) if whole else [asked]
    if head != asked:
        sys.exit(
            f'error: --json {file}: measured with {head}; allowed: the same options, or a new file'
        )
    return lines


def begin(file: Path, lines: list) -> None:
    """`file` with these lines, whole at every instant."""
    new = file.with_suffix('.new')
    new.write_text(''.join(json.dumps(line) + '\n' for line in lines))
    new.replace(file)


def main() -> None:
    """Measure, or go on measuring, and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('suites', nargs='*', type=Path, default=[HERE / 'suite.json'])
    parser.add_argument('--json', type=Path, required=True, help='JSON lines, one a task')
    parser.add_argument('--levels', nargs='+', type=float, default=[0.0, 1.0, 2.0, 3.0])
    parser.add_argument('--draws', type=int, default=5)
    parser.add_argument('--attempts', type=int, default=4)
    parser.add_argument('--tasks', type=int, help='only so many of each suite')
    parser.add_argument('--jobs', type=int, default=1)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--backend', default='pybullet')
    parser.add_argument('--time-budget', type=float, default=PlanRequest.time_budget)
    parser.add_argument(
        '--stop-outside', action='store_true', help='stop a run that leaves its band'
    )
    options = parser.parse_args()
    asked = {k: v for k, v in vars(options).items() if k not in ('json', 'jobs', 'suites', 'tasks')}
    done = before(options.json, asked)
    known = {(d['suite'], d['task']) for d in done}
    todo = [
        (suite.stem, task)
        for suite in options.suites
        for task in load_suite(suite)[: options.tasks]
        if (suite.stem, task.name) not in known
    ]
    work = partial(
        measure,
        levels=options.levels,
        draws=options.draws,
        options=SuiteOptions(
            PlanRequest(seed=options.seed, time_budget=options.time_budget),
            attempts=options.attempts,
            backend=options.backend,
            loop=LoopOptions(controls=ControlOptions(stop_outside=options.stop_outside)),
        ),
    )
    begin(options.json, [asked, *done])
    with open(options.json, 'a') as file:
        went = time.monotonic()
        for count, (k, told) in enumerate(_results(todo, work, options.jobs), 1):
            done.append({'suite': todo[k][0], **told})
            print(json.dumps(done[-1]), file=file, flush=True)
            each = (time.monotonic() - went) / count
            print(
                f'{todo[k][0]} {told["task"]}: {told["reason"] or len(told["runs"])} '
                f'({len(done)} of {len(done) + len(todo) - count} tasks, '
                f'about {each * (len(todo) - count) / 60:.0f} min left)',
                file=sys.stderr,
                flush=True,
            )
    rows = rows_of([s.stem for s in options.suites], options.levels, options.attempts, done)
    told = '\n'.join((table(rows), calibration(done), costs(done)))
    options.json.with_suffix('.md').write_text(told)
    print(told)


def _results(todo: list[Task], work, jobs: int):
    def lost(task, why):
        return {'task': task.name, 'planned': False, 'reason': f'error: {why}', 'runs': []}

    return work_on([task for _, task in todo], work, lost, jobs)


if __name__ == '__main__':
    main()
