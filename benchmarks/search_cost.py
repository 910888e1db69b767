"""Best search against the paper's randomized search: cost of the route, subgoals generated, time.

    python benchmarks/search_cost.py [SUITE.json] [--seeds 10]

Margin: least robust half width of the torque range [N m]; cost: contact-state changes plus motion [rad].
"""

import argparse
import time
from pathlib import Path

import numpy as np

from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.planning.routes import BEST, RANDOM, SearchOptions, plan
from wholearm_ros.suite.suite_file import load_suite


def timed(scenario, options):
    """(plan, milliseconds)"""
    began = time.perf_counter()
    answer = plan(scenario, options)
    return answer, 1e3 * (time.perf_counter() - began)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        'suite', type=Path, nargs='?', default=Path(__file__).with_name('suite.json')
    )
    parser.add_argument('--seeds', type=int, default=10)
    options = parser.parse_args()
    scenarios = [parse_scenario(task.scenario, task.name) for task in load_suite(options.suite)]
    for search in (BEST, RANDOM):
        timed(scenarios[0], SearchOptions(search))  # so that compiled code is loaded
    best_ms, random_ms, ratios, gains, best_subgoals, random_subgoals, found = (
        [],
        [],
        [],
        [],
        [],
        [],
        [0, 0],
    )
    for scenario in scenarios:
        best, milliseconds = timed(scenario, SearchOptions(BEST))
        best_ms.append(milliseconds)
        best_subgoals.append(best.counts['subgoals'])
        found[0] += best.found
        for seed in range(options.seeds):
            random, milliseconds = timed(scenario, SearchOptions(RANDOM, seed))
            random_ms.append(milliseconds)
            random_subgoals.append(random.counts['subgoals'])
            found[1] += random.found
            if best.found and random.found:
                ratios.append(random.cost['total'] / best.cost['total'])
                gains.append(best.cost['margin'] - random.cost['margin'])
    print(
        f'found: best {found[0]} of {len(scenarios)}, random {found[1]} of {len(scenarios) * options.seeds}'
    )
    print(
        f'cost(random) / cost(best): median {np.median(ratios):.2f}, mean {np.mean(ratios):.2f}, '
        f'p95 {np.quantile(ratios, 0.95):.2f}'
    )
    print(
        f'margin(best) - margin(random) [N m]: median {np.median(gains):.3f}, mean {np.mean(gains):.3f}, '
        f'least {min(gains):.3f}'
    )
    for name, ms, subgoals in (
        ('best', best_ms, best_subgoals),
        ('random', random_ms, random_subgoals),
    ):
        print(
            f'{name}: {np.median(ms):.1f} ms median, {np.quantile(ms, 0.95):.1f} ms p95; '
            f'{np.median(subgoals):.0f} subgoals median, {max(subgoals)} most'
        )


if __name__ == '__main__':
    main()
