"""What planning a suite takes: how many tasks get a certified plan, seconds, and what of the search ends up in a plan.

    python benchmarks/planning.py [SUITE.json ...] [--search best] [--time-budget 300] [--json OUT]

One process, kernels loaded. Seconds are of the wall and of the processor (median, 95 %), apart for tasks with a plan and without.
Simulations are those of primitives and of samples that the search makes; of those, a plan needs one of each of its primitives and
one of every sample on each of its legs. Tasks without a plan are listed with the reason.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np

from wholearm_ros.model.modes import DYNAMIC
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.planner.warm import warm
from wholearm_ros.planning.routes import BEST, RANDOM
from wholearm_ros.suite.suite_file import load_suite


def measure(task, request):
    """One task: {task, planned, reason, wall_s, processor_s, and of a plan its bound, legs and simulations}."""
    scenario = parse_scenario(task.scenario, task.name)
    wall, processor = time.perf_counter(), time.process_time()
    found = plan_and_verify(scenario, request)
    told = {
        'task': task.name,
        'planned': found.trajectory is not None,
        'reason': found.plan.reason,
        'wall_s': round(time.perf_counter() - wall, 3),
        'processor_s': round(time.process_time() - processor, 3),
        'simulations': found.plan.counts.get('simulations', 0),
        'states': found.plan.counts.get('states_at_rest', 0),
    }
    if told['planned']:
        moves = sum(leg.mode == DYNAMIC for leg in found.plan.legs)
        told['legs'] = len(found.plan.legs)
        told['needed'] = moves + len(found.plan.legs) * (1 + request.samples)
        told['lower_bound'] = found.plan.certificate.lower_bound
    return told


def spread(values, digits=2):
    """'median (95 %: …)'."""
    if not len(values):
        return '–'
    middle, high = np.percentile(values, [50, 95])
    return f'{middle:.{digits}f} (95 %: {high:.{digits}f})'


def summary(rows):
    """Lines for people."""
    planned = [row for row in rows if row['planned']]
    none = [row for row in rows if not row['planned']]
    yield f'planned {len(planned)} of {len(rows)}'
    for name, some in (('with a plan', planned), ('without', none)):
        walls, processors = ([row[key] for row in some] for key in ('wall_s', 'processor_s'))
        yield f'{name}: wall {spread(walls)} s, processor {spread(processors)} s'
    made = sum(row['simulations'] for row in planned)
    if made:
        needed = sum(row['needed'] for row in planned)
        bounds = np.mean([row['lower_bound'] for row in planned])
        yield (
            f'of a plan: simulations {spread([row["simulations"] for row in planned], 0)}, states at rest '
            f'{spread([row["states"] for row in planned], 0)}, legs {spread([row["legs"] for row in planned], 0)}; '
            f'{needed / made:.1%} of the simulations are of ways of the plan; mean bound {bounds:.3f}'
        )
    for row in none:
        yield f'{row["task"]}: {row["reason"]}'


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    default = Path(__file__).with_name('suite.json')
    parser.add_argument('suites', type=Path, nargs='*', default=[default])
    parser.add_argument('--search', choices=(BEST, RANDOM), default=BEST)
    parser.add_argument('--time-budget', type=float, default=300.0)
    parser.add_argument('--json', type=Path)
    options = parser.parse_args()
    warm()
    request = PlanRequest(search=options.search, time_budget=options.time_budget)
    rows = []
    for suite in options.suites:
        mine = [measure(task, request) for task in load_suite(suite)]
        rows += [{'suite': suite.stem, **row} for row in mine]
        print(f'{suite.stem}, search {options.search}', *summary(mine), sep='\n  ', flush=True)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))


if __name__ == '__main__':
    main()
