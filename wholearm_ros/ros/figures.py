"""Figures of a recorded run."""
from pathlib import Path
from typing import List

from ..control.setpoints import ControlOptions
from ..errors import BagError
from ..model.plan import ContactPlan
from ..model.trajectory import ManipulationTrajectory
from ..report.run_figure import MeasuredRun, draw_run, save
from .bag_reader import Bag, stamp_of
from .messages import NANOSECONDS

MARGIN = 0.2  # [s] shown before and after the run


def figures_of(bag_path: Path, directory: Path) -> List[Path]:
    """Draws the last run in the bag; the paths of what was written."""
    with Bag(bag_path) as bag:
        trajectories = bag.documents('manipulation_trajectory')
        setpoints = [stamp_of(m) for m in bag.messages('velocity_setpoint')]
        if not trajectories or not setpoints:
            raise BagError(f'{bag_path}: holds no run; allowed: a bag recorded while a trajectory was executed')
        trajectory = ManipulationTrajectory.from_json(trajectories[-1])
        plans = [ContactPlan.from_json(text) for text in bag.documents('contact_plan')]
        times, joints = bag.joint_table('joint_states')
        pose_times, poses = bag.pose_table()
    began, ended = setpoints[0] / NANOSECONDS, setpoints[-1] / NANOSECONDS
    shown, poses_shown = _within(times, began, ended), _within(pose_times, began, ended)
    run = MeasuredRun(times[shown] - began, joints[shown], pose_times[poses_shown] - began, poses[poses_shown])
    name = next((p.scenario.name for p in plans if p.id == trajectory.plan_id), '') or 'run'
    figure = draw_run(trajectory, run, ControlOptions().ramp, name)
    return [save(figure, directory / f'{name}.png')]


def _within(times, began, ended):
    return (times >= began - MARGIN) & (times <= ended + MARGIN)
