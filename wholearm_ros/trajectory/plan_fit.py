"""Fit: whether a plan can be executed in its scenario."""

import numpy as np

from wholearm_ros.errors import DocumentError
from wholearm_ros.kernels.world import World
from wholearm_ros.mechanics.contacts import contact_rows, pair_exists, pair_from_name
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.modes import QUASI_STATIC
from wholearm_ros.model.plan import ContactPlan, Leg
from wholearm_ros.model.scenario import Scenario

LARGEST_GAP = 1e-5  # [m] of a contact that the plan says is closed


def require_fit(scenario: Scenario, plan: ContactPlan) -> None:
    """Raises DocumentError unless the plan has a route, its contacts exist in the scenario, and
    those of its quasi-static legs are closed where the legs begin.
    """
    if not plan.legs:
        raise DocumentError(
            f'plan {plan.id} has no route to execute ({plan.outcome}: {plan.reason})'
        )
    world = build_world(scenario)
    for k, leg in enumerate(plan.legs):
        problem = _misfit(world, leg)
        if problem:
            raise DocumentError(f'plan {plan.id} does not fit its scenario: leg {k}: {problem}')


def _misfit(world: World, leg: Leg) -> str:
    """Why a leg does not fit, '' when it does."""
    try:
        pairs = tuple(pair_from_name(name) for name in leg.contacts)
    except (ValueError, KeyError, IndexError, AttributeError, OverflowError) as error:
        return f'contacts: {error}'
    there = all(pair_exists(world, pair) for pair in pairs)
    if not there or len(leg.configurations) < 2:
        return f'contacts {leg.contacts}, {len(leg.configurations)} configurations'
    if leg.mode != QUASI_STATIC:
        return ''
    if len(pairs) != 4:
        return f'{len(pairs)} contacts; allowed: four'
    gap = np.abs(contact_rows(world, pairs, leg.configurations[0])[1]).max()
    if gap <= LARGEST_GAP:
        return ''
    return f'its contacts are {gap:.1e} m apart; allowed: {LARGEST_GAP:.0e} m'
