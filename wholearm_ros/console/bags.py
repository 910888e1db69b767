"""The bags there are, and a run of one of them as the report draws it."""

from pathlib import Path
from typing import Any

from wholearm_ros.bag.reader import NANOSECONDS
from wholearm_ros.console.recording import BAG
from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.yaml_text import read_mapping

MOST = 200  # bags that are listed, the newest


def listed(runs: Path) -> list[dict[str, Any]]:
    """Newest first: name (its directory in `runs`), length [s] and size [bytes]."""
    return [_described(name, path) for name, path in list(_bags(runs).items())[:MOST]]


def replay(runs: Path, name: str) -> dict[str, Any]:
    """The last run in a bag, what the report's animation is given. Raises WholeArmError."""
    from wholearm_ros.report.bag_run import read_bag  # with matplotlib, only when it is asked for
    from wholearm_ros.report.html.run_data import run_data

    return run_data(*read_bag(_bag(runs, name)))


def report(runs: Path, name: str) -> str:
    """The report of a bag, all its attempts in a row, as HTML. Raises WholeArmError."""
    from wholearm_ros.report.bag_run import read_runs
    from wholearm_ros.report.html.write import page_of_bag

    return page_of_bag(read_runs(_bag(runs, name)))


def _bags(runs: Path) -> dict[str, Path]:
    """By the name of the run's directory, which is its date, or of the bag's own."""
    found = {p.parent.parent.name: p.parent for p in runs.glob(f'*/{BAG}/metadata.yaml')}
    found |= {p.parent.name: p.parent for p in runs.glob('*/metadata.yaml')}
    return dict(sorted(found.items(), reverse=True))


def _bag(runs: Path, name: str) -> Path:
    found = _bags(runs)
    if name not in found:
        raise WholeArmError(f'bag {name}: not there; allowed: one of {len(found)} in {runs}')
    return found[name]


def _described(name: str, path: Path) -> dict[str, Any]:
    size = sum(file.stat().st_size for file in path.iterdir() if file.is_file())
    try:
        told = read_mapping(path / 'metadata.yaml')['rosbag2_bagfile_information']
        seconds: float | None = round(told['duration']['nanoseconds'] / NANOSECONDS, 1)
    except (WholeArmError, KeyError, TypeError):
        seconds = None  # the report says what is wrong with it
    return {'name': name, 'seconds': seconds, 'bytes': size}
