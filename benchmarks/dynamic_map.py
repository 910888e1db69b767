"""How large the extra torque of the dynamic mode must be, and how early it must begin: a map of what survives.

    python benchmarks/dynamic_map.py [--scenario FILE] [--out docs/images/dynamic_map.png] [--json OUT]

The route that `--transition dynamic` gives is executed in simulation with every pair (τ_extra, lead), on samples perturbed
more than a plan asks for (levels 3 to 5); the pair that was chosen is framed. A trial survives when the object ends at its
goal. Hatched: Check_Dyn expects more contacts to break than shall, so the generator dwells instead, whatever the lead.
"""

import argparse
import json
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
from matplotlib.patches import Rectangle

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.report.figures.canvas import new_figure, save
from wholearm_ros.rollout.perturbed_samples import build_perturbed_samples
from wholearm_ros.rollout.verification import roll_out
from wholearm_ros.trajectory.execution_options import ExecutionOptions
from wholearm_ros.trajectory.main_trajectory import generate

ROOT = Path(__file__).parents[1]
EXTRA = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0, 2.0)  # [N m]
LEADS = (0.0, 0.01, 0.02, 0.04, 0.06, 0.08, 0.11, 0.14, 0.2, 0.3)  # [s] before the transition
LEVELS, SAMPLES = (3.0, 4.0, 5.0), 6  # of perturbation; samples at each


def success_map(scenario, answer) -> tuple:
    """Both (len(EXTRA), len(LEADS)): the share of the samples that survive, and whether there is a dynamic mode at all."""
    chosen = ExecutionOptions.from_dict(answer.plan.execution)
    samples = [
        sample
        for level in LEVELS
        for sample in build_perturbed_samples(scenario, SAMPLES, level, 0)[1:]
    ]
    shares, dynamic = (
        np.empty((len(EXTRA), len(LEADS))),
        np.empty((len(EXTRA), len(LEADS)), dtype=bool),
    )
    for (row, extra), (column, lead) in product(enumerate(EXTRA), enumerate(LEADS)):
        options = replace(chosen, extra_torque=extra, dynamic_lead=lead)
        trajectory = generate(scenario, answer.plan.with_execution(options.to_dict()), options)
        dynamic[row, column] = trajectory.time_in_modes()['dynamic'] > 0.0
        shares[row, column] = np.mean(
            [roll_out(trajectory, sample, ControlOptions()).success for sample in samples]
        )
    return shares, dynamic


def draw_map(shares: np.ndarray, dynamic: np.ndarray, execution: dict, title: str):
    """The map, its cells named, the chosen pair in a frame."""
    figure = new_figure(6.6, 5.0, layout='constrained')
    axes = figure.subplots()
    image = axes.imshow(shares, origin='lower', cmap='YlGn', vmin=0.0, vmax=1.0, aspect='auto')
    for (row, column), share in np.ndenumerate(shares):
        if not dynamic[row, column]:
            axes.add_patch(
                Rectangle(
                    (column - 0.5, row - 0.5),
                    1,
                    1,
                    facecolor='none',
                    edgecolor='#555555',
                    hatch='///',
                    lw=0,
                )
            )
        axes.text(
            column, row, f'{100 * share:.0f}', ha='center', va='center', fontsize=7, color='#1a1a1a'
        )
    x, y = (
        np.interp(execution[name], ticks, range(len(ticks)))
        for name, ticks in (('dynamic_lead', LEADS), ('extra_torque', EXTRA))
    )
    axes.plot(
        x,
        y,
        's',
        markersize=27,
        markerfacecolor='none',
        markeredgecolor='#1b3a5c',
        markeredgewidth=2.4,
    )
    axes.set_xticks(range(len(LEADS)), [f'{1000 * lead:.0f}' for lead in LEADS])
    axes.set_yticks(range(len(EXTRA)), EXTRA)
    axes.set(
        xlabel='start of the dynamic mode before the transition [ms]',
        ylabel='extra torque τ_extra [N m]',
    )
    axes.set_title(
        f'{title}: samples at the goal [%]\nframed: chosen; hatched: Check_Dyn says no, a dwell instead',
        fontsize='medium',
        loc='left',
    )
    figure.colorbar(image, label='share of the samples at the goal')
    return figure


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        '--scenario', type=Path, default=ROOT / 'config' / 'asymmetric_hexagon.yaml'
    )
    parser.add_argument('--out', type=Path, default=ROOT / 'docs' / 'images' / 'dynamic_map.png')
    parser.add_argument('--json', type=Path)
    options = parser.parse_args()
    scenario = load_scenario(options.scenario)
    answer = plan_and_verify(scenario, PlanRequest(transition='dynamic'))
    if answer.trajectory is None:
        parser.exit(1, f'{answer.plan.summary()}\n')
    shares, dynamic = success_map(scenario, answer)
    save(draw_map(shares, dynamic, answer.plan.execution, scenario.name), options.out)
    chosen = {name: answer.plan.execution[name] for name in ('extra_torque', 'dynamic_lead')}
    print(
        f'chosen: {chosen}; with a dynamic mode between {shares[dynamic].min():.0%} and {shares[dynamic].max():.0%} of the '
        f'samples reach the goal; written: {options.out}'
    )
    if options.json:
        options.json.write_text(
            json.dumps(
                {
                    'extra_torque': EXTRA,
                    'lead': LEADS,
                    'share': shares.tolist(),
                    'dynamic': dynamic.tolist(),
                    'chosen': chosen,
                }
            )
        )


if __name__ == '__main__':
    main()
