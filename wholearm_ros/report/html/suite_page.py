"""The report of a suite: what became of each task, times, success against perturbation."""

from html import escape
from typing import Any

import numpy as np

from wholearm_ros.errors import DocumentError
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.report.figures.palette import MODE_COLOURS, MODE_NAMES
from wholearm_ros.report.html.page import asset, page, table
from wholearm_ros.report.html.scene import numbers, scene

KINDS = {
    'executed': 'executed',
    'partly': 'executed in some draws',
    'failed': 'planned, not executed',
    'unplanned': 'no plan',
    'error': 'error',
}


def suite_page(documents: list[dict[str, Any]]) -> str:
    """documents: `wholearm-suite-result/1`, the first in the grid; several give success against
    their perturbation. Raises DocumentError when one is damaged.
    """
    try:
        first = documents[0]
        data = {
            'tasks': [_task(t) for t in first['tasks']],
            'kinds': KINDS,
            'colours': MODE_COLOURS,
            'names': MODE_NAMES,
            'levels': sorted((_level(d) for d in documents), key=lambda level: level['level']),
        }
        body = asset('suite.html').replace(
            '{{title}}', escape(str(first['suite']).rsplit('/', 1)[-1])
        )
        body = body.replace('{{jury}}', _jury(first['summary'].get('jury')))
        body = body.replace('{{summary}}', _summary(first)).replace(
            '{{options}}', _options(documents)
        )
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise DocumentError(f'suite result is damaged: {type(error).__name__}: {error}') from error
    return page(f'Suite {first["suite"]}', body, data, 'suite.js')


def success_interval(done: int, runs: int) -> tuple[float, float]:
    """95 % Wilson interval of a share."""
    z, n = 1.96, max(runs, 1)
    middle = (done / n + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * float(np.sqrt(done / n * (1 - done / n) / n + z * z / (4 * n * n)))
    return middle - half, middle + half


def _kind(task: dict[str, Any]) -> str:
    if 'error' in task:
        return 'error'
    if not task['planned']:
        return 'unplanned'
    if task['executed']:
        return 'executed'
    return 'partly' if any(d['executed'] for d in task['draws']) else 'failed'


def _task(task: dict[str, Any]) -> dict[str, Any]:
    kept = {
        name: task.get(name)
        for name in (
            'name',
            'reason',
            'plan_ms',
            'generate_ms',
            'verify_ms',
            'subgoals',
            'path_length',
            'modes',
            'final_pose',
            'draws',
            'error',
        )
    }
    return {**kept, 'kind': _kind(task), 'run': _run(task), 'shape': _shape(task)}


def _shape(task: dict[str, Any]) -> Any:
    """The object's outline as it lies at the start (n, 2) [mm]; None in a result without it."""
    if 'scenario' not in task:
        return None
    vertices, start = np.array(task['scenario']['object']['vertices']), task['scenario']['start']
    if 'pose' in start:
        turn = start['pose'][2]
    else:
        k = start.get('edge', 0)
        along = vertices[(k + 1) % len(vertices)] - vertices[k]
        turn = -np.arctan2(along[1], along[0])
    c, s = np.cos(turn), np.sin(turn)
    return numbers(1e3 * vertices @ np.array([[c, s], [-s, c]]), 1)


def _run(task: dict[str, Any]) -> dict[str, Any] | None:
    """What the page needs to show the first run; None when there was none, or a result of before
    this was kept.
    """
    if not task.get('motion') or 'scenario' not in task:
        return None
    rows = np.array(task['motion']['rows'])
    drawn = scene(parse_scenario(task['scenario'], task['name']), rows[:, :3], rows[:, 3:])
    return {
        'scene': drawn,
        'period': task['motion']['period'],
        'modes': task['motion']['modes'],
        'pose': numbers(rows[:, :3] * [1e3, 1e3, 180.0 / np.pi], 2),
        'angles': numbers(np.degrees(rows[:, 3:]), 2),
    }


def _level(document: dict[str, Any]) -> dict[str, Any]:
    summary = document['summary']
    done, runs = summary['executed_runs'], summary['runs']
    low, high = success_interval(done, runs)
    return {
        'level': document['perturb'],
        'done': done,
        'runs': runs,
        'share': done / runs if runs else None,
        'low': low,
        'high': high,
        'planned': summary['planned'],
        'tasks': summary['tasks'],
    }


def _summary(document: dict[str, Any]) -> str:
    s = document['summary']
    sound = (
        'nothing was planned'
        if s['sound'] is None
        else f'{s["executed_runs"]} of {s["runs"]} runs of planned tasks reach the goal'
    )
    return escape(
        f'{s["tasks"]} tasks: {s["planned"]} planned, {s["executed"]} executed; {sound}; '
        f'{s["errors"]} errors.'
    )


def _jury(summary: dict[str, Any] | None) -> str:
    """Engines against each other, when there were several; empty else."""
    if not summary:
        return ''
    runs = summary['runs']
    engines = [[name, f'{n} of {runs}'] for name, n in summary['executed'].items()]
    pairs = [[' and '.join(p['engines']), f'{p["runs"]} of {runs}'] for p in summary['agreement']]
    found = [[d['task'], d['draw'], d['text']] for d in summary['disagreements']]
    return (
        '<section class="wide"><h2>Jury of engines</h2>'
        + table(['engine', 'runs at the goal'], engines)
        + table(['engines', 'runs in agreement'], pairs)
        + (
            table(['task', 'draw', 'disagreement, and the first contact that differs'], found)
            if found
            else ''
        )
        + '</section>'
    )


def _options(documents: list[dict[str, Any]]) -> str:
    names = ('suite', 'seed', 'perturb', 'draws', 'search', 'transition', 'backend', 'rate')
    rows = [
        [str(d[name]).rsplit('/', 1)[-1] if name == 'suite' else d[name] for name in names]
        for d in documents
    ]
    return table(names, rows, 'long')
