"""The parts of a planning call on every task of a suite, warm: a plan by each search, generation, verification."""

import resource

from timing import row, seconds, timed, value

from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.planner.warm import warm
from wholearm_ros.planning.routes import BEST, RANDOM, SearchOptions, plan
from wholearm_ros.rollout.perturbed_samples import build_perturbed_samples
from wholearm_ros.rollout.verification import verify
from wholearm_ros.trajectory.main_trajectory import generate

COPIES, LEVEL = 8, 1.0


def bench_suite(tasks, repeats: int = 3) -> dict:
    """name → row; each task counts once, with the median of its repeats."""
    warm()
    scenarios = [parse_scenario(task.scenario, task.name) for task in tasks]
    rows, planned = {}, []
    for search in (BEST, RANDOM):
        answers = [timed(lambda s=s: plan(s, SearchOptions(search))) for s in scenarios]
        again = [seconds(lambda s=s: plan(s, SearchOptions(search)), repeats) for s in scenarios]
        rows[f'suite.plan_{search}'] = row([sorted(times)[len(times) // 2] for times in again])
        rows[f'suite.found_{search}'] = value(sum(p.found for p, _ in answers), 'tasks')
        planned = planned or [p for p, _ in answers if p.found]
    return {**rows, **_executed(planned, repeats), 'suite.memory': value(_peak(), 'MB')}


def _executed(planned, repeats) -> dict:
    """Generation and verification of each task's best plan; a sample that fails early is as much work as it is."""
    generation, one, many, both = [], [], [], []
    for found in planned:
        scenario = found.scenario
        trajectory, copies = (
            generate(scenario, found),
            build_perturbed_samples(scenario, COPIES, LEVEL, 0),
        )
        for times, work in (
            (generation, lambda: generate(scenario, found)),
            (one, lambda: verify(trajectory, copies[:1])),
            (many, lambda: verify(trajectory, copies)),
            (both, lambda: verify(generate(scenario, found), copies)),
        ):
            taken = sorted(seconds(work, repeats))
            times.append(taken[len(taken) // 2])
    return {
        'suite.generate': row(generation),
        'suite.verify_nominal': row(one),
        f'suite.verify_{COPIES}_copies': row(many),
        f'suite.generate_and_verify_{COPIES}_copies': row(both),
    }


def _peak() -> float:
    """[MB] the most memory this process has held."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
