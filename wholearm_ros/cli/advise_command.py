"""`wholearm advise`: the smallest change that gives a scenario without a plan one."""

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.markup import escape

from wholearm_ros.cli.options import (
    MIN_SUCCESS,
    GoalEdgeOption,
    JsonOption,
    ScenarioName,
    SeedOption,
    SuccessOption,
    output_file,
)
from wholearm_ros.cli.output import finish, out, print_plain, write_json
from wholearm_ros.cli.planning import load_asked, planning_shown
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.scenario_file import scenario_to_dict
from wholearm_ros.planner import advice
from wholearm_ros.planner.advice import Trial
from wholearm_ros.planner.legs import LegPlanner
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.planner.request import PlanRequest, PlanResult

FORMAT = 'wholearm-advice/1'
EPILOG = (
    'Exit codes: 0 it has a plan as it is, or with a change, 1 no change was found, 2 bad input.'
)
AS_IT_IS = 'as it is'


def advise(
    scenario: ScenarioName,
    goal_edge: GoalEdgeOption = None,
    seed: SeedOption = 0,
    time_budget: Annotated[
        float, typer.Option('--time-budget', min=0.0, help='Seconds for all changes together.')
    ] = 300.0,
    each: Annotated[
        float, typer.Option('--each', min=0.0, help='Seconds at most for one of them.')
    ] = 30.0,
    min_success: SuccessOption = MIN_SUCCESS,
    json_out: JsonOption = None,
    save: Annotated[Path | None, output_file('--save', 'Write the changed scenario here.')] = None,
) -> None:
    """Find the smallest single change that gives a scenario a plan: of the start's x, the
    direction, the axes' distance and height, the fingers' length.

    Changes are tried in the order of what they cost at the bench, first with arcs of contact states
    alone, then with motion primitives (first those whose arcs nearly sufficed), until one has a
    certified plan.

    Example: wholearm advise my.yaml --save better.json
    """
    asked = load_asked(scenario, goal_edge)
    request = PlanRequest(seed=seed, time_budget=min(each, time_budget), min_success=min_success)
    with planning_shown() as status:
        plain = LegPlanner(request, MapStore(asked)).plan(asked)
        _tell(AS_IT_IS, plain)
        tried: list[Trial] = []
        if plain.trajectory is None:
            left = time_budget - sum(plain.timings.values()) / 1e3
            shown = lambda line: status.update(escape(line))
            for trial in advice.advise(asked, request, left, shown):
                tried.append(trial)
                _tell(trial.change.what, trial.result, trial.primitives)
    best = tried[-1] if tried and tried[-1].works else None
    changed = best.change.scenario if best else asked if plain.trajectory is not None else None
    _conclude(plain, best, len(tried))
    if json_out:
        write_json(json_out, _document(asked, plain, tried, changed))
    if save and changed is not None:
        write_json(save, scenario_to_dict(changed), '--save')
        print_plain(f'scenario {save}')
    finish(changed is not None)


def _tell(what: str, result: PlanResult, primitives: bool = True) -> None:
    if result.trajectory is not None:
        print_plain(f'{what}: plan found; {_surety(result)}')
    else:
        how = '' if primitives else ', arcs alone'
        print_plain(f'{what}: no plan ({result.plan.outcome}{how})')


def _surety(result: PlanResult) -> str:
    return str(result.plan.certificate or 'without a certificate')


def _conclude(plain: PlanResult, best: Trial | None, tried: int) -> None:
    if plain.trajectory is not None:
        out.print('[bold green]no change is needed[/]')
    elif best is None:
        out.print(f'[bold red]no change found[/]: {tried} were tried in the time given')
    else:
        told = escape(f'{best.change.what}: {_surety(best.result)}')
        out.print(f'[bold green]change[/] {told}', soft_wrap=True)


def _document(
    asked: Scenario, plain: PlanResult, tried: list[Trial], changed: Scenario | None
) -> dict[str, Any]:
    """`wholearm-advice/1`; `scenario` is the one that has a plan, or null."""
    return {
        'format': FORMAT,
        'name': asked.name,
        AS_IT_IS.replace(' ', '_'): advice.told_of(plain),
        'tried': [trial.to_dict() for trial in tried],
        'change': tried[-1].change.what if tried and tried[-1].works else None,
        'scenario': scenario_to_dict(changed) if changed else None,
    }
