"""Figures and the report of a recorded run."""

from pathlib import Path

from wholearm_ros.report.bag_run import read_bag
from wholearm_ros.report.figures.figures import write_figures
from wholearm_ros.report.html.run_page import run_page


def figures_of(bag_path: Path, directory: Path) -> list[Path]:
    """Draws the last run in the bag and writes its report; the paths of what was written."""
    told = read_bag(bag_path)
    written = write_figures(directory, *told)
    report = directory / 'report.html'
    report.write_text(run_page(*told), encoding='utf-8')
    return [*written, report]
