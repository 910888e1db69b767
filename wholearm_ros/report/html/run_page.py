"""The report of one run."""

import json
from html import escape

from wholearm_ros.model.hand import SIDES
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario_file import scenario_to_dict
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.report.figures.graph_figure import draw_graph
from wholearm_ros.report.figures.palette import MODE_COLOURS, MODE_NAMES
from wholearm_ros.report.html.figure import figure_in_page
from wholearm_ros.report.html.page import asset, facts, page, raw, table
from wholearm_ros.report.html.run_data import run_data
from wholearm_ros.report.run_view import RunView, errors
from wholearm_ros.report.versions import versions


def run_page(plan: ContactPlan, trajectory: ManipulationTrajectory, run: RunView) -> str:
    """HTML: animation with a slider, torque and angle plots, contact-state graph, modes, errors,
    timings, scenario.
    """
    name = plan.scenario.name or 'run'
    body = asset('run.html')
    for key, value in (
        ('title', escape(name)),
        ('verdict', _verdict(run)),
        ('summary', _summary(plan, trajectory, run)),
        ('graph', figure_in_page(draw_graph(plan))),
        ('modes', _modes(trajectory)),
        ('errors', _errors(trajectory, run)),
        ('facts', _facts(plan, trajectory, run)),
        ('transitions', _transitions(trajectory)),
        ('scenario', _scenario(plan)),
    ):
        body = body.replace('{{' + key + '}}', value)
    return page(f'{name}: whole-arm manipulation', body, run_data(plan, trajectory, run), 'run.js')


def _verdict(run: RunView) -> str:
    if run.judged is None:
        return '<p class="verdict unknown">the truth about the object is not in this recording</p>'
    if run.judged.executed:
        return '<p class="verdict good">the object rests on its goal</p>'
    return f'<p class="verdict bad">not at the goal: {escape(run.judged.reason)}</p>'


def _summary(plan: ContactPlan, trajectory: ManipulationTrajectory, run: RunView) -> str:
    seconds = ', '.join(
        f'{MODE_NAMES[mode]} {value:.2f} s'
        for mode, value in trajectory.time_in_modes().items()
        if value
    )
    told = f'{trajectory.duration:.2f} s along {len(plan.path)} subgoals: {seconds}.'
    if run.judged is not None:
        told += (
            f' At the end {run.judged.angle_error:+.4f} rad from the goal '
            f'and {abs(1e3 * run.judged.gap):.2f} mm '
            f'{"above" if run.judged.gap > 0 else "into"} the palm.'
        )
    return escape(told)


def _modes(trajectory: ManipulationTrajectory) -> str:
    rows = []
    for s in trajectory.segments:
        chip = raw(
            f'<button type="button" class="chip" data-time="{s.start:.4f}" '
            f'style="background:{MODE_COLOURS[s.mode]}">{MODE_NAMES[s.mode]}</button>'
        )
        rows.append(
            [
                f'{s.start:.2f}',
                f'{s.end:.2f}',
                f'{s.end - s.start:.2f}',
                chip,
                SIDES[s.velocity_finger],
                SIDES[s.torque_finger],
                ', '.join(s.contacts),
            ]
        )
    return table(
        ['from [s]', 'to [s]', 'for [s]', 'mode', 'velocity finger', 'torque finger', 'contacts'],
        rows,
        'long',
    )


def _transitions(trajectory: ManipulationTrajectory) -> str:
    rows = []
    for t in trajectory.transitions:
        ranges = [
            f'{t[key][0]:+.2f} to {t[key][1]:+.2f}' if t.get(key) else ''
            for key in ('range_before', 'range_after')
        ]
        rows.append(
            [
                ', '.join(t.get('before', ())),
                ', '.join(t.get('after', ())),
                *ranges,
                *('yes' if t.get(key) else 'no' for key in ('condition_1', 'condition_2')),
            ]
        )
    if not rows:
        return '<p>None between quasi-static stretches.</p>'
    return table(
        [
            'contacts before',
            'after',
            'range before [N m]',
            'after [N m]',
            'condition 1',
            'condition 2',
        ],
        rows,
        'long',
    )


def _errors(trajectory: ManipulationTrajectory, run: RunView) -> str:
    return table(
        ['error', 'value', 'unit'],
        [[name, f'{value:.3g}', unit] for name, (value, unit) in errors(trajectory, run).items()],
        'numbers',
    )


def _facts(plan: ContactPlan, trajectory: ManipulationTrajectory, run: RunView) -> str:
    verified = trajectory.verification or {}
    told = {
        **run.facts,
        'plan': plan.id,
        'search': plan.search,
        'seed': plan.seed,
        **{name.replace('_', ' '): value for name, value in plan.counts.items()},
    }
    if verified:
        told['verified'] = (
            f'{verified.get("survived")} of {verified.get("copies")} '
            'simulated samples reach the goal'
        )
    if plan.certificate:
        told['certificate'] = str(plan.certificate)
    if plan.execution:
        told['execution'] = ', '.join(
            f'{k.replace("_", " ")}: {v}' for k, v in plan.execution.items()
        )
    told['report made with'] = ', '.join(f'{k} {v}' for k, v in versions().items())
    return facts(told)


def _scenario(plan: ContactPlan) -> str:
    return escape(json.dumps(scenario_to_dict(plan.scenario), indent=1))
