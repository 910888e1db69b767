"""What a report can be made from: a bag, a run's directory, documents of runs, plans, suites."""

import json
from pathlib import Path
from typing import Any, Union

from wholearm_ros.errors import DocumentError, WholeArmError
from wholearm_ros.model.plan import FORMAT as PLAN_FORMAT
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.report.bag_run import RecordedRuns, Told, read_runs
from wholearm_ros.report.run_document import FORMAT as RUN_FORMAT
from wholearm_ros.report.run_document import read_run_document

SUITE_FORMAT = 'wholearm-suite-result/1'
MAX_BYTES = 200_000_000
Source = Union[Told, RecordedRuns, ContactPlan, dict[str, Any]]


def read_source(path: Path) -> Source:
    """(plan, trajectory, run), several of them with what the supervisor said, a plan alone, or the
    document of a suite's result.

    Raises a WholeArmError that says what is wrong.
    """
    path = Path(path)
    if not path.exists():
        raise WholeArmError(
            f'{path}: no such file or directory; allowed: a bag, the directory of a run, a '
            'document of `wholearm simulate --run`, `wholearm plan --json` or '
            '`wholearm suite --json`'
        )
    if path.is_dir() or path.suffix in ('.mcap', '.db3'):
        recorded = read_runs(_bag_of(path))
        return recorded if recorded.several else recorded.runs[-1]
    if path.stat().st_size > MAX_BYTES:
        raise DocumentError(f'{path}: {path.stat().st_size} bytes; allowed: at most {MAX_BYTES}')
    return _document(path)


def _bag_of(path: Path) -> Path:
    """A bag's own directory, or the one inside a run's directory."""
    if path.is_dir() and not (path / 'metadata.yaml').exists():
        bags = sorted(path.glob('*/metadata.yaml'))
        if len(bags) != 1:
            raise WholeArmError(
                f'{path}: {len(bags)} bags in it; '
                'allowed: a bag, or a directory with exactly one bag'
            )
        return bags[0].parent
    return path


def _document(path: Path) -> Source:
    try:
        text = path.read_text()
        kind = json.loads(text).get('format')
    except (OSError, ValueError, AttributeError, RecursionError) as error:
        raise DocumentError(f'{path}: neither a bag nor a JSON document: {error}') from error
    if kind == SUITE_FORMAT:
        return dict(json.loads(text))
    if kind == RUN_FORMAT:
        return read_run_document(text)
    if kind == PLAN_FORMAT:
        return ContactPlan.from_json(text)
    raise DocumentError(
        f'{path}: format is {kind!r}; allowed: {RUN_FORMAT!r} (`wholearm simulate --run`), '
        f'{SUITE_FORMAT!r} (`wholearm suite --json`), {PLAN_FORMAT!r} (`wholearm plan --json`), '
        'or a bag'
    )
