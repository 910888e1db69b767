"""Routes of motion primitives: the same every time, from rest to rest, and honest about an end to the search."""

from dataclasses import replace

import numpy as np
import pytest
from problems import ASYMMETRIC, ROLLING, SQUARE, TALL, THROWN, beliefs

from wholearm_ros.errors import DocumentError
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.motion_primitive import MotionPrimitive
from wholearm_ros.model.orientation import goal_rotation
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.planning.routes import SearchOptions
from wholearm_ros.rollout.primitive_rollout import Rest, released, simulate_primitive
from wholearm_ros.search.caging_ways import CagingWays
from wholearm_ros.search.primitive_candidates import GENTLE, THROWS, flings, flings_beside
from wholearm_ros.search.primitive_ways import PrimitiveWays
from wholearm_ros.search.state_routes import StateRoutes
from wholearm_ros.trajectory.main_trajectory import generate

OPTIONS = SearchOptions(move_limit=3000)
KINDS = CagingWays, PrimitiveWays


def of_primitives(scenario, options=OPTIONS):
    """The first route without arcs."""
    return StateRoutes(scenario, options, beliefs, kinds=KINDS).next_plan()


@pytest.fixture(scope='module')
def routes():
    return {s.name: of_primitives(s) for s in (ASYMMETRIC, TALL)}


def test_moves_lead_somewhere(routes):
    assert routes['asymmetric_hexagon'].found


def test_the_same_request_gives_the_same_bytes(routes):
    again = of_primitives(ASYMMETRIC)
    assert again.to_json() == routes['asymmetric_hexagon'].to_json()
    assert ContactPlan.from_json(again.to_json()).to_json() == again.to_json()


def test_the_legs_are_primitives_from_rest_to_rest_that_physics_makes(routes):
    """Each dynamic leg, simulated again from where it begins, ends where it says; the last leg ends at the goal."""
    for found in routes.values():
        if not found.found:
            continue
        world = build_world(found.scenario)
        q = found.legs[0].configurations[0]
        rest = Rest(q, world.bearing(q))
        for leg in found.legs:
            if leg.mode == 'dynamic':
                record = simulate_primitive(world, rest, MotionPrimitive.from_dict(leg.action))
                assert record.at_rest and record.residual <= 1e-9
                np.testing.assert_allclose(
                    record.configurations[-1], leg.configurations[-1], atol=1e-9
                )
                rest = record.rest()
        assert found.legs[-1].configurations[-1, 2] == pytest.approx(
            goal_rotation(found.scenario), abs=2e-4
        )


def test_the_generator_makes_the_moves_again_as_they_were_found(routes):
    """From where the hand really stood: a stiff velocity finger is not quite where it was told to be."""
    for found in routes.values():
        if not found.found:
            continue
        made = generate(found.scenario, found)
        ends = [
            made.poses[round(s.end / made.period)] for s in made.segments if s.mode == 'dynamic'
        ]
        moves = [leg.configurations[-1, :3] for leg in found.legs if leg.mode == 'dynamic']
        np.testing.assert_allclose(ends, moves, atol=1e-9)


def test_a_primitive_that_does_not_end_at_rest_fits_no_scenario(routes):
    found = routes['asymmetric_hexagon']
    hasty = replace(found.legs[0], action={**found.legs[0].action, 'settle': 0.0, 'speed': 20.0})
    with pytest.raises(DocumentError, match='does not end at rest'):
        generate(found.scenario, replace(found, legs=(hasty, *found.legs[1:])))


def test_of_the_flings_that_get_over_a_sure_one_is_taken():
    """It is none of the coarse grid, and most of those beside it end as it does."""
    routes = StateRoutes(ROLLING, OPTIONS, beliefs)
    legs, world = routes.next_plan().legs, routes.problem.world
    k = next(k for k, leg in enumerate(legs) if leg.action.get('speed', 0.0) > 2.0)
    fling, start = MotionPrimitive.from_dict(legs[k].action), legs[k].configurations[0]
    grid = [f for kind in (GENTLE, THROWS) for f in flings(routes.problem, start, kind)]
    assert fling not in grid
    rest = released(world, start)
    landing = legs[k].configurations[-1, 2]
    ends = [
        simulate_primitive(world, rest, beside).configurations[-1, 2]
        for beside in (fling, *flings_beside(fling))
    ]
    assert np.sum(np.abs(np.array(ends) - landing) < 0.2) >= 5


def test_an_object_that_nothing_leads_near_the_top_is_thrown_over_it():
    """Most perturbed samples land where the nominal one does."""
    routes = StateRoutes(THROWN, OPTIONS, beliefs)
    found = routes.next_plan()
    assert found.found
    moves = [MotionPrimitive.from_dict(leg.action) for leg in found.legs if leg.mode == 'dynamic']
    assert moves[-1].speed > GENTLE.speed
    assert routes.tree.states[-1].belief.loss < 0.2


def test_a_limit_of_moves_is_kept_and_reported():
    """The sweeps that open a new state are finished: up to a hundred beyond the limit."""
    found = of_primitives(SQUARE, SearchOptions(move_limit=50))
    assert 'no sequence of arcs and dynamic primitives' in found.reason and not found.legs
    assert 50 <= found.counts['simulations'] <= 50 + 100


def test_the_mirrored_task_is_searched_as_its_mirror_image(routes):
    """Not to the last bit (impacts amplify rounding), but the first primitive is the mirrored one and the goal is reached."""
    one, two = (
        routes['asymmetric_hexagon'],
        of_primitives(ASYMMETRIC.mirrored()),
    )
    assert two.found
    mirrored = MotionPrimitive.from_dict(one.legs[0].action).mirrored()
    assert MotionPrimitive.from_dict(two.legs[0].action) == mirrored
