"""The face map: routes over certified ways, kept on disk, and used for goals without a direction."""

from dataclasses import replace

import pytest

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.model.certificate import certificate
from wholearm_ros.model.outcomes import AT_GOAL, UNKNOWN, UNVERIFIED
from wholearm_ros.model.perturbation import NOMINAL
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import CCW, CW, GoalOnEdge, StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.planner.certification import certify_in_a_row
from wholearm_ros.planner.face_map import FaceMap, Refused, Way
from wholearm_ros.planner.legs import REACH, LegPlanner, leg_of, whole_task
from wholearm_ros.planner.map_making import (
    MapOptions,
    make_way,
    map_stages,
    next_face,
    slides_to_try,
    turns_to_try,
)
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.planner.supervision import stop_of
from wholearm_ros.planning.routes import plan
from wholearm_ros.report.figures.graph_layout import lay_out
from wholearm_ros.simulation.closed_loop import LoopOptions
from wholearm_ros.suite.execution import execute
from wholearm_ros.suite.session import HandSession, Pursuit
from wholearm_ros.suite.suite_options import SuiteOptions
from wholearm_ros.trajectory.main_trajectory import generate

SCENARIO = load_scenario('asymmetric_hexagon')
OPTIONS = MapOptions(PlanRequest(certificate_samples=20, min_success=0.5))


@pytest.fixture(scope='module')
def route():
    """A plan; which one does not matter to routes."""
    return plan(SCENARIO)


def way(route, start, x, goal, end_x, survived, direction=CCW):
    certified = replace(route, certificate=certificate(1.0, 59, survived))
    end = StartOnEdge(goal, end_x)
    return Way(StartOnEdge(start, x), 0.006, GoalOnEdge(goal, direction), end, certified)


def test_a_route_alone_is_short_and_leads_to_the_same_motion(route):
    alone = route.route_alone
    assert len(route.subgoals) > len(alone.subgoals) and {s.number for s in alone.subgoals} == set(
        route.path
    )
    before = {s.number: s.parent for s in alone.subgoals}
    assert [before[n] for n in route.path] == [None, *route.path[:-1]]
    assert lay_out(alone).route
    again = ContactPlan.from_json(alone.to_json())
    angles = [generate(SCENARIO, one).angles for one in (route, again)]
    assert (angles[0] == angles[1]).all()


def test_of_two_routes_the_surer_one_is_taken_even_when_it_is_longer(route):
    direct = way(route, 0, 0.0, 2, 0.0, 40)
    first, second = way(route, 0, 0.0, 1, 0.0, 59), way(route, 1, 0.0, 2, 0.0, 59)
    face_map = FaceMap((0, 1, 2), (direct, first, second))
    assert face_map.route(StartOnEdge(0, 0.001), GoalOnEdge(2)) == (first, second)
    surer = FaceMap((0, 1, 2), (replace(direct, plan=first.plan), first, second))
    assert surer.route(StartOnEdge(0, 0.001), GoalOnEdge(2)) == (surer.ways[0],)


def test_a_way_is_taken_only_from_within_its_reach(route):
    far = way(route, 1, 0.02, 2, 0.0, 59)
    face_map = FaceMap((0, 1, 2), (way(route, 0, 0.0, 1, 0.0, 59), far))
    assert face_map.route(StartOnEdge(0, 0.0), GoalOnEdge(2)) == ()
    slide = way(route, 1, 0.0, 1, 0.019, 59, direction=None)
    face_map = replace(face_map, ways=(*face_map.ways, slide))
    assert face_map.route(StartOnEdge(0, 0.0), GoalOnEdge(2)) == (face_map.ways[0], slide, far)
    assert face_map.route(StartOnEdge(0, 0.007), GoalOnEdge(1)) == ()


def test_what_fails_in_a_session_is_avoided_but_not_banned(route):
    one = way(route, 0, 0.0, 1, 0.0, 59)
    other = replace(
        way(route, 0, 0.0, 1, 0.01, 57), plan=replace(route, seed=1, certificate=one.certificate)
    )
    face_map = FaceMap((0, 1), (one, other))
    chosen = face_map.route(StartOnEdge(0, 0.0), GoalOnEdge(1))[0]
    face_map = face_map.after({chosen.plan.id: (0, 2)})
    again = face_map.route(StartOnEdge(0, 0.0), GoalOnEdge(1))[0]
    assert again.plan.id != chosen.plan.id
    assert FaceMap((0, 1), face_map.ways[:1]).route(StartOnEdge(0, 0.0), GoalOnEdge(1))


def test_the_next_faces_are_the_neighbours_and_every_turn_is_asked_for_once():
    polygon = SCENARIO.object.polygon
    assert (next_face(polygon, 0, CCW), next_face(polygon, 0, CW)) == (5, 1)
    faces = polygon.resting_edges
    turns = turns_to_try(SCENARIO, replace(OPTIONS, half_range=0.01))
    asked = {(s.start.edge, s.start.x, s.goal.direction) for s in turns}
    assert len(asked) == len(turns) == 2 * 3 * len(faces)
    assert all(next_face(polygon, s.start.edge, s.goal.direction) == s.goal.edge for s in turns)


