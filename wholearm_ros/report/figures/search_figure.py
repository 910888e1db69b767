"""What a search reached: the start, every place where it had the object, and what stopped it."""

import textwrap

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from wholearm_ros.errors import WholeArmError
from wholearm_ros.mechanics.contacts import start_configuration
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.goal import goal_region
from wholearm_ros.model.orientation import start_rotation
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.report.figures.canvas import new_figure
from wholearm_ros.report.figures.outlines import hand_outlines, object_outline, view_box
from wholearm_ros.report.figures.palette import (
    INK,
    OBJECT,
    OBJECT_EDGE,
    PALM,
    PLANNED,
    SIDE_COLOURS,
)

WIDTH, TEXT, KEY = 6.5, 1.1, 0.25  # [inch] of the figure; above the drawing, with words or without
COLUMNS = 95  # of the reason
REACHED = '#9a9a9a'
NOWHERE = readonly(np.empty((0, 3)))


def draw_search(plan: ContactPlan) -> Figure:
    """The scenario of a plan, found or not, with all its subgoals."""
    reached = np.array([s.configuration[:3] for s in plan.subgoals]).reshape(-1, 3)
    words = 'plan found' if plan.found else f'no plan ({plan.outcome})'
    return draw_reached(plan.scenario, f'{words}: {plan.reason}', reached)


def draw_reached(scenario: Scenario, words: str, reached: np.ndarray = NOWHERE) -> Figure:
    """The start filled, the goal's rotation dashed, the object at `reached` (k, 3) thin."""
    q = _start(scenario)
    poses = np.vstack([q[None, :3], reached])
    goal = _goal_pose(scenario, poses)
    box = view_box(scenario, np.vstack([poses, goal]), q[None, 3:])
    height = WIDTH * (box[3] - box[2]) / (box[1] - box[0])
    above = TEXT if words else KEY
    figure = new_figure(WIDTH, height + above)
    share = height / (height + above)
    axes = figure.add_axes((0, 0, 1, share), xlim=box[:2], ylim=box[2:], aspect='equal')
    axes.axis('off')
    thin = [object_outline(scenario, pose) for pose in poses[1:]]
    axes.add_collection(PolyCollection(thin, facecolors='none', edgecolors=REACHED, linewidths=0.5))
    axes.add_collection(LineCollection([scenario.palm.vertices], colors=PALM, linewidths=3.0))
    fingers = hand_outlines(scenario, q[3:])
    colours = [colour + '66' for colour in SIDE_COLOURS]
    axes.add_collection(PolyCollection(fingers, facecolors=colours, edgecolors=SIDE_COLOURS))
    start, end = object_outline(scenario, q[:3]), object_outline(scenario, goal)
    axes.add_collection(PolyCollection([start], facecolors=OBJECT, edgecolors=OBJECT_EDGE))
    dashed = PolyCollection([end], facecolors='none', edgecolors=PLANNED, linestyles='--')
    axes.add_collection(dashed)
    text = textwrap.fill(words, COLUMNS, max_lines=4)
    top = 1 - 0.12 / (height + above)
    figure.text(0.02, top, text, fontsize=8.5, color=INK, va='top')
    key = 'filled: start    dashed: goal'
    if len(poses) > 1:
        key += '    thin: where the search has had the object'
    figure.text(0.02, share, key, fontsize=7.5, color=INK)
    return figure


def _start(scenario: Scenario) -> np.ndarray:
    """(5,): as it is set down; fingers upright where they do not reach the object."""
    try:
        return start_configuration(scenario)
    except WholeArmError:
        x = getattr(scenario.start, 'x', 0.0)
        return np.array([x, 0.1, start_rotation(scenario), 2.0, 1.1])


def _goal_pose(scenario: Scenario, poses: np.ndarray) -> np.ndarray:
    """(3,): the goal; where it names no x or y, the start's x and on the palm."""
    goal = goal_region(scenario)
    pose = np.where(np.isfinite(goal.target), goal.target, poses[0])
    if goal.on_palm:
        pose[1] -= goal.height(pose)
    return pose
