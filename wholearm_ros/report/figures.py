"""All figures of one run, as files."""
from pathlib import Path
from typing import List

from ..model.plan import ContactPlan
from ..model.trajectory import ManipulationTrajectory
from .animation import write_animation
from .canvas import save
from .film_strip import draw_film
from .graph_figure import draw_graph
from .run_view import RunView
from .time_figure import draw_times


def write_figures(directory: Path, plan: ContactPlan, trajectory: ManipulationTrajectory, run: RunView) -> List[Path]:
    """The paper's Figures 6, 7 and 8 of this run and an animation; the paths of what was written."""
    directory = Path(directory)
    written = [save(draw_graph(plan), directory / 'contact_states.png'),
               save(draw_times(trajectory, run, plan.scenario.name), directory / 'torque_and_angle.png'),
               save(draw_film(plan, trajectory, run), directory / 'film_strip.png')]
    return [*written, write_animation(directory / 'animation.gif', plan, trajectory, run)]
