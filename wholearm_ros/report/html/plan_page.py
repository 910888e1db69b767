"""The report of a plan that nobody has executed, or of a search that found none."""

import json
from html import escape

from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario_file import scenario_to_dict
from wholearm_ros.report.figures.graph_figure import draw_graph
from wholearm_ros.report.figures.search_figure import draw_search
from wholearm_ros.report.html.figure import figure_in_page
from wholearm_ros.report.html.page import asset, facts, still_page
from wholearm_ros.report.versions import versions


def plan_page(plan: ContactPlan) -> str:
    """HTML: the verdict, what was reached, the contact states, the figures of the search."""
    name = plan.scenario.name or 'plan'
    graph = figure_in_page(draw_graph(plan)) if plan.subgoals else '<p>None was reached.</p>'
    body = asset('plan.html')
    for key, value in (
        ('title', escape(name)),
        ('verdict', _verdict(plan)),
        ('picture', figure_in_page(draw_search(plan))),
        ('graph', graph),
        ('facts', _facts(plan)),
        ('scenario', escape(json.dumps(scenario_to_dict(plan.scenario), indent=1))),
    ):
        body = body.replace('{{' + key + '}}', value)
    return still_page(f'{name}: plan', body)


def _verdict(plan: ContactPlan) -> str:
    if plan.found:
        return f'<p class="verdict good">plan found, not executed: {escape(plan.reason)}</p>'
    return f'<p class="verdict bad">no plan ({plan.outcome}): {escape(plan.reason)}</p>'


def _facts(plan: ContactPlan) -> str:
    told = {'plan': plan.id, 'search': plan.search, 'seed': plan.seed}
    told |= {name.replace('_', ' '): value for name, value in plan.counts.items()}
    if plan.certificate:
        told['certificate'] = str(plan.certificate)
    told['report made with'] = ', '.join(f'{k} {v}' for k, v in versions().items())
    return facts(told)
