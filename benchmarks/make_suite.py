"""Makes benchmarks/suite.json: the shipped scenarios, and polygons of 4 to 8 vertices drawn from a seed, to be turned onto
their next face.

    python benchmarks/make_suite.py [--tasks 24] [--seed 1] [--hand tapered] [--regular] [--out benchmarks/suite.json]

With --hand they are turned in another hand, that of the shipped scenario of this kind, which is the first task. With --regular
all but the shipped ones are regular polygons of 3 to 8 sides, as wide.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from wholearm_ros.errors import WholeArmError
from wholearm_ros.mechanics.contacts import start_configuration
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario_file import load_scenario, parse_scenario, scenario_to_dict

HERE = Path(__file__).parent


def shipped(*names: str) -> list[dict]:
    """Shipped scenarios as dictionaries."""
    return [
        scenario_to_dict(load_scenario(HERE.parent / 'config' / f'{name}.yaml')) for name in names
    ]


SHIPPED = shipped('asymmetric_hexagon', 'regular_hexagon')
HANDS = {
    'tapered': 'tapered_fingers',
    'hooked': 'hooked_fingers',
    'unequal': 'unequal_fingers',
    'v_palm': 'v_palm',
}
# [m] how far from the middle an object starts: on one side of a V.
PLACES = {'v_palm': (0.02, 0.06)}
CORNERS = (
    6,
    5,
    6,
    8,
    6,
    4,
    6,
    7,
    6,
    5,
    6,
    6,
)  # how many, one task after the other: mostly hexagons
REGULAR = (3, 4, 5, 6, 7, 8)


def random_task(
    rng: np.random.Generator,
    corners: int,
    name: str,
    like: dict = SHIPPED[0],
    places: tuple[float, float] = (0.0, 0.03),
    regular: bool = False,
) -> dict:
    """A scenario as a dictionary: a convex polygon 10 to 14 cm across, at rest between the fingers, to be turned onto the next
    edge on which it can rest, either way round, in the hand of another scenario. What cannot be started is drawn again."""
    while True:
        vertices, turn, edge = (
            _regular(rng, corners) if regular else _outline(rng, corners),
            int(rng.choice([-1, 1])),
            int(rng.integers(corners)),
        )
        try:
            polygon = Polygon(vertices)
            stable = polygon.resting_edges
            goal = stable[(stable.index(edge) - turn) % len(stable)]
            task = {
                **like,
                'name': name,
                'object': {'vertices': vertices, 'mass': round(rng.uniform(0.2, 0.5), 3)},
                'start': {'edge': edge, 'x': -turn * round(rng.uniform(*places), 2)},
                'goal': {'edge': goal, 'direction': 'ccw' if turn > 0 else 'cw'},
            }
            start_configuration(parse_scenario(task))
            return task
        except (WholeArmError, ValueError):
            continue


def _outline(rng, corners) -> list:
    """Points in turn round a centre, as far from it as chance will, but not so unlike that many corners were never convex; from
    the first one, to the millimetre, or a tenth of it where they are many."""
    unlike = min(0.009, 0.6 * 0.061 * (1.0 - np.cos(2.0 * np.pi / corners)))  # [m]
    gaps = rng.uniform(1.0, 1.8, corners)
    angles = rng.uniform(0.0, 2 * np.pi) + 2 * np.pi * np.cumsum(gaps) / gaps.sum()
    points = np.column_stack([np.cos(angles), np.sin(angles)]) * rng.uniform(
        0.061 - unlike, 0.061 + unlike, (corners, 1)
    )
    return np.round(points - points[0], 3 if corners <= 8 else 4).tolist()


def _regular(rng, corners) -> list:
    """A regular polygon, as far across as the others, to the micrometre."""
    angles = 2.0 * np.pi * np.arange(corners) / corners
    points = np.column_stack([np.cos(angles), np.sin(angles)]) * rng.uniform(0.052, 0.07)
    return np.round(points - points[0], 6).tolist()


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--tasks', type=int, default=24)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--hand', choices=HANDS)
    parser.add_argument('--regular', action='store_true', help='regular polygons')
    parser.add_argument('--out', type=Path, default=HERE / 'suite.json')
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    first = shipped(HANDS[options.hand]) if options.hand else SHIPPED
    places = PLACES.get(options.hand, (0.0, 0.03))
    cycle = REGULAR if options.regular else CORNERS
    corners = [cycle[k % len(cycle)] for k in range(options.tasks - len(first))]
    drawn = [
        random_task(rng, n, f'{k:02d}-{n}gon', first[0], places, options.regular)
        for k, n in enumerate(corners)
    ]
    tasks = [*first, *drawn]
    document = {
        'format': 'wholearm-suite/1',
        'units': {'length': 'm', 'mass': 'kg', 'angle': 'rad unless _deg', 'torque': 'N m'},
        'seed': options.seed,
    }
    lines = ',\n'.join(json.dumps(task) for task in tasks)
    options.out.write_text(f'{json.dumps(document)[:-1]}, "tasks": [\n{lines}\n]}}\n')


if __name__ == '__main__':
    main()
