"""Named problems of the tests: the shipped scenarios, small ones with one thing to show each, and random geometry."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from hypothesis import strategies as st

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.hand import Finger, Hand, Palm
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import (
    CCW,
    CW,
    GoalOnEdge,
    Gravity,
    ManipulatedObject,
    Scenario,
    StartOnEdge,
)
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.rollout.perturbed_samples import build_perturbed_samples
from wholearm_ros.search.belief import Samples

CONFIG = Path(__file__).parents[1] / 'config'
ASYMMETRIC = load_scenario(CONFIG / 'asymmetric_hexagon.yaml')
REGULAR = load_scenario(CONFIG / 'regular_hexagon.yaml')
SHIPPED = {'asymmetric': ASYMMETRIC, 'regular': REGULAR}
HAND, PALM, GRAVITY = ASYMMETRIC.hand, ASYMMETRIC.palm, ASYMMETRIC.gravity


OF_SHAPES = {
    name: load_scenario(CONFIG / f'{name}.yaml')
    for name in ('tapered_fingers', 'hooked_fingers', 'unequal_fingers', 'v_palm')
}
# What the laws of contact are tried on: rectangles, one convex polygon, several parts, and both at once.
HANDS = {
    'rectangles': HAND,
    'tapered': OF_SHAPES['tapered_fingers'].hand,
    'hooked': OF_SHAPES['hooked_fingers'].hand,
    'mixed': Hand(OF_SHAPES['hooked_fingers'].hand.left, OF_SHAPES['unequal_fingers'].hand.right),
}


def task(
    vertices,
    start_edge: int,
    goal_edge: int,
    x: float = 0.0,
    mass: float = 0.3,
    palm: Palm = PALM,
    hand: Hand = HAND,
    name: str = '',
) -> Scenario:
    """Turn a polygon counter-clockwise from one edge to another in the shipped hand."""
    return Scenario(
        ManipulatedObject(Polygon(vertices), mass),
        hand,
        palm,
        GRAVITY,
        StartOnEdge(start_edge, x),
        GoalOnEdge(goal_edge, CCW),
        name,
    )


def _ring(n: int, radius: float) -> np.ndarray:
    angles = 2.0 * np.pi * np.arange(n) / n - np.pi / 2 - np.pi / n
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


SQUARE = task(_ring(4, 0.05), 0, 3, name='square')
QUADRILATERAL = task(
    [[0.0, 0.0], [0.07, 0.0], [0.08, 0.06], [0.01, 0.07]], 0, 3, name='quadrilateral'
)
PENTAGON = task(_ring(5, 0.055), 0, 4, x=-0.02, name='pentagon')
TALL = task([[0.0, 0.0], [0.05, 0.0], [0.055, 0.11], [-0.005, 0.11]], 0, 3, x=-0.02, name='tall')
HEPTAGON = task(_ring(7, 0.055), 0, 6, x=-0.02, name='heptagon')
LEANING = replace(
    task(
        [[0.0, 0.0], [0.052, 0.074], [0.003, 0.127], [-0.079, 0.088], [-0.051, 0.028]],
        0,
        1,
        x=0.03,
        mass=0.365,
        name='leaning',
    ),
    goal=GoalOnEdge(1, CW),
)
# Turned by flings only; the shipped hand
ROLLING = task(
    [[0.0, 0.0], [0.04, 0.058], [0.027, 0.101], [-0.039, 0.127], [-0.07, 0.083], [-0.063, 0.032]],
    5,
    4,
    x=0.07,
    mass=0.377,
    name='rolling',
)
# Turned by a throw only, from where it lies flat
THROWN = replace(
    task(
        [[0.0, 0.0], [-0.094, -0.047], [-0.043, -0.114], [0.025, -0.075]],
        3,
        0,
        x=0.02,
        mass=0.205,
        name='thrown',
    ),
    goal=GoalOnEdge(0, CW),
)
FLAT_PALMS = {
    s.name: s for s in (ASYMMETRIC, REGULAR, SQUARE, QUADRILATERAL, PENTAGON, TALL, HEPTAGON)
}

# A palm that bulges: three edges, four vertices, of which all can touch an edge of the object.
BENT_PALM = Palm([[-0.15, -0.02], [-0.03, 0.0], [0.03, 0.0], [0.15, -0.02]])
ON_BENT_PALM = task(ASYMMETRIC.object.polygon.vertices, 0, 5, palm=BENT_PALM, name='bent_palm')


def with_torque_limits(scenario: Scenario, limit: float) -> Scenario:
    """The same with weaker (or stronger) motors."""
    return replace(
        scenario,
        hand=Hand(
            *(_finger(f, torque_limit=limit) for f in (scenario.hand.left, scenario.hand.right))
        ),
    )


def with_masses(scenario: Scenario, factor: float) -> Scenario:
    """The same geometry, everything that gravity pulls at `factor` times as heavy."""
    hand = Hand(
        *(_finger(f, mass=factor * f.mass) for f in (scenario.hand.left, scenario.hand.right))
    )
    return replace(
        scenario, hand=hand, object=replace(scenario.object, mass=factor * scenario.object.mass)
    )


def without_gravity(scenario: Scenario) -> Scenario:
    return replace(scenario, gravity=Gravity(0.0, 0.0))


def _finger(f: Finger, **changes) -> Finger:
    return replace(f, **changes)


@st.composite
def polygons(draw, most: int = 8) -> Polygon:
    """Convex polygons of 3 to `most` vertices on an ellipse, 4 to 12 cm across."""
    n = draw(st.integers(3, most))
    gaps = np.array([draw(st.floats(1.0, 2.5)) for _ in range(n)])
    turn = draw(st.floats(0.0, 6.28))
    a, b = draw(st.floats(0.03, 0.06)), draw(st.floats(0.03, 0.06))
    angles = turn + 2.0 * np.pi * np.cumsum(gaps) / gaps.sum()
    return Polygon(np.column_stack([a * np.cos(angles), b * np.sin(angles)]))


@st.composite
def scenarios(draw) -> Scenario:
    """A random polygon at rest on an edge that carries it, in the shipped hand; to be turned to the next such edge."""
    polygon = draw(polygons())
    stable = [k for k in range(len(polygon.vertices)) if polygon.can_rest_on(k)]
    k = draw(st.integers(0, len(stable) - 1))
    return task(
        polygon.vertices,
        stable[k],
        stable[k - 1],
        x=draw(st.floats(-0.02, 0.02)),
        mass=draw(st.floats(0.1, 0.6)),
    )


def random_scenario(rng: np.random.Generator) -> Scenario:
    """One of the same kind as `scenarios`, from a generator."""
    n = int(rng.integers(3, 9))
    gaps = rng.uniform(1.0, 2.5, n)
    angles = rng.uniform(0.0, 6.28) + 2.0 * np.pi * np.cumsum(gaps) / gaps.sum()
    a, b = rng.uniform(0.03, 0.06, 2)
    polygon = Polygon(np.column_stack([a * np.cos(angles), b * np.sin(angles)]))
    stable = [k for k in range(n) if polygon.can_rest_on(k)]
    k = int(rng.integers(len(stable)))
    return task(
        polygon.vertices,
        stable[k],
        stable[k - 1],
        x=rng.uniform(-0.02, 0.02),
        mass=rng.uniform(0.1, 0.6),
    )


def random_configuration(rng: np.random.Generator) -> np.ndarray:
    """(5,) somewhere between the fingers; nothing need touch, things may overlap."""
    return np.array(
        [
            rng.uniform(-0.06, 0.06),
            rng.uniform(-0.01, 0.1),
            rng.uniform(-3.2, 3.2),
            rng.uniform(0.3, 3.0),
            rng.uniform(0.1, 2.8),
        ]
    )


def worlds(rng: np.random.Generator, count: int, hand: Hand = HAND):
    """(scenario, world, configuration), every third on the bent palm."""
    for k in range(count):
        scenario = replace(random_scenario(rng), hand=hand)
        if k % 3 == 2:
            scenario = replace(scenario, palm=BENT_PALM)
        yield scenario, build_world(scenario), random_configuration(rng)


def beliefs(problem):
    """The nominal sample of a problem and three perturbed ones, all of which must arrive."""
    samples = build_perturbed_samples(problem.scenario, 3, 1.0, 1)
    return Samples(problem, samples, 1.0, ControlOptions())
