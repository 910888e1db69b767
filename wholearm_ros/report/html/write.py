"""The one call behind `wholearm report`: whatever it is given, one HTML file."""

from collections.abc import Sequence
from pathlib import Path

from wholearm_ros.errors import WholeArmError
from wholearm_ros.report.html.run_page import run_page
from wholearm_ros.report.html.suite_page import suite_page
from wholearm_ros.report.sources import read_source


def write_report(sources: Sequence[Path], target: Path) -> Path:
    """sources: one run, or results of a suite at several levels of perturbation. Returns `target`."""
    read = [read_source(path) for path in sources]
    suites = [r for r in read if isinstance(r, dict)]
    if len(read) > 1 and len(suites) < len(read):
        raise WholeArmError(
            'report: got several sources with a run among them; allowed: one run, or results of suites'
        )
    text = suite_page(suites) if suites else run_page(*read[0])
    try:
        target.write_text(text, encoding='utf-8')
    except OSError as error:
        raise WholeArmError(f'{target}: cannot be written: {error.strerror or error}') from error
    return target


def default_target(source: Path) -> Path:
    """report.html in the directory of a run, <name>.html beside anything else."""
    source = Path(source).absolute()
    if not source.is_dir():
        return source.with_suffix('.html')
    if not (source / 'metadata.yaml').exists():
        return source / 'report.html'
    return source.parent / f'{source.name}.html'