def test_a_map_is_made_kept_and_answers(tmp_path):
    options = replace(OPTIONS, half_range=0.0)
    store = MapStore(SCENARIO, tmp_path)
    assert store.load().ways == ()
    turn = next(s for s in turns_to_try(SCENARIO, options) if (s.start.edge, s.goal.edge) == (0, 1))
    made = make_way(turn, options)
    assert isinstance(made, Way) and made.certificate.lower_bound >= 0.5
    assert not store.has(turn)
    store.save(turn, made)
    store.save(
        replace(turn, goal=GoalOnEdge(5, CCW)), Refused(turn.start, GoalOnEdge(5, CCW), 'no')
    )
    assert store.has(turn)
    (store.directory / 'damaged.json').write_text('{')
    face_map = store.load()
    assert [w.plan.id for w in face_map.ways] == [made.plan.id] and len(face_map.refused) == 1
    document = face_map.to_dict('hexagon')
    assert document['format'] == 'wholearm-map/1' and document['edges'][0]['to']['edge'] == 1
    slides = slides_to_try(SCENARIO, replace(OPTIONS, half_range=0.01), face_map.ways)
    asked = {(s.start.edge, s.start.x, s.goal.x) for s in slides}
    assert asked == {(0, -0.01, 0.0), (0, 0.01, 0.0)}

    felt = replace(SCENARIO, start=StartOnEdge(0, 0.004), goal=GoalOnEdge(1))
    answer = LegPlanner(PlanRequest(), store).plan(felt)
    assert answer.plan.id == made.plan.id and answer.trajectory is not None
    assert stop_of(felt, answer.plan.scenario) is None
    assert stop_of(replace(felt, goal=GoalOnEdge(2)), answer.plan.scenario) == GoalOnEdge(1, CW)


def test_a_turn_that_a_quick_search_did_not_find_is_searched_for_longer_but_once(tmp_path):
    store, turn = MapStore(SCENARIO, tmp_path), turns_to_try(SCENARIO, OPTIONS)[0]
    for moves, untried in ((100, True), (7000, False), (None, False)):
        store.save(turn, Refused(turn.start, turn.goal, 'not_executable: no route', moves))
        assert store.has(turn, 100)
        assert bool(store.untried([turn], 7000)) == untried
    store.save(turn, Refused(turn.start, turn.goal, 'time_spent: no route'))
    assert not store.has(turn)


def test_what_a_quick_search_ended_at_its_limit_says_so():
    turn = replace(SCENARIO, start=StartOnEdge(5, 0.03), goal=GoalOnEdge(0, CW))
    tried = make_way(turn, replace(OPTIONS, request=replace(OPTIONS.request, moves=30)))
    assert isinstance(tried, Refused) and tried.moves == 30
    arcs = make_way(turn, replace(OPTIONS, request=ARCS_ONLY))
    assert isinstance(arcs, Refused) and arcs.moves is None


def test_a_map_searches_longer_only_for_turns_that_no_slide_leads_to(route):
    """The turn 0 → 1 is known from x = 0, and a slide leads there from 1 cm, none from −1 cm."""
    options = replace(OPTIONS, half_range=0.01, quick_moves=100)
    known = FaceMap(SCENARIO.object.polygon.resting_edges)
    turn = replace(way(route, 0, 0.0, 1, 0.0, 59), goal=GoalOnEdge(1, CW))
    slide = way(route, 0, 0.01, 0, 0.001, 59, direction=None)
    stages = map_stages(SCENARIO, options, lambda: replace(known, ways=(turn, slide)))
    told = [
        (
            stage.name,
            stage.options.request.moves,
            [s.start.x for s in stage.wanted if (s.start.edge, s.goal.edge) == (0, 1)],
        )
        for stage in stages
    ]
    full = OPTIONS.request.moves
    assert [t for t in told if t[0] != 'slides'] == [
        ('turns', 100, [0.0, -0.01, 0.01]),
        ('turns that lack', full, []),
        ('turns that lack', full, [-0.01]),
    ]


ARCS_ONLY = PlanRequest(moves=0, certificate_samples=20, min_success=0.5)


@pytest.fixture(scope='module')
def of_two_turns(tmp_path_factory):
    """A plan to a face by way of another one, of a map that knows no way to it at once."""
    store, start, options = (
        MapStore(SCENARIO, tmp_path_factory.mktemp('map')),
        SCENARIO.start,
        MapOptions(ARCS_ONLY),
    )
    for edge in (5, 4):
        turn = replace(SCENARIO, start=start, goal=GoalOnEdge(edge, CCW))
        made = make_way(turn, options)
        store.save(turn, made)
        start, options = made.end, replace(options, reach=REACH)
    return LegPlanner(ARCS_ONLY, store).plan(replace(SCENARIO, goal=GoalOnEdge(4)))


