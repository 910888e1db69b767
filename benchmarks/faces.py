"""Any face to any face: maps of random polygons, and sequences of faces that one hand lays them on.

    python benchmarks/faces.py [--polygons 12] [--seed 1] [--sequences 2] [--faces 6] [--unknown 2] [--levels 1 2]
                               [--attempts 4] [--range 0.03] [--time-budget 60] [--jobs 2] [--json OUT]

For each polygon the map is made (kept where `wholearm map` keeps it), then sequences of random faces, each another one
than the one before, are executed in PyBullet from a random face and place. Then `--unknown` times the object lies on any face,
anywhere within the range; nobody is told, so the hand feels first, and turns it to another random face. Told: ordered pairs
of faces with a route, time of the map and of an answer, faces reached of those asked and of those that the map says can be
reached from where the object lay, objects lost, claims that were wrong.
"""

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from make_suite import CORNERS, random_task

from wholearm_ros.errors import ScenarioError
from wholearm_ros.mechanics.contacts import start_configuration
from wholearm_ros.model.scenario import GoalOnEdge, StartOnEdge
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.planner.legs import LegPlanner, leg_of
from wholearm_ros.planner.map_making import MapOptions, slides_to_try, turns_to_try
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.simulation.outcome import outcome
from wholearm_ros.suite.execution import execute
from wholearm_ros.suite.map_work import try_ways
from wholearm_ros.suite.sequence import run_sequence
from wholearm_ros.suite.suite_options import SuiteOptions


def make_map(scenario, options: MapOptions, jobs: int) -> dict:
    """Time [s], and what the map holds."""
    began, store = time.monotonic(), MapStore(scenario)
    for wanted in (
        lambda: turns_to_try(scenario, options),
        lambda: slides_to_try(scenario, options, store.load().ways),
    ):
        list(try_ways(store.untried(wanted()), store, options, jobs))
    took = time.monotonic() - began
    face_map = store.load()
    faces = face_map.faces
    pairs = {(start.edge, face) for start, face, _ in face_map.all_pairs()}
    began = time.monotonic()
    store.load().route(StartOnEdge(faces[0], 0.0), GoalOnEdge(faces[-1]))
    return {
        'map_s': round(took, 1),
        'answer_ms': round(1e3 * (time.monotonic() - began), 2),
        'bytes': sum(f.stat().st_size for f in store.directory.glob('*.json')),
        'faces': len(faces),
        'pairs': len(pairs),
        'of': len(faces) * (len(faces) - 1),
        'ways': len(face_map.ways),
        'lower_bound': round(
            float(np.median([w.certificate.lower_bound for w in face_map.ways] or [0])), 3
        ),
    }


def run_sequences(scenario, rng, options, count: int, length: int) -> list:
    """A list of `reached` lists, each face with whether the map knew a route to it from where the object lay."""
    store, told = MapStore(scenario), []
    face_map = store.load()
    pairs = {(s.edge, face) for s, face, _ in face_map.all_pairs()}
    starts = sorted({w.start for w in face_map.ways}, key=lambda s: (s.edge, s.x))
    for draw in range(count if starts else 0):
        start, asked = starts[rng.integers(len(starts))], []
        for _ in range(length):
            before = asked[-1] if asked else start.edge
            asked.append(int(rng.choice([f for f in face_map.faces if f != before])))
        begun = replace(scenario, start=start, goal=GoalOnEdge(asked[0]))
        first = leg_of(begun, LegPlanner(options.request, store).plan(begun))
        reached = run_sequence(begun, tuple(asked), first, options, draw, scenario.name)['reached']
        at = start.edge
        for one in reached:
            one['known'] = (at, one['edge']) in pairs
            at = one.get('true_edge')
        told.append(reached)
    return told


