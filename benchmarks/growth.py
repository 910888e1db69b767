"""How cost grows: vertices of the polygon, perturbed copies, tasks of a suite; the exponent of each, with a figure.

    python benchmarks/growth.py [--parts vertices copies suites] [--json docs/growth.json] [--out docs/images/growth.png]

Every part is measured on its own and added to the JSON, so that a busy machine can be given them one by one; the figure and the
table are drawn from what is there. An exponent is the slope of a straight line through the logarithms.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

import numpy as np
from make_suite import random_task
from rich.console import Console
from rich.table import Column, Table
from timing import seconds

from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.contacts import gap_table
from wholearm_ros.model.scenario_file import load_scenario, parse_scenario
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.planner.warm import warm
from wholearm_ros.planning.problem import build_problem
from wholearm_ros.planning.routes import BEST, RANDOM, SearchOptions, plan
from wholearm_ros.report.figures.canvas import new_figure, save
from wholearm_ros.rollout.perturbed_samples import build_perturbed_samples
from wholearm_ros.rollout.verification import verify
from wholearm_ros.suite.suite import run_suite
from wholearm_ros.suite.suite_file import SuiteEntry
from wholearm_ros.suite.suite_options import SuiteOptions

ROOT = Path(__file__).parents[1]
VERTICES, SHAPES = (3, 4, 6, 8, 12, 16, 24), 8
COPIES = (1, 2, 4, 8, 16, 32, 64)
SUITES, CORES = (48, 200, 600, 2000), (1, 2)
QUICK = SuiteOptions(PlanRequest(candidates=1, moves=0), backend='planar')
# a suite's tasks are tried once each: it is their number that counts
TITLES = {
    'vertices': 'vertices of the polygon',
    'copies': 'perturbed copies',
    'suites': 'tasks of a suite',
}
out = Console(highlight=False, width=None if sys.stdout.isatty() else 120)


def vertices() -> dict:
    """Median over random shapes of each number of vertices: one gap table, and one plan by either search."""
    series = {'gap table': [], 'plan, best search': [], 'plan, random search': []}
    for n in VERTICES:
        rng = np.random.default_rng(n)
        scenarios = [parse_scenario(random_task(rng, n, f'{n}gon')) for _ in range(SHAPES)]
        tasks = [build_problem(s.mirrored() if s.goal.direction == 'cw' else s) for s in scenarios]
        series['gap table'].append(np.median([_gap_table_seconds(task) for task in tasks]))
        for search in (BEST, RANDOM):
            times = [min(seconds(lambda: plan(s, SearchOptions(search)), 2)) for s in scenarios]
            series[f'plan, {search} search'].append(np.median(times))
    return _part('vertices', VERTICES, series)


def copies() -> dict:
    """Verification of the asymmetric hexagon's trajectory in so many copies."""
    scenario = load_scenario(ROOT / 'config' / 'asymmetric_hexagon.yaml')
    trajectory = plan_and_verify(scenario, PlanRequest(samples=1)).trajectory
    series = []
    for n in COPIES:
        made = build_perturbed_samples(scenario, n - 1, 1.0, 0)
        series.append(min(seconds(lambda: verify(trajectory, made), 3)))
    return _part('copies', COPIES, {'verification': series})


def suites() -> dict:
    """A suite of random polygons, each planned and tried once, with one process and with two."""
    rng = np.random.default_rng(0)
    tasks = [
        SuiteEntry(f'{k}', random_task(rng, int(rng.integers(4, 9)), f'{k}'))
        for k in range(max(SUITES))
    ]
    series = {}
    for cores in CORES:
        times = []
        for n in SUITES:
            began = time.perf_counter()
            run_suite(tasks[:n], QUICK, cores)
            times.append(time.perf_counter() - began)
        series[f'{cores} core{"s" if cores > 1 else ""}'] = times
    return _part('suites', SUITES, series)


def _gap_table_seconds(task) -> float:
    gaps, codes = gap_table(task.world, task.start)
    gaps, codes = np.empty(len(gaps)), np.empty(len(codes), dtype=np.int64)

    def many():
        for _ in range(200):
            geometry.gap_table(task.world, task.start, gaps, codes)

    many()
    return min(seconds(many, 3)) / 200


def _part(name, sizes, series) -> dict:
    return {
        'name': name,
        'sizes': list(sizes),
        'series': {k: [float(v) for v in values] for k, values in series.items()},
        'when': time.strftime('%Y-%m-%d %H:%M'),
        'load': os.getloadavg()[0],
    }


def exponent(sizes, values) -> float:
    """Slope of the line through the logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(values), 1)[0])


def show(parts: dict):
    """A table of exponents."""
    table = Table(
        *(
            Column(name, no_wrap=True)
            for name in ('what', 'against', 'from', 'to', 'first [s]', 'last [s]', 'exponent')
        ),
        box=None,
    )
    for name, part in parts.items():
        for series, values in part['series'].items():
            table.add_row(
                series,
                TITLES[name],
                str(part['sizes'][0]),
                str(part['sizes'][-1]),
                f'{values[0]:.3g}',
                f'{values[-1]:.3g}',
                f'{exponent(part["sizes"], values):.2f}',
            )
    out.print(table)


def draw(parts: dict):
    """A panel a part, both axes logarithmic."""
    figure = new_figure(4.1 * len(parts), 3.6, layout='constrained')
    for axes, (name, part) in zip(np.atleast_1d(figure.subplots(1, len(parts))), parts.items()):
        for (series, values), colour in zip(
            part['series'].items(), ('#1b3a5c', '#d62728', '#2f9e68')
        ):
            axes.loglog(
                part['sizes'],
                values,
                'o-',
                color=colour,
                markersize=4,
                label=f'{series}: exponent {exponent(part["sizes"], values):.2f}',
            )
        axes.set_xticks(part['sizes'], part['sizes'], fontsize=8)
        axes.minorticks_off()
        axes.set(xlabel=TITLES[name], ylabel='seconds')
        axes.grid(alpha=0.3)
        axes.legend(fontsize=7.5)
    return figure


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parts = {'vertices': vertices, 'copies': copies, 'suites': suites}
    parser.add_argument('--parts', nargs='*', choices=parts, default=list(parts))
    parser.add_argument('--json', type=Path, default=ROOT / 'docs' / 'growth.json')
    parser.add_argument('--out', type=Path, default=ROOT / 'docs' / 'images' / 'growth.png')
    options = parser.parse_args()
    known = json.loads(options.json.read_text()) if options.json.exists() else {}
    warm()
    for name in options.parts:
        out.print(f'measuring: {name} ...', style='dim')
        known[name] = parts[name]()
        options.json.write_text(json.dumps(known, indent=1) + '\n')
    known = {name: known[name] for name in parts if name in known}
    show(known)
    save(draw(known), options.out)


if __name__ == '__main__':
    main()
