"""All figures of one run, as files."""

from pathlib import Path

from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.report.figures.animation import write_animation
from wholearm_ros.report.figures.canvas import save
from wholearm_ros.report.figures.film_strip import draw_film
from wholearm_ros.report.figures.graph_figure import draw_graph
from wholearm_ros.report.figures.search_figure import draw_search
from wholearm_ros.report.figures.time_figure import draw_times
from wholearm_ros.report.run_view import RunView


def write_search_figures(directory: Path, plan: ContactPlan) -> list[Path]:
    """What the search of a plan, found or not, reached; the paths of what was written."""
    directory = Path(directory)
    written = [save(draw_search(plan), directory / 'search.png')]
    if plan.subgoals:
        written.append(save(draw_graph(plan), directory / 'contact_states.png'))
    return written


def write_figures(
    directory: Path, plan: ContactPlan, trajectory: ManipulationTrajectory, run: RunView
) -> list[Path]:
    """The paper's Figures 6, 7 and 8 of this run and an animation; the paths of the files."""
    directory = Path(directory)
    written = [
        save(draw_graph(plan), directory / 'contact_states.png'),
        save(draw_times(trajectory, run, plan.scenario.name), directory / 'torque_and_angle.png'),
        save(draw_film(plan, trajectory, run), directory / 'film_strip.png'),
    ]
    return [*written, write_animation(directory / 'animation.gif', plan, trajectory, run)]
