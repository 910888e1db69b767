"""Everything that is measured for speed, in one go: kernels, a suite, fresh processes, the planner node.

    python benchmarks/bench.py [--suite FILE] [--parts kernels suite process node] [--cold] [--make-run] [--json OUT]
    python benchmarks/bench.py --compare A.json B.json

Writes a JSON document `wholearm-bench/1` and prints a table. Kernels have a plain NumPy twin that is timed in the same run:
the ratio means something on any machine. `process` and `node` begin with compiled kernels on disk; --cold also with none.
"""

import argparse
import json
import os
import platform
import sys
import tempfile
import time
from pathlib import Path

from bench_kernels import bench_kernels
from bench_processes import bench_fresh_process, bench_make_run, bench_planner_node
from bench_suite import bench_suite
from rich.console import Console
from rich.table import Column, Table

from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.report.versions import versions
from wholearm_ros.suite.suite_file import load_suite

FORMAT = 'wholearm-bench/1'
HERE = Path(__file__).parent
SCENARIOS = [
    HERE.parent / 'config' / f'{name}.yaml' for name in ('asymmetric_hexagon', 'regular_hexagon')
]
PARTS = ('kernels', 'suite', 'process', 'node')
out = Console(highlight=False, width=None if sys.stdout.isatty() else 120)


def measure(options):
    """(name of the part, its rows), one part after the other."""
    repeats, tasks = 1 if options.quick else 3, load_suite(options.suite)[: options.tasks]
    parts = {
        'kernels': lambda: bench_kernels(
            load_scenario(SCENARIOS[0]), *((20, 2) if options.quick else ())
        ),
        'suite': lambda: bench_suite(tasks, repeats),
        'process': lambda: _named('process.warm', bench_fresh_process(SCENARIOS[0])),
        'node': lambda: bench_planner_node(
            SCENARIOS[:1] if options.quick else SCENARIOS, 3 if options.quick else 8
        ),
        'process without compiled kernels': lambda: _named(
            'process.cold', _in_empty_cache(bench_fresh_process, SCENARIOS[0])
        ),
        'node without compiled kernels': lambda: _named(
            'cold', _in_empty_cache(bench_planner_node, SCENARIOS[:1], 0)
        ),
        'make run': bench_make_run,
    }
    cold = list(parts)[4:6] if options.cold else []
    for name in (*options.parts, *cold, *(['make run'] if options.make_run else [])):
        out.print(f'measuring: {name} ...', style='dim')
        yield name, parts[name]()


def _in_empty_cache(work, *arguments) -> dict:
    """With a directory for compiled kernels in which there are none: minutes."""
    with tempfile.TemporaryDirectory() as empty:
        return work(*arguments, empty)


def document(rows: dict, options) -> dict:
    """`wholearm-bench/1`."""
    return {
        'format': FORMAT,
        'when': time.strftime('%Y-%m-%d %H:%M:%S'),
        'suite': options.suite.name,
        'tasks': options.tasks,
        'machine': {
            'processor': platform.processor() or platform.machine(),
            'cores': os.cpu_count(),
            'load': os.getloadavg()[0],
        },
        'versions': versions(),
        'rows': rows,
    }


def show(result: dict):
    """The table."""
    table = Table(
        Column('what', no_wrap=True),
        'median',
        'p95',
        'unit',
        'of',
        'plain NumPy',
        'ratio',
        box=None,
    )
    for name, r in result['rows'].items():
        plain = ('', '') if 'ratio' not in r else (f'{r["plain"]:.4g}', f'{r["ratio"]:.0f} x')
        table.add_row(name, f'{r["median"]:.4g}', f'{r["p95"]:.4g}', r['unit'], str(r['n']), *plain)
    out.print(table)


def compare(paths):
    """Medians of two results, and the second over the first."""
    a, b = (_read(path) for path in paths)
    table = Table(
        Column('what', no_wrap=True), paths[0].stem, paths[1].stem, 'unit', 'B / A', box=None
    )
    for name in (n for n in a['rows'] if n in b['rows']):
        first, second = a['rows'][name]['median'], b['rows'][name]['median']
        table.add_row(
            name,
            f'{first:.4g}',
            f'{second:.4g}',
            a['rows'][name]['unit'],
            f'{second / first:.2f}' if first else '',
        )
    out.print(table)
    for name in sorted(set(a['rows']) ^ set(b['rows'])):
        out.print(f'only in one of them: {name}')


def _named(prefix: str, rows: dict) -> dict:
    return {f'{prefix}.{name}': r for name, r in rows.items()}


def _read(path: Path) -> dict:
    result = json.loads(path.read_text())
    if result.get('format') != FORMAT:
        sys.exit(f'{path}: format: got {result.get("format")!r}; allowed: {FORMAT!r}')
    return result


def arguments(given=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--suite', type=Path, default=HERE / 'suite.json')
    parser.add_argument(
        '--tasks', type=int, metavar='N', help='only the first N tasks of the suite'
    )
    parser.add_argument('--parts', nargs='*', choices=PARTS, default=PARTS)
    parser.add_argument('--cold', action='store_true', help='also without compiled kernels on disk')
    parser.add_argument('--make-run', action='store_true', help='also `make run`')
    parser.add_argument('--quick', action='store_true', help='few repeats, to see that it works')
    parser.add_argument(
        '--json', type=Path, metavar='OUT', default=HERE.parent / 'build' / 'bench.json'
    )
    parser.add_argument('--compare', nargs=2, type=Path, metavar=('A', 'B'))
    return parser.parse_args(given)


def main():
    options = arguments()
    if options.compare:
        return compare(options.compare)
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    options.json.parent.mkdir(parents=True, exist_ok=True)
    rows = {}
    for _, more in measure(options):
        rows |= more
        options.json.write_text(
            json.dumps(document(rows, options), indent=1) + '\n'
        )  # what is done is kept
    show(document(rows, options))
    out.print(f'written: {options.json}', soft_wrap=True)


if __name__ == '__main__':
    main()
