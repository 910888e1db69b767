"""`wholearm map`: from which face to which an object can be turned in a hand, and how surely."""

import os
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from wholearm_ros.cli.options import JsonOption, ScenarioName, SeedOption, output_file
from wholearm_ros.cli.output import err, finish, print_plain, write_json, write_text
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.planner.face_map import FaceMap, Refused, Way
from wholearm_ros.planner.map_making import MapOptions, Stage, map_stages
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.report.html.map_page import map_page
from wholearm_ros.suite.map_work import try_ways

EPILOG = 'Exit codes: 0 at least one way was found, 1 none, 2 bad input.'


def map(
    scenario: ScenarioName,
    half_range: Annotated[
        float,
        typer.Option(
            '--range', min=0.0, max=1.0, help='Turns begin at x of at most this, either side [m].'
        ),
    ] = MapOptions.half_range,
    step: Annotated[
        float, typer.Option('--step', min=0.001, max=0.1, help='Between two such places [m].')
    ] = MapOptions.step,
    time_budget: Annotated[
        float, typer.Option('--time-budget', min=0.0, help='Seconds for each turn or slide.')
    ] = MapOptions().request.time_budget,
    seed: SeedOption = 0,
    jobs: Annotated[
        int | None,
        typer.Option(
            '--jobs', min=1, max=256, help='Processes.', show_default='one for each processor'
        ),
    ] = None,
    json_out: JsonOption = None,
    html: Annotated[Path | None, output_file('--html', 'Draw the map into this page.')] = None,
) -> None:
    """Make the map of an object in a hand: certified turns from face to face, and slides.

    It is kept, goes on where it was interrupted, and is used whenever a goal names an edge without
    a direction. Start and goal of the scenario play no part.

    Example: wholearm map asymmetric_hexagon --html map.html
    """
    told = load_scenario(scenario)
    options = MapOptions(
        PlanRequest(time_budget=time_budget, seed=seed),
        half_range=half_range,
        step=step,
        reach=0.6 * step,
    )
    store = MapStore(told)
    workers = jobs or os.cpu_count() or 1
    for stage in map_stages(told, options, store.load):
        _make(stage, store, workers)
    found = store.load()
    _print(found)
    print_plain(f'kept in {store.directory}')
    document = found.to_dict(told.name)
    if json_out:
        write_json(json_out, document)
    if html:
        write_text(html, map_page(told, found), '--html')
    finish(bool(found.ways))


def _make(stage: Stage, store: MapStore, workers: int) -> None:
    """Try what was not tried yet, each kept as soon as it is done."""
    total, untried = len(stage.wanted), store.untried(stage.wanted, stage.options.request.moves)
    if not untried:
        return
    columns = TextColumn(stage.name), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*columns, console=err, transient=True) as progress:
        bar = progress.add_task(stage.name, total=total, completed=total - len(untried))
        for tried in try_ways(untried, store, stage.options, workers):
            print_plain(_line(tried))
            progress.advance(bar)


def _line(tried: Way | Refused) -> str:
    start, goal = tried.start, tried.goal
    way = f'edge {start.edge} at {1e3 * start.x:+3.0f} mm'
    if goal.direction is None:
        assert goal.x is not None
        way += f' to {1e3 * goal.x:+3.0f} mm'
    else:
        way += f' {goal.direction:3} to edge {goal.edge}'
    if isinstance(tried, Refused):
        return f'{way}: no plan ({tried.reason.partition(":")[0]})'
    return f'{way}: {tried.plan.certificate}'


def _print(found: FaceMap) -> None:
    """How much of the map is there, and what cannot be reached."""
    turns = [way for way in found.ways if way.goal.direction]
    print_plain(
        f'{len(found.faces)} faces, {len(turns)} turns and {len(found.ways) - len(turns)} slides '
        f'with a certificate, {len(found.refused)} without a plan'
    )
    pairs = {(start.edge, face) for start, face, _ in found.all_pairs()}
    missing = [
        f'{a} to {b}' for a in found.faces for b in found.faces if a != b and (a, b) not in pairs
    ]
    asked = len(found.faces) * (len(found.faces) - 1)
    print_plain(
        f'{asked - len(missing)} of {asked} ordered pairs of faces'
        + (f'; none from {", ".join(missing)}' if missing else '')
    )
