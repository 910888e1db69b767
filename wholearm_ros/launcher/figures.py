"""Figures and the report of a recorded run, or of one that had no plan."""

from pathlib import Path

from wholearm_ros.model.scenario import Scenario
from wholearm_ros.report.bag_run import read_runs
from wholearm_ros.report.figures.canvas import save
from wholearm_ros.report.figures.figures import write_figures
from wholearm_ros.report.figures.search_figure import draw_reached
from wholearm_ros.report.html.write import page_of_bag


def figures_of(bag_path: Path, directory: Path) -> list[Path]:
    """Draws the last run in the bag and writes the report of all; the paths of what was written."""
    recorded = read_runs(bag_path)
    written = write_figures(directory, *recorded.runs[-1])
    report = directory / 'report.html'
    report.write_text(page_of_bag(recorded), encoding='utf-8')
    return [*written, report]


def figures_without_a_plan(scenario: Scenario, reason: str, directory: Path) -> list[Path]:
    """The scenario and why there is no plan; the paths of what was written."""
    return [save(draw_reached(scenario, reason), directory / 'search.png')]
