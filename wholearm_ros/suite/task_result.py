"""A task planned and executed: its entry in the result of a suite (a JSON object)."""

import traceback
from typing import Any

import numpy as np

from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.planner.legs import LegPlanner, leg_of
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.simulation.closed_loop import RunRecord
from wholearm_ros.suite.execution import JudgedRun, execute
from wholearm_ros.suite.sequence import run_sequence
from wholearm_ros.suite.statistics import TIMES
from wholearm_ros.suite.suite_file import SuiteEntry
from wholearm_ros.suite.suite_options import SuiteOptions

MOTION_PERIOD = 0.04  # [s] between two rows of a result's `motion`
Result = dict[str, Any]


def run_task(task: SuiteEntry, options: SuiteOptions) -> Result:
    """Plan and execute one task. Whatever goes wrong is reported in `error`, never as 'no plan'."""
    try:
        return _planned_and_executed(task, options)
    except WholeArmError as error:
        return failed(task.name, str(error))
    # The boundary of a task: a bug in one must be seen, and must not hide the others' results.
    except Exception:
        return failed(task.name, traceback.format_exc())


def failed(name: str, error: str) -> Result:
    """The result of a task that could not be worked on."""
    return {**_empty(name), 'reason': 'error', 'error': error}


def _empty(name: str) -> Result:
    """Every key of a result, with what it holds when nothing was planned."""
    return {
        'name': name,
        'planned': False,
        'reason': '',
        **dict.fromkeys(TIMES),
        'subgoals': 0,
        'path_length': 0,
        'modes': {},
        'certificate': None,
        'executed': False,
        'final_pose': None,
        'motion': None,
        'draws': [],
    }


def _planned_and_executed(task: SuiteEntry, options: SuiteOptions) -> Result:
    scenario, faces = task.parsed()
    result, first = _empty(task.name), None
    if not scenario.to_be_felt:
        maps = MapStore(scenario) if options.maps else None
        answer = LegPlanner(options.request, maps).plan(scenario)
        first = leg_of(scenario, answer)
        result |= _of_plan(answer.plan, answer.trajectory)
        result |= {name: _number(answer.timings.get(name)) for name in TIMES}
    count = options.draws if options.perturbed else 1
    if faces:
        told = [run_sequence(scenario, faces, first, options, k, task.name) for k in range(count)]
        executed = all(draw['executed'] for draw in told)
        return {**result, 'executed': executed, 'reached': told[0]['reached'], 'draws': told}
    if first is None and not scenario.to_be_felt:
        return result
    runs = [execute(scenario, first, options, draw, task.name) for draw in range(count)]
    if scenario.to_be_felt:
        result['planned'] = any(run.attempts and run.attempts.attempts for run in runs)
    draws = [_of_draw(run, options.perturbed) for run in runs]
    return {
        **result,
        'executed': all(run.judged.executed for run in runs),
        'final_pose': draws[0]['final_pose'],
        'motion': _motion(runs[0].record),
        'draws': draws,
    }


def _of_plan(plan: ContactPlan, trajectory: ManipulationTrajectory | None) -> Result:
    return {
        'planned': trajectory is not None,
        'reason': '' if trajectory is not None else f'{plan.outcome}: {plan.reason}',
        'subgoals': len(plan.subgoals),
        'path_length': len(plan.path),
        'modes': trajectory.time_in_modes() if trajectory is not None else {},
        'certificate': plan.certificate.to_dict() if plan.certificate is not None else None,
    }


def _of_draw(run: JudgedRun, perturbed: bool) -> Result:
    told: Result = {
        'executed': run.judged.executed,
        'reason': run.judged.reason,
        'final_pose': run.judged.pose.tolist(),
        'angle_error': run.judged.angle_error,
    }
    if run.attempts is not None:
        told.update(run.attempts.to_dict())
    if perturbed:
        told['perturbation'] = run.perturbation.to_dict()
    if run.verdict is not None:
        told['jury'] = run.verdict.to_dict()
    return told


def _motion(record: RunRecord) -> Result:
    """What is needed to see a run again: rows of x, y, φ, θ_L, θ_R [m, m, rad] and the mode in
    each.
    """
    every = max(1, round(MOTION_PERIOD / (record.times[1] - record.times[0])))
    rows = np.arange(0, len(record.times), every)
    return {
        'period': MOTION_PERIOD,
        'rows': np.hstack([record.poses, record.angles])[rows].round(4).tolist(),
        'modes': [record.modes[k] for k in rows],
    }


def _number(value: float | None) -> float | None:
    return None if value is None else float(value)