def test_a_plan_of_several_turns_is_one_document_and_is_certified_in_a_row(of_two_turns):
    plan, (second,) = of_two_turns.plan, of_two_turns.plan.then
    assert (plan.scenario.goal.edge, second.scenario.start.edge, second.scenario.goal.edge) == (
        *(5, 5),
        4,
    )
    assert plan.overall.samples == 20 and plan.overall.survived <= plan.certificate.survived
    assert abs(second.scenario.start.x - plan.legs[-1].configurations[-1, 0]) < REACH
    assert of_two_turns.trajectory.plan_id == plan.id != plan.turn.id
    read = ContactPlan.from_json(plan.to_json())
    assert read.id == plan.id and read.then[0].id == second.id and read.overall == plan.overall
    assert whole_task(plan).goal.edge == 4 and whole_task(second) is second.scenario


def test_the_turns_of_a_plan_are_executed_one_after_the_other_and_not_planned_again(of_two_turns):
    asked = whole_task(of_two_turns.plan)
    options = SuiteOptions(ARCS_ONLY, backend='planar', maps=False)
    run = execute(asked, leg_of(asked, of_two_turns), options)
    assert run.judged.executed and run.attempts.outcome == 'at_goal'
    executed = [motion.trajectory.plan_id for motion in run.attempts.motions]
    assert executed == [of_two_turns.plan.id, of_two_turns.plan.then[0].id]


def test_in_a_row_only_samples_that_survive_every_turn_count(of_two_turns):
    """At a level at which many fall: fewer are left after the second turn; none without samples."""
    turns = (of_two_turns.plan.turn, *of_two_turns.plan.then)
    hard = replace(ARCS_ONLY, certificate_level=4.0)
    first, both = (certify_in_a_row(turns[:n], hard) for n in (1, 2))
    assert both.samples == first.samples == 20 and both.survived < first.survived < 20
    assert certify_in_a_row(turns, replace(ARCS_ONLY, certificate_samples=0)) is None


def test_a_face_that_cannot_be_reached_is_refused_with_those_that_can():
    refused = LegPlanner(ARCS_ONLY).plan(replace(SCENARIO, goal=GoalOnEdge(2)))
    assert refused.trajectory is None and not refused.plan.then
    assert 'can be reached: 5, 4, 1' in refused.plan.reason


def test_where_no_plan_leads_there_at_once_it_goes_by_way_of_another_face(monkeypatch):
    """Each turn is planned; only the plan for all at once is refused here."""
    refused = LegPlanner(ARCS_ONLY).plan(replace(SCENARIO, goal=GoalOnEdge(2)))
    monkeypatch.setattr('wholearm_ros.planner.legs.plan_and_verify', lambda *_, **__: refused)
    lines = []
    answer = LegPlanner(ARCS_ONLY).plan(replace(SCENARIO, goal=GoalOnEdge(4)), lines.append)
    edges = [turn.scenario.goal.edge for turn in (answer.plan, *answer.plan.then)]
    assert edges == [5, 4] and lines == ['by way of edge 5'] and answer.plan.overall.survived > 10


def test_from_out_of_reach_of_every_turn_the_object_is_moved_along_the_palm_first(tmp_path):
    store = MapStore(SCENARIO, tmp_path)
    turn = replace(SCENARIO, start=StartOnEdge(0, 0.0), goal=GoalOnEdge(5, CCW))
    made = make_way(turn, MapOptions(ARCS_ONLY))
    store.save(turn, made)
    asked = replace(SCENARIO, start=StartOnEdge(0, 0.025), goal=GoalOnEdge(5))
    answer = LegPlanner(ARCS_ONLY, store).plan(asked)
    slide = answer.plan.scenario.goal
    assert (slide.edge, slide.x, slide.direction) == (0, 0.0, None)
    assert [turn.id for turn in answer.plan.then] == [made.plan.id]
    assert answer.plan.overall.survived > 10
    assert stop_of(asked, answer.plan.scenario) == slide
    without = LegPlanner(ARCS_ONLY, store, in_a_row=False).plan(asked).plan
    assert without.overall is None and without.then[0].id == made.plan.id
    first = leg_of(asked, answer)
    assert first.unfelt_end == made.start
    options = SuiteOptions(ARCS_ONLY, backend='planar')
    with HandSession(asked, NOMINAL, options) as session:
        pursuit = Pursuit(asked, first, options)
        pursuit.planner.maps = store
        done = session.pursue(asked, pursuit)
    assert [m.claim.outcome for m in done.motions] == [UNVERIFIED, AT_GOAL]
    assert done.outcome == AT_GOAL and not done.motions[0].record.pairs
    stopped = replace(options, loop=LoopOptions(controls=ControlOptions(max_tracking_error=1e-5)))
    with HandSession(asked, NOMINAL, stopped) as session:
        ended = session.pursue(asked, Pursuit(asked, first, stopped))
    assert ended.motions[0].record.reason and ended.motions[0].claim.outcome == UNKNOWN


def test_the_map_of_another_object_is_another_one(tmp_path):
    other = replace(SCENARIO, object=replace(SCENARIO.object, mass=0.3))
    here, there = (MapStore(s, tmp_path).directory for s in (SCENARIO, other))
    moved = replace(SCENARIO, start=StartOnEdge(1, 0.0), goal=GoalOnEdge(3))
    assert here != there and MapStore(moved, tmp_path).directory == here
