"""The suite: many tasks planned and executed on a stand-in, without ROS, by the same code as the nodes."""

import traceback
import zlib
from dataclasses import dataclass, field
from functools import partial
from typing import Callable, Iterable, Optional

import numpy as np

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.perturbation import draw_perturbation
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.simulation.closed_loop import RunRecord, run
from wholearm_ros.simulation.outcome import outcome
from wholearm_ros.suite.suite_file import SuiteEntry
from wholearm_ros.suite.workers import work_on

MOTION_PERIOD = 0.04  # [s] between two rows of a result's `motion`
TIMES = ('plan_ms', 'generate_ms', 'verify_ms')


@dataclass(frozen=True)
class SuiteOptions:
    """seed: of the search and of the perturbations; perturb: their level, 0 for none; draws: perturbed runs a task;
    search, transition, candidates, moves, time_budget [s]: of the request to the planner; backend, rate [Hz]: of the stand-in."""

    seed: int = 0
    perturb: float = 0.0
    draws: int = 1
    search: str = 'best'
    transition: str = 'auto'
    candidates: int = PlanRequest.candidates
    moves: int = PlanRequest.moves
    time_budget: float = PlanRequest.time_budget
    backend: str = 'pybullet'
    rate: float = 1000.0
    controls: ControlOptions = field(default_factory=ControlOptions)


def run_suite(
    tasks: Iterable[SuiteEntry],
    options: SuiteOptions,
    jobs: int = 1,
    on_result: Optional[Callable[[dict], None]] = None,
    scheduler: Optional[str] = None,
) -> list:
    """One result (dict) a task, in the tasks' order; `on_result` hears of each as it is done.

    jobs: processes of this machine; scheduler: address of a Dask scheduler whose workers are used instead.
    An error in a task is that task's result; it does not stop the others.
    """
    tasks, results = list(tasks), {}
    lost = lambda task, why: failed(task.name, why)
    for k, result in work_on(tasks, partial(run_task, options=options), lost, jobs, scheduler):
        results[k] = result
        if on_result:
            on_result(result)
    return [results[k] for k in range(len(tasks))]


def run_task(task: SuiteEntry, options: SuiteOptions) -> dict:
    """Plans and executes one task. Whatever goes wrong is told in `error`, never as 'no plan'."""
    try:
        return _planned_and_executed(task, options)
    except WholeArmError as error:
        return failed(task.name, str(error))
    except (
        Exception
    ):  # the boundary of a task: a bug in one must be seen, and must not hide the others' results
        return failed(task.name, traceback.format_exc())


def failed(name: str, error: str) -> dict:
    """The result of a task that could not be worked on."""
    return {
        'name': name,
        'planned': False,
        'reason': 'error',
        'error': error,
        **dict.fromkeys(TIMES),
        'subgoals': 0,
        'path_length': 0,
        'modes': {},
        'executed': False,
        'final_pose': None,
        'motion': None,
        'draws': [],
    }


def perturbation_rng(options: SuiteOptions, name: str, draw: int) -> np.random.Generator:
    """The generator of one draw: of the seed, the task's name and the draw's number only."""
    return np.random.default_rng([options.seed, zlib.crc32(name.encode()), draw])


def summarize(results: list) -> dict:
    """Counts and times over the results. sound: executed runs / runs of planned tasks, None when nothing was planned."""
    planned = [r for r in results if r['planned']]
    runs = [d for r in planned for d in r['draws']]
    done = sum(d['executed'] for d in runs)
    summary = {
        'tasks': len(results),
        'planned': len(planned),
        'executed': sum(r['executed'] for r in results),
        'errors': sum('error' in r for r in results),
        'runs': len(runs),
        'executed_runs': done,
        'sound': done / len(runs) if runs else None,
    }
    for name in TIMES:
        values = [r[name] for r in results if r[name] is not None]
        summary[name] = (
            {'median': float(np.median(values)), 'p95': float(np.percentile(values, 95))}
            if values
            else None
        )
    return summary


def _planned_and_executed(task: SuiteEntry, options: SuiteOptions) -> dict:
    scenario = parse_scenario(task.scenario, task.name)
    answer = plan_and_verify(
        scenario,
        PlanRequest(
            search=options.search,
            seed=options.seed,
            transition=options.transition,
            candidates=options.candidates,
            moves=options.moves,
            time_budget=options.time_budget,
        ),
    )
    plan, trajectory = answer.plan, answer.trajectory
    result = {
        'name': task.name,
        'planned': trajectory is not None,
        'reason': '' if trajectory is not None else f'{plan.outcome}: {plan.reason}',
        **{name: _number(answer.timings.get(name)) for name in TIMES},
        'subgoals': len(plan.subgoals),
        'path_length': len(plan.path),
        'modes': trajectory.time_in_modes() if trajectory is not None else {},
        'executed': False,
        'final_pose': None,
        'motion': None,
        'draws': [],
    }
    if trajectory is None:
        return result
    count = options.draws if options.perturb else 1
    runs = [_executed(scenario, trajectory, task.name, k, options) for k in range(count)]
    result['draws'], result['motion'] = [told for told, _ in runs], _motion(runs[0][1])
    result['executed'] = all(d['executed'] for d in result['draws'])
    result['final_pose'] = result['draws'][0]['final_pose']
    return result


def _executed(scenario: Scenario, trajectory, name: str, draw: int, options: SuiteOptions) -> tuple:
    """(what is told of it, its record)."""
    perturbation = draw_perturbation(
        perturbation_rng(options, name, draw), options.perturb, scenario
    )
    record = run(
        scenario,
        trajectory,
        backend=options.backend,
        rate=options.rate,
        perturbation=perturbation,
        controls=options.controls,
    )
    judged = outcome(scenario, record)
    told = {
        'executed': judged.executed,
        'reason': judged.reason,
        'final_pose': judged.pose.tolist(),
        'angle_error': judged.angle_error,
    }
    return ({**told, 'perturbation': perturbation.to_dict()} if options.perturb else told), record


def _motion(record: RunRecord) -> dict:
    """What is needed to see a run again: rows of x, y, φ, θ_L, θ_R [m, m, rad] and the name of the mode in each."""
    rows = np.arange(
        0, len(record.times), max(1, round(MOTION_PERIOD / (record.times[1] - record.times[0])))
    )
    return {
        'period': MOTION_PERIOD,
        'rows': np.hstack([record.poses, record.angles])[rows].round(4).tolist(),
        'modes': [record.modes[k] for k in rows],
    }


def _number(value) -> Optional[float]:
    return None if value is None else float(value)
