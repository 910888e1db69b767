"""The best route is the best: against every simple route of small graphs, and never worse than what the random search finds."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from problems import ASYMMETRIC, FLAT_PALMS, ON_BENT_PALM, QUADRILATERAL, REGULAR, SQUARE, TALL

from wholearm_ros.mechanics.contacts import pair_from_name
from wholearm_ros.mechanics.mirror import mirror_configurations, mirror_contacts
from wholearm_ros.model.plan import EXHAUSTED, FOUND, LIMIT_REACHED
from wholearm_ros.model.scenario_file import scenario_to_dict
from wholearm_ros.planning.best_first_search import ArcGraph, Edge, best_route
from wholearm_ros.planning.problem import build_problem
from wholearm_ros.planning.routes import RANDOM, SearchOptions, make_routes, plan

SMALL = pytest.mark.parametrize(
    'scenario',
    [ASYMMETRIC, REGULAR, QUADRILATERAL, TALL, ON_BENT_PALM],
    ids=['asymmetric', 'regular', 'quadrilateral', 'tall', 'bent_palm'],
)


def simple_routes(graph, without=frozenset(), k=0, seen=(0,)):
    """Every route from node k to the goal that meets no node twice, as tuples of edges."""
    for edge in graph.edges_from(k):
        if (edge.start, edge.choice) in without:
            continue
        if edge.end is None:
            yield (edge,)
        elif edge.end not in seen:
            for rest in simple_routes(graph, without, edge.end, (*seen, edge.end)):
                yield (edge, *rest)


def rank(route):
    """Widest margin first, then least cost."""
    return -min(e.margin for e in route), sum(e.cost for e in route)


@SMALL
def test_the_best_route_is_the_best_of_all_simple_routes(scenario):
    graph = ArcGraph(build_problem(scenario), 10_000)
    best = min(map(rank, simple_routes(graph)))
    outcome, edges, margin, cost = best_route(ArcGraph(build_problem(scenario), 10_000))
    assert outcome == FOUND and (-margin, cost) == pytest.approx(best, abs=1e-12)
    assert rank(edges) == pytest.approx(best, abs=1e-12)


@SMALL
def test_without_the_edges_that_failed_it_is_the_best_of_the_others_until_none_is_left(scenario):
    graph, without = ArcGraph(build_problem(scenario), 10_000), frozenset()
    for _ in range(6):
        outcome, edges, margin, cost = best_route(graph, without)
        left = [rank(route) for route in simple_routes(graph, without)]
        if not left:
            assert outcome == EXHAUSTED and edges == ()
            return
        assert (-margin, cost) == pytest.approx(min(left), abs=1e-12)
        without |= {(edges[-1].start, edges[-1].choice)}
    assert len(left) < len(list(simple_routes(graph)))


@dataclass
class Drawn:
    """A graph made of given edges."""

    edges: list
    traced: int = 0
    limit: int = 1000
    calls: list = field(default_factory=list)

    def stop(self):
        return False

    def edges_from(self, k):
        self.calls.append(k)
        return tuple(e for e in self.edges if e.start == k)


@st.composite
def drawn_graphs(draw):
    size = draw(st.integers(1, 6))
    edges = []
    for number in range(draw(st.integers(0, 14))):
        start, end = draw(st.integers(0, size - 1)), draw(st.integers(0, size))
        margin, cost = draw(st.sampled_from([-0.3, 0.0, 0.1, 0.2, 0.4])), draw(st.integers(1, 9))
        edges.append(
            Edge(start, ((), 1, number), end if end < size else None, margin, float(cost), ())
        )
    return Drawn(edges)


@given(drawn_graphs())
@settings(max_examples=300)
def test_on_any_graph_the_search_agrees_with_trying_every_route(graph):
    routes = [rank(route) for route in simple_routes(graph)]
    outcome, edges, margin, cost = best_route(graph)
    if not routes:
        assert outcome == EXHAUSTED and edges == ()
    else:
        assert outcome == FOUND and (-margin, cost) == min(routes) == rank(edges)
        assert [e.start for e in edges] == [0, *(e.end for e in edges[:-1])] and edges[
            -1
        ].end is None


def test_a_graph_may_not_be_traced_beyond_its_limit():
    found = plan(REGULAR, SearchOptions(limit=20))
    assert (
        found.outcome == LIMIT_REACHED
        and found.counts['expansions'] <= 20 + 2 * 30
        and not found.legs
    )


def test_an_exhausted_graph_says_so():
    found = plan(SQUARE)
    assert found.outcome == EXHAUSTED and 'exhausted' in found.reason and not found.path


@pytest.mark.parametrize('name', ['asymmetric_hexagon', 'regular_hexagon', 'quadrilateral', 'tall'])
def test_no_random_route_is_better_than_the_best(name):
    """Ten seeds: every random route is a route of the arc graph, ranked no better; its legs are found among the edges."""
    scenario = FLAT_PALMS[name]
    graph = ArcGraph(build_problem(scenario), 10_000)
    _, _, margin, cost = best_route(graph)
    k = 0
    while k < len(graph.network.nodes):
        graph.edges_from(k)
        k += 1
    ranked = 0
    for seed in range(10):
        route = route_in(graph, plan(scenario, SearchOptions(RANDOM, seed)))
        if route is not None:
            assert rank(route) >= (-margin - 1e-9, cost - 1e-9)
            ranked += 1
    assert ranked >= 8


@pytest.mark.parametrize(
    'name', ['asymmetric_hexagon', 'regular_hexagon', 'quadrilateral', 'tall', 'pentagon']
)
def test_both_searches_state_their_cost_and_the_best_states_the_better(name):
    """Margin and cost in the plan documents: ten seeds of the random search rank no better."""
    best = plan(FLAT_PALMS[name]).cost
    for seed in range(10):
        cost = plan(FLAT_PALMS[name], SearchOptions(RANDOM, seed)).cost
        assert (-cost['margin'], cost['total']) >= (-best['margin'] - 1e-6, best['total'] - 1e-4)


def route_in(graph, found):
    """The edges of the graph that a plan's legs run along, or None when one of them is not there."""
    route, k, legs = [], 0, list(found.legs)
    while legs:
        for edge in graph.edges_from(k):
            own = [graph.network.legs[n] for n in edge.numbers[1:]]
            if len(own) <= len(legs) and all(same_leg(a, b) for a, b in zip(own, legs)):
                break
        else:
            return None
        route.append(edge)
        del legs[: len(own)]
        k = edge.end
    return tuple(route)


