"""Any face to any face: maps of random polygons, and sequences of faces that one hand lays them on.

    python benchmarks/faces.py [--polygons 12] [--seed 1] [--sequences 2] [--faces 6] [--unknown 2] [--levels 1 2]
                               [--attempts 4] [--range 0.03] [--time-budget 60] [--plan-budget 20] [--jobs 2] [--json OUT]

For each polygon, in one of `--jobs` processes, the map is made (kept where `wholearm map` keeps it), then sequences of random
faces, each another one than the one before, are executed in PyBullet from a random face and place. Then `--unknown` times the
object lies on any face, anywhere within the range; nobody is told, so the hand feels first, and turns it to another random face.
Told: ordered pairs of faces with a route, from any place and from three, time of the map and of an answer, faces reached of
those asked and of those that the map says can be reached from where the object lay, objects lost, claims that were wrong. Where
the map knows no way, a hand searches for `--plan-budget` seconds.
"""

import argparse
import json
import time
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from make_suite import CORNERS, random_task

from wholearm_ros.errors import ScenarioError
from wholearm_ros.mechanics.contacts import start_configuration
from wholearm_ros.model.scenario import GoalOnEdge, StartOnEdge
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.planner.legs import LegPlanner, leg_of
from wholearm_ros.planner.map_making import MapOptions, between, map_stages
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.simulation.outcome import outcome
from wholearm_ros.suite.execution import execute
from wholearm_ros.suite.map_work import try_ways
from wholearm_ros.suite.sequence import run_sequence
from wholearm_ros.suite.suite_options import SuiteOptions
from wholearm_ros.suite.workers import work_on

THREE_PLACES = -0.02, 0.0, 0.02  # [m] at which pairs of faces are counted


@dataclass(frozen=True)
class Asked:
    """Of every polygon."""

    map_options: MapOptions
    suite_options: SuiteOptions
    levels: tuple[float, ...]
    sequences: int
    faces: int
    unknown: int


def measure(task: tuple, asked: Asked) -> dict:
    """All of one polygon. task: (its scenario as a dictionary, seed of its draws)."""
    told, seed = task
    scenario = parse_scenario(told)
    one = {'name': scenario.name, **make_map(scenario, asked.map_options)}
    began = time.monotonic()
    for level in asked.levels:
        options, draws = replace(asked.suite_options, perturb=level), np.random.default_rng(seed)
        one[f'level {level:g}'] = run_sequences(
            scenario, draws, options, asked.sequences, asked.faces
        )
        one[f'unknown, level {level:g}'] = run_unknown(
            scenario, draws, options, asked.map_options.half_range, asked.unknown
        )
    one['runs_s'] = round(time.monotonic() - began, 1)
    return one


def make_map(scenario, options: MapOptions) -> dict:
    """Time [s], in all and of the processor, and what the map holds."""
    began, began_cpu, store = time.monotonic(), time.process_time(), MapStore(scenario)
    stages = []
    for stage in map_stages(scenario, options, store.load):
        stage_began = time.monotonic()
        untried = store.untried(stage.wanted, stage.options.request.moves)
        list(try_ways(untried, store, stage.options, 1))
        stages.append([stage.name, len(untried), round(time.monotonic() - stage_began, 1)])
    took, cpu = time.monotonic() - began, time.process_time() - began_cpu
    face_map = store.load()
    faces = face_map.faces
    pairs = {(start.edge, face) for start, face, _ in face_map.all_pairs()}
    began = time.monotonic()
    store.load().route(StartOnEdge(faces[0], 0.0), GoalOnEdge(faces[-1]))
    return {
        'map_s': round(took, 1),
        'map_cpu_s': round(cpu, 1),
        'stages': stages,
        'answer_ms': round(1e3 * (time.monotonic() - began), 2),
        'bytes': sum(f.stat().st_size for f in store.directory.glob('*.json')),
        'faces': len(faces),
        'pairs': len(pairs),
        'of': len(faces) * (len(faces) - 1),
        'pairs_at': {f'{1e3 * x:+.0f} mm': pairs_at(scenario, face_map, x) for x in THREE_PLACES},
        'ways': len(face_map.ways),
        'lower_bound': round(
            float(np.median([w.certificate.lower_bound for w in face_map.ways] or [0])), 3
        ),
    }


def pairs_at(scenario, face_map, x: float) -> list:
    """[ordered pairs of faces with a route from x on the first one, all that the hand allows]."""
    starts = [
        StartOnEdge(face, x)
        for face in face_map.faces
        if between(scenario, StartOnEdge(face, x), GoalOnEdge(face, None, x)) is not None
    ]
    reached = [set(face_map.routes(start)) - {start.edge} for start in starts]
    return [sum(map(len, reached)), len(starts) * (len(face_map.faces) - 1)]


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
        first = leg_of(begun, LegPlanner(options.request, store, in_a_row=False).plan(begun))
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
    parser.add_argument('--plan-budget', type=float, default=20.0)
    parser.add_argument('--jobs', type=int, default=2)
    parser.add_argument('--json', type=Path)
    args = parser.parse_args()
    rng, tasks = np.random.default_rng(args.seed), []
    for k in range(args.polygons):
        corners = CORNERS[k % len(CORNERS)]
        tasks.append(
            (random_task(rng, corners, f'{args.seed}-{k:02}-{corners}gon'), (args.seed, k))
        )
    asked = Asked(
        MapOptions(PlanRequest(time_budget=args.time_budget), half_range=args.range),
        SuiteOptions(PlanRequest(time_budget=args.plan_budget), attempts=args.attempts),
        tuple(args.levels),
        args.sequences,
        args.faces,
        args.unknown,
    )
    made: list[dict] = []
    work = partial(measure, asked=asked)
    for _, one in work_on(tasks, work, failed, min(args.jobs, len(tasks))):
        made.append(one)
        print(
            json.dumps({key: v for key, v in one.items() if 'level ' not in key}),
            flush=True,
        )
        if args.json:
            args.json.write_text(json.dumps(made, indent=1))
        tell_levels([m for m in made if 'error' not in m], args.levels)


def failed(task: tuple, why: str) -> dict:
    """Of a polygon whose worker died."""
    return {'name': task[0]['name'], 'error': why}


def tell_levels(made: list, levels: list) -> None:
    """What was reached at each level, of all polygons so far."""
    for level in levels:
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