def run_unknown(scenario, rng, options, half_range: float, count: int) -> list:
    """Runs from starts that are not told, each with where the object lay and what the first probe said of it."""
    face_map, told = MapStore(scenario).load(), []
    pairs = {(s.edge, face) for s, face, _ in face_map.all_pairs()}
    for draw in range(count):
        begun = unknown_start(scenario, rng, face_map.faces, half_range)
        made = execute(begun, None, options, draw, scenario.name).attempts
        claim = made.motions[0].claim
        told.append(
            {
                'edge': begun.goal.edge,
                'start': vars(begun.start),
                'felt_at_start': claim.edge if claim.sure else None,
                'known': (begun.start.edge, begun.goal.edge) in pairs,
                'executed': outcome(begun, made.last).executed,
                **made.to_dict(),
            }
        )
    return told


def unknown_start(scenario, rng, faces, half_range: float):
    """The scenario from anywhere on a random face, to be felt, to another random face."""
    while True:
        start, goal = (int(face) for face in rng.choice(faces, 2, replace=False))
        x = round(float(rng.uniform(-half_range, half_range)), 4)
        begun = replace(scenario, start=StartOnEdge(start, x, felt=True), goal=GoalOnEdge(goal))
        try:
            start_configuration(begun)
            return begun
        except ScenarioError:  # hand or palm do not allow it there
            continue


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--polygons', type=int, default=12)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--sequences', type=int, default=2)
    parser.add_argument('--faces', type=int, default=6)
    parser.add_argument('--unknown', type=int, default=2)
    parser.add_argument('--levels', type=float, nargs='*', default=[1.0, 2.0])
    parser.add_argument('--attempts', type=int, default=4)
    parser.add_argument('--range', type=float, default=MapOptions.half_range)
    parser.add_argument('--time-budget', type=float, default=MapOptions().request.time_budget)
    parser.add_argument('--jobs', type=int, default=2)
    parser.add_argument('--json', type=Path)
    args = parser.parse_args()
    rng, made = np.random.default_rng(args.seed), []
    for k in range(args.polygons):
        corners = CORNERS[k % len(CORNERS)]
        scenario = parse_scenario(random_task(rng, corners, f'{args.seed}-{k:02}-{corners}gon'))
        request = PlanRequest(time_budget=args.time_budget)
        map_options = MapOptions(request, half_range=args.range)
        one = {'name': scenario.name, **make_map(scenario, map_options, args.jobs)}
        for level in args.levels:
            options = SuiteOptions(request, perturb=level, attempts=args.attempts)
            draws = np.random.default_rng([args.seed, k])
            one[f'level {level:g}'] = run_sequences(
                scenario, draws, options, args.sequences, args.faces
            )
            one[f'unknown, level {level:g}'] = run_unknown(
                scenario, draws, options, args.range, args.unknown
            )
        made.append(one)
        print(
            json.dumps({key: v for key, v in one.items() if 'level ' not in key}),
            flush=True,
        )
        if args.json:
            args.json.write_text(json.dumps(made, indent=1))
        for level in args.levels:
            faces = [one for m in made for sequence in m[f'level {level:g}'] for one in sequence]
            print(f'  level {level:g}: {tell(faces)}', flush=True)
            unknown = [one for m in made for one in m[f'unknown, level {level:g}']]
            right = sum(one['felt_at_start'] == one['start']['edge'] for one in unknown)
            wrong = sum(one['felt_at_start'] not in (None, one['start']['edge']) for one in unknown)
            print(
                f'  level {level:g}, start not told: {right} of {len(unknown)} found, {wrong} felt wrongly; '
                f'{tell(unknown)}',
                flush=True,
            )


def tell(faces: list) -> str:
    """What was reached of what was asked."""
    known = [f for f in faces if f['known']]
    wrong = sum(f['claimed'] == 'at_goal' and not f['executed'] for f in faces)
    return (
        f'{sum(f["executed"] for f in faces)} of {len(faces)} faces reached, '
        f'{sum(f["executed"] for f in known)} of {len(known)} that the map knows a way to; '
        f'{sum(f["claimed"] == "lost" for f in faces)} lost, {wrong} false successes'
    )


if __name__ == '__main__':
    main()
