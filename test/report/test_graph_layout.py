"""The contact-state graph: nothing overlaps, the route is one red line, what is left out is counted."""

import numpy as np
import pytest

from wholearm_ros.model.plan import X_END, X_GOAL, X_INIT, X_START, ContactPlan, Subgoal, Y
from wholearm_ros.report.figures.canvas import svg_text
from wholearm_ros.report.figures.graph_figure import draw_graph
from wholearm_ros.report.figures.graph_layout import lay_out


def random_tree(scenario, size: int, seed: int) -> ContactPlan:
    """X_start → X_end → Y → X_start ..., with a route to the last X_start."""
    rng = np.random.default_rng(seed)
    q = np.array([0.0, 0.05, 0.0, 1.5, 1.7])
    subgoals = [Subgoal(1, X_INIT, q, ())]
    after = {X_INIT: X_START, Y: X_START, X_START: X_END, X_END: Y}
    for number in range(2, size + 1):
        free = [
            s
            for s in subgoals
            if s.kind in (X_INIT, Y) or all(o.parent != s.number for o in subgoals)
        ]
        parent = free[rng.integers(len(free))]
        subgoals.append(
            Subgoal(number, after[parent.kind], q, (), int(rng.choice([-1, 1])), parent.number)
        )
    path, parents = (
        [max(s.number for s in subgoals if s.kind == X_START)],
        {s.number: s.parent for s in subgoals},
    )
    while parents[path[0]] is not None:
        path.insert(0, parents[path[0]])
    last = path[-1]
    subgoals[last - 1] = Subgoal(last, X_GOAL, q, (), 1, parents[last])
    subgoals = [s for s in subgoals if s.parent != last]
    return ContactPlan(
        scenario,
        'random',
        0,
        'found',
        '',
        {},
        tuple(s for s in subgoals if _rooted(s, subgoals)),
        tuple(path),
    )


def _rooted(subgoal, subgoals):
    by_number = {s.number: s for s in subgoals}
    while subgoal is not None and subgoal.parent is not None:
        subgoal = by_number.get(subgoal.parent)
    return subgoal is not None


@pytest.mark.parametrize('size, seed', [(5, 0), (54, 1), (54, 2), (400, 3)])
def test_every_subgoal_is_drawn_once_or_counted(told, size, seed):
    plan = random_tree(told[0].scenario, size, seed)
    layout = lay_out(plan, limit=60)
    assert len(set(layout.cells.values())) == len(layout.cells) <= max(60, len(layout.route))
    assert len(layout.cells) + sum(layout.hidden.values()) + layout.merged == len(plan.subgoals)
    assert layout.route and all(layout.cells[n][1] == 0 for n in layout.route)
    columns = [layout.cells[n][0] for n in layout.route]
    assert columns == list(range(len(columns)))
    assert all(layout.cells[b][0] == layout.cells[a][0] + 1 for a, b, _ in layout.edges)
    assert sum(on_route for _, _, on_route in layout.edges) == len(layout.route) - 1


def test_the_ends_of_the_route_are_drawn(told):
    layout = lay_out(told[0])
    assert layout.route[0] == told[0].path[0] and layout.route[-1] == told[0].path[-1]


def test_the_same_plan_gives_the_same_drawing(told):
    assert svg_text(draw_graph(told[0])) == svg_text(draw_graph(told[0]))


def test_a_search_without_a_route_is_drawn_too(told):
    plan = random_tree(told[0].scenario, 30, 5)
    bare = ContactPlan(plan.scenario, 'best', 0, 'exhausted', 'none', {}, plan.subgoals)
    layout = lay_out(bare)
    assert layout.cells and not layout.route
    draw_graph(bare)