def same_leg(a, b):
    return (
        a.contacts == b.contacts
        and a.mode == b.mode
        and np.allclose(a.configurations[-1], b.configurations[-1], atol=1e-6)
    )


@SMALL
def test_the_plan_of_the_best_route_is_a_chain_of_its_own_subgoals(scenario):
    """X_init first, X_goal last; legs between neighbours of the path; configurations without jumps."""
    found = plan(scenario)
    kinds = {s.number: s.kind for s in found.subgoals}
    assert (
        kinds[found.path[0]] == 'X_init'
        and kinds[found.path[-1]] == 'X_goal'
        and len(set(found.path)) == len(found.path)
    )
    neighbours = set(zip(found.path[:-1], found.path[1:]))
    assert all((leg.start, leg.end) in neighbours for leg in found.legs)
    for before, after in zip(found.legs[:-1], found.legs[1:]):
        np.testing.assert_allclose(
            after.configurations[0], before.configurations[-1], atol=2e-5
        )  # a Y reached twice is one
    assert set(found.cost) == {'margin', 'total'} and all(
        len([pair_from_name(c) for c in leg.contacts]) >= 4 for leg in found.legs
    )


def test_a_failed_leg_is_not_offered_again():
    routes = make_routes(ASYMMETRIC, SearchOptions())
    first = routes.next_plan()
    second = routes.next_plan(0)
    assert second.counts['routes_ruled_out'] == 1
    assert not second.found or not np.array_equal(
        first.legs[0].configurations, second.legs[0].configurations
    )


@pytest.mark.parametrize('search', ['best', 'random'])
@pytest.mark.parametrize(
    'scenario', [ASYMMETRIC, REGULAR, TALL], ids=['asymmetric', 'regular', 'tall']
)
def test_the_mirrored_scenario_gives_the_mirrored_plan(scenario, search):
    """Path, contacts and outcome are the images of one another; configurations to 1e-6."""
    one = plan(scenario, SearchOptions(search))
    two = plan(scenario.mirrored(), SearchOptions(search))
    assert scenario_to_dict(two.scenario) == scenario_to_dict(scenario.mirrored())
    assert (two.outcome, two.path, len(two.legs)) == (one.outcome, one.path, len(one.legs))
    for a, b in zip(one.legs, two.legs):
        assert sorted(b.contacts) == sorted(mirror_contacts(a.contacts, scenario.mirrored()))
        np.testing.assert_allclose(
            b.configurations, mirror_configurations(a.configurations), atol=1e-6
        )
