"""Plan the shapes of the gallery and write docs/gallery.md with their pictures: python docs/make_gallery.py"""

from pathlib import Path

import numpy as np

import wholearm_ros as wa
from wholearm_ros.planner.advice import advise
from wholearm_ros.report.figures.canvas import save
from wholearm_ros.report.figures.search_figure import draw_reached

HERE = Path(__file__).parent
IMAGES = HERE / 'images' / 'gallery'
FINGER = {
    'length': 0.15,
    'half_width': 0.006,
    'mass': 0.16,
    'rotor_inertia': 0.005,
    'angle_limits': [0.05, 3.09],
    'torque_limit': 7.0,
}
FLAT, V = [[-0.15, 0.0], [0.15, 0.0]], [[-0.15, 0.02], [0.0, 0.0], [0.15, 0.02]]
BUDGET = 120.0  # [s] for each
ADVICE = 420.0  # [s] for each that has no plan
EVERY = 0.25  # [s] between two outlines of a picture


def regular(n, radius):
    turn = 2 * np.pi * (np.arange(n) + 0.5) / n - np.pi / 2 - 2 * np.pi / n
    return np.round(radius * np.column_stack([np.cos(turn), np.sin(turn)]), 6).tolist()


def box(width, height):
    return [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]


HEXAGON = [
    [0.0, 0.0],
    [0.060, 0.0],
    [0.101, 0.068],
    [0.053, 0.107],
    [-0.013, 0.115],
    [-0.038, 0.079],
]
BRACKET = [[0.0, 0.0], [0.09, 0.0], [0.09, 0.03], [0.03, 0.09], [0.0, 0.09]]
TRIANGLE = [[0.0, 0.0], [0.11, 0.0], [0.055, 0.09]]
SHAPES = [  # name, what it is, vertices, x at the start, half distance of the axes, their height, palm
    ('hexagon', 'the shipped asymmetric hexagon', HEXAGON, -0.02, 0.10, -0.02, FLAT),
    (
        'hexagon_high_axes',
        'the same, axes at the height of the palm',
        HEXAGON,
        -0.02,
        0.10,
        0.0,
        FLAT,
    ),
    ('hexagon_v_palm', 'the same on a palm that is a flat V', HEXAGON, -0.04, 0.10, -0.02, V),
    ('square_70', 'square, 7 cm', box(0.07, 0.07), -0.02, 0.10, -0.02, FLAT),
    (
        'square_70_wide',
        'the same, axes 1 cm farther out',
        box(0.07, 0.07),
        -0.02,
        0.11,
        -0.02,
        FLAT,
    ),
    ('rectangle', 'rectangle, 9 by 6 cm', box(0.09, 0.06), -0.02, 0.10, -0.02, FLAT),
    ('bar', 'bar, 12 by 3 cm', box(0.12, 0.03), -0.02, 0.10, -0.02, FLAT),
    ('triangle', 'triangle, 11 by 9 cm', TRIANGLE, -0.02, 0.10, -0.02, FLAT),
    ('bracket', 'hull of a bracket, 9 cm', BRACKET, -0.02, 0.10, -0.02, FLAT),
    ('octagon', 'regular octagon, 11 cm across', regular(8, 0.0575), -0.02, 0.10, -0.02, FLAT),
]
HEAD = """# Gallery
Ten shapes, each to be turned counter-clockwise onto its next edge, planned with seed 0: what succeeds, and what does not. Filled: the
start. Dashed: the goal. Thin: where the plan (or, without one, the search) has had the object. Success: fresh samples perturbed at
level 1 that reach the goal, and the success rate that follows with 95 % confidence.

Made by `python docs/make_gallery.py`; the picture of a search, `wholearm plan --figures DIR`; what to change, `wholearm advise`
([your polygon](your_polygon.md)).

| shape | picture | what happens |
|---|---|---|
"""


def scenario_of(name, vertices, x, half, height, palm):
    edge = 0
    return wa.parse_scenario(
        {
            'name': name,
            'object': {'vertices': vertices, 'mass': 0.35},
            'hand': {
                'left': {'axis': [-half, height], **FINGER},
                'right': {'axis': [half, height], **FINGER},
            },
            'palm': {'vertices': palm},
            'gravity': {'acceleration': 9.81, 'tilt_deg': 15.0},
            'start': {'edge': edge, 'x': x},
            'goal': {'edge': len(vertices) - 1, 'direction': 'ccw'},
        },
        name,
    )


def told(scenario, result):
    plan, trajectory = result.plan, result.trajectory
    if trajectory is None:
        return f'**no plan** ({plan.outcome}): {plan.reason}. {advised(scenario)}'
    modes = [f'{mode} {s:.1f} s' for mode, s in trajectory.time_in_modes().items() if s > 0.05]
    return (
        f'{plan.certificate.survived} of {plan.certificate.samples}, at least '
        f'{plan.certificate.lower_bound:.2f}; {trajectory.duration:.1f} s: {", ".join(modes)}'
    )


def advised(scenario):
    tried = list(advise(scenario, wa.PlanRequest(seed=0, time_budget=60.0), ADVICE))
    if not tried or not tried[-1].works:
        return f'`wholearm advise` finds no single change among the {len(tried)} trials of its time'
    best = tried[-1]
    sure = best.result.plan.certificate
    return f'`wholearm advise`: {best.change.what}, then {sure.survived} of {sure.samples}'


def picture(scenario, result):
    if result.trajectory is None:
        poses = np.array([s.configuration[:3] for s in result.plan.subgoals]).reshape(-1, 3)
    else:
        poses = result.trajectory.poses[:: round(EVERY / result.trajectory.period)]
    return draw_reached(scenario, '', poses)


def main():
    rows = []
    for name, what, *numbers in SHAPES:
        scenario = scenario_of(name, *numbers)
        result = wa.plan(scenario, wa.PlanRequest(seed=0, time_budget=BUDGET))
        save(picture(scenario, result), IMAGES / f'{name}.png', dpi=55)
        rows.append(f'| {what} | ![{what}](images/gallery/{name}.png) | {told(scenario, result)} |')
        print(rows[-1], flush=True)
    (HERE / 'gallery.md').write_text(HEAD + '\n'.join(rows) + '\n')


if __name__ == '__main__':
    main()
