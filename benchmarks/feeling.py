"""What the hand says against what is: suites, levels and numbers of attempts, as one table.

    python benchmarks/feeling.py [SUITE ...] [--levels 0 1 2 3] [--attempts 1 4] [--draws 5] [--jobs 2] [--seed 0]
                                 [--backend pybullet] [--json OUT]

A row: planned tasks, runs, the share at the goal, claims that are wrong either way, objects out of the hand, runs of which
nothing is claimed, wrong edges among those felt, and |felt x − true x| (median, 95 %).
"""

import argparse
import json
from pathlib import Path

import numpy as np

from wholearm_ros.suite.statistics import summarize
from wholearm_ros.suite.suite import run_suite
from wholearm_ros.suite.suite_file import load_suite
from wholearm_ros.suite.suite_options import SuiteOptions

HERE = Path(__file__).parent
HEADER = (
    '| suite | level | attempts | planned | runs | at the goal | false success | false failure | lost '
    '| unknown | wrong edge | x error, mm (median, p95) | attempts made |\n' + '|---' * 13 + '|'
)


def row(name: str, level: float, attempts: int, results: list) -> dict:
    """The figures of one suite at one level."""
    draws = [d for r in results for d in r['draws']]
    felt = [d for d in draws if d['felt_edge'] is not None and d['true_edge'] is not None]
    wrong = sum(d['true_edge'] not in d['felt_edges'] for d in felt)
    errors = [1e3 * abs(d['felt_x'] - d['true_x']) for d in felt if d['felt_x'] is not None]
    spread = np.percentile(errors, [50, 95]).round(2).tolist() if errors else [None, None]
    return {
        'suite': name,
        'level': level,
        'attempts': attempts,
        **summarize(results),
        'wrong_edge': wrong,
        'x_error_mm': spread,
        'attempts_made': float(np.mean([d['attempts'] for d in draws])) if draws else None,
    }


def line(r: dict) -> str:
    """A row as Markdown."""
    share = f'{r["sound"]:.3f}' if r['sound'] is not None else ''
    return (
        f'| {r["suite"]} | {r["level"]:g} | {r["attempts"]} | {r["planned"]} | {r["runs"]} | {share} '
        f'| {r["false_success"]} | {r["false_failure"]} | {r["lost"]} | {r["unknown"]} '
        f'| {r["wrong_edge"]} | {r["x_error_mm"][0]}, {r["x_error_mm"][1]} | {r["attempts_made"]:.2f} |'
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('suites', nargs='*', type=Path, default=[HERE / 'suite.json'])
    parser.add_argument('--levels', nargs='+', type=float, default=[0.0, 1.0, 2.0, 3.0])
    parser.add_argument('--attempts', nargs='+', type=int, default=[1, 4])
    parser.add_argument('--draws', type=int, default=5)
    parser.add_argument('--jobs', type=int, default=1)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--backend', default='pybullet')
    parser.add_argument('--json', type=Path)
    options = parser.parse_args()
    rows = []
    print(HEADER, flush=True)
    for suite in options.suites:
        tasks = load_suite(suite)
        for level in options.levels:
            for attempts in options.attempts:
                asked = SuiteOptions(
                    seed=options.seed,
                    perturb=level,
                    draws=options.draws,
                    attempts=attempts,
                    backend=options.backend,
                )
                rows.append(row(suite.stem, level, attempts, run_suite(tasks, asked, options.jobs)))
                print(line(rows[-1]), flush=True)
                if options.json:
                    options.json.write_text(json.dumps(rows, indent=1) + '\n')


if __name__ == '__main__':
    main()
