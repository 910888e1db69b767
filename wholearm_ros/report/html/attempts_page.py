"""The report of several attempts at one goal, in a row: each has the page of its own run."""

from html import escape
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from wholearm_ros.model.outcomes import SUCCEEDED, UNKNOWN
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import CCW, CW, GoalOnEdge, StartOnEdge
from wholearm_ros.planner.face_map import Turn
from wholearm_ros.report.bag_run import RecordedRuns, Told
from wholearm_ros.report.figures.map_figure import draw_route
from wholearm_ros.report.html.figure import figure_in_page
from wholearm_ros.report.html.page import asset, page
from wholearm_ros.report.html.run_page import run_page
from wholearm_ros.report.html.scene import numbers, scene


def attempts_page(recorded: RecordedRuns) -> str:
    """HTML: what came of each motion, with the picture of its end, and the run that is chosen."""
    name = recorded.runs[-1][0].scenario.name or 'run'
    body = asset('attempts.html')
    for key, value in (
        ('title', escape(name)),
        ('verdict', _verdict(recorded)),
        ('attempts', ''.join(_choices(recorded))),
        ('route', figure_in_page(_route(recorded))),
    ):
        body = body.replace('{{' + key + '}}', value)
    data = {
        'pages': [run_page(*told) for told in recorded.runs],
        'ends': [_end(told) for told in recorded.runs],
    }
    return page(f'{name}: attempts', body, data, 'attempts.js', plots=False)


def _route(recorded: RecordedRuns) -> Figure:
    """The turns of the runs, over those of the map."""
    polygon = recorded.runs[-1][0].scenario.object.polygon
    turns = [turn_of(plan) for plan, _, _ in recorded.runs]
    known: dict[Turn, float] = {}
    for edge in recorded.face_map.get('edges', []):
        if edge['direction']:
            turn = Turn(edge['from']['edge'], edge['to']['edge'], edge['direction'])
            known[turn] = max(known.get(turn, 0.0), edge['survived'] / edge['samples'])
    return draw_route(polygon, known, [turn for turn in turns if turn is not None])


def turn_of(plan: ContactPlan) -> Turn | None:
    """From which face to which a plan leads; None for a slide, or where it is not between faces."""
    start, goal = plan.scenario.start, plan.scenario.goal
    if not isinstance(start, StartOnEdge) or not isinstance(goal, GoalOnEdge):
        return None
    if start.edge == goal.edge:
        return None
    path = plan.object_path()
    return Turn(start.edge, goal.edge, CCW if path[-1, 2] > path[0, 2] else CW)


def _choices(recorded: RecordedRuns) -> list[str]:
    """A button a motion, in order. The last runs of the bag are the motions that had a plan."""
    planned = sum(bool(motion.get('planned')) for motion in recorded.motions)
    place = len(recorded.runs) - planned
    choices = [_choice(k, _before(k, recorded.runs[k]), '') for k in range(place)]
    for number, motion in enumerate(recorded.motions, 1):
        has_run = bool(motion.get('planned'))
        shown = place if has_run and place >= 0 else None
        choices.append(_choice(shown, f'{number}. {_aim(motion)}', _said(motion)))
        place += has_run
    return choices


def _before(place: int, told: Told) -> str:
    """The run of an earlier goal."""
    goal = told[0].scenario.goal
    return f'run {place + 1}' + (f': to edge {goal.edge}' if isinstance(goal, GoalOnEdge) else '')


def _choice(place: int | None, title: str, said: str) -> str:
    """place: among the runs, None when there is none to be shown."""
    number = '' if place is None else place
    picture = '' if place is None else '<svg aria-hidden="true"></svg>'
    return (
        f'<button type="button" data-page="{number}" aria-pressed="false">{picture}'
        f'<b>{escape(title)}</b><small>{escape(said)}</small></button>'
    )


def _end(told: Told) -> dict[str, Any]:
    """Hand and object at the end of a run; the object where it truly is, else where it was felt."""
    plan, _, run = told
    poses = (
        run.poses if np.isfinite(run.poses[-1]).all() or run.estimates is None else run.estimates
    )
    return {
        'scene': scene(plan.scenario, run.poses[-1:], run.angles[-1:]),
        'pose': numbers(poses[-1] * [1e3, 1e3, 180.0 / np.pi], 2)
        if np.isfinite(poses[-1]).all()
        else None,
        'angles': numbers(np.degrees(run.angles[-1]), 2),
    }


def _aim(motion: dict[str, Any]) -> str:
    if not motion.get('planned'):
        return 'felt again'
    stop = motion.get('stop', '')
    return 'to the goal' if stop == '' else f'to edge {stop}, on the way'


def _said(motion: dict[str, Any]) -> str:
    return f'{motion.get("claimed") or motion.get("outcome", "")}: {motion.get("reason", "")}'


def _verdict(recorded: RecordedRuns) -> str:
    if not recorded.motions:
        return f'<p class="verdict unknown">{len(recorded.runs)} runs, without a supervisor</p>'
    last = recorded.motions[-1]
    attempts = sum(bool(motion.get('planned')) for motion in recorded.motions)
    count = f'{attempts} attempt' + ('' if attempts == 1 else 's')
    kind, said = 'bad', 'not at the goal'
    if last.get('outcome') == SUCCEEDED:
        kind, said = 'good', 'felt at the goal'
    elif last.get('claimed') == UNKNOWN:
        kind, said = 'unknown', 'not known whether it is at the goal'
    return f'<p class="verdict {kind}">{said} after {count}</p>'
