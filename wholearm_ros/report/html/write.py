"""The one call behind `wholearm report`: whatever it is given, one HTML file."""

from collections.abc import Sequence
from pathlib import Path

from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.report.bag_run import RecordedRuns
from wholearm_ros.report.html.attempts_page import attempts_page
from wholearm_ros.report.html.plan_page import plan_page
from wholearm_ros.report.html.run_page import run_page
from wholearm_ros.report.html.suite_page import suite_page
from wholearm_ros.report.sources import Source, read_source


def write_report(sources: Sequence[Path], target: Path) -> Path:
    """Write the report of `sources` to `target`, which is returned.

    sources: one run, one plan, or results of a suite at several levels of perturbation. Raises
    WholeArmError when one cannot be read, they do not go together, or `target` cannot be written.
    """
    read = [read_source(path) for path in sources]
    suites = [r for r in read if isinstance(r, dict)]
    if len(read) > 1 and len(suites) < len(read):
        raise WholeArmError(
            'report: got several sources with a run or a plan among them; '
            'allowed: one run, one plan, or results of suites'
        )
    text = suite_page(suites) if suites else _page_of(read[0])
    try:
        target.write_text(text, encoding='utf-8')
    except OSError as error:
        raise WholeArmError(f'{target}: cannot be written: {error.strerror or error}') from error
    return target


def page_of_bag(recorded: RecordedRuns) -> str:
    """Of its run, or of all of them in a row."""
    return attempts_page(recorded) if recorded.several else run_page(*recorded.runs[-1])


def _page_of(source: Source) -> str:
    if isinstance(source, ContactPlan):
        return plan_page(source)
    if isinstance(source, RecordedRuns):
        return page_of_bag(source)
    assert isinstance(source, tuple)
    return run_page(*source)


def default_target(source: Path) -> Path:
    """report.html in the directory of a run, <name>.html beside anything else."""
    source = Path(source).absolute()
    if not source.is_dir():
        return source.with_suffix('.html')
    if not (source / 'metadata.yaml').exists():
        return source / 'report.html'
    return source.parent / f'{source.name}.html'
