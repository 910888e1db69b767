"""Any face to any face: maps of random polygons, and sequences of faces that one hand lays them on.

    python benchmarks/faces.py [--polygons 12] [--seed 1] [--sequences 2] [--faces 6] [--levels 1 2] [--attempts 4]
                               [--range 0.03] [--jobs 2] [--json OUT]

For each polygon the map is made (kept where `wholearm map` keeps it), then sequences of random faces, each another one
than the one before, are executed in PyBullet from a random face and place. Told: ordered pairs of faces with a
route, time of the map and of an answer, faces reached of those asked and of those that the map says can be reached from
where the object lay, objects lost, claims that were wrong.
"""

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from make_suite import CORNERS, random_task

from wholearm_ros.model.scenario import GoalOnEdge, StartOnEdge
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.planner.legs import LegPlanner, leg_of
from wholearm_ros.planner.map_making import MapOptions, slides_to_try, turns_to_try
from wholearm_ros.planner.map_store import MapStore
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


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--polygons', type=int, default=12)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--sequences', type=int, default=2)
    parser.add_argument('--faces', type=int, default=6)
    parser.add_argument('--levels', type=float, nargs='*', default=[1.0, 2.0])
    parser.add_argument('--attempts', type=int, default=4)
    parser.add_argument('--range', type=float, default=MapOptions.half_range)
    parser.add_argument('--jobs', type=int, default=2)
    parser.add_argument('--json', type=Path)
    args = parser.parse_args()
    rng, made = np.random.default_rng(args.seed), []
    for k in range(args.polygons):
        corners = CORNERS[k % len(CORNERS)]
        scenario = parse_scenario(random_task(rng, corners, f'{args.seed}-{k:02}-{corners}gon'))
        one = {
            'name': scenario.name,
            **make_map(scenario, MapOptions(half_range=args.range), args.jobs),
        }
        for level in args.levels:
            options = SuiteOptions(perturb=level, attempts=args.attempts)
            draws = np.random.default_rng([args.seed, k])
            one[f'level {level:g}'] = run_sequences(
                scenario, draws, options, args.sequences, args.faces
            )
        made.append(one)
        print(
            json.dumps({key: v for key, v in one.items() if not key.startswith('level')}),
            flush=True,
        )
        if args.json:
            args.json.write_text(json.dumps(made, indent=1))
        for level in args.levels:
            faces = [one for m in made for sequence in m[f'level {level:g}'] for one in sequence]
            print(f'  level {level:g}: {tell(faces)}', flush=True)


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
