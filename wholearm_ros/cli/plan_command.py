"""`wholearm plan`: contact states from start to goal, the trajectory through them, verified."""

from pathlib import Path
from typing import Annotated

import typer

from wholearm_ros.cli.options import (
    MIN_SUCCESS,
    TIME_BUDGET,
    BudgetOption,
    GoalEdgeOption,
    JsonOption,
    ScenarioName,
    SearchOption,
    SeedOption,
    SuccessOption,
    TransitionOption,
    level_option,
)
from wholearm_ros.cli.output import finish, print_plain, write_text
from wholearm_ros.cli.planning import advice_for, load_asked, plan_scenario
from wholearm_ros.model.choices import Search, Transition
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.report.figures.figures import write_search_figures


def plan(
    scenario: ScenarioName,
    goal_edge: GoalEdgeOption = None,
    seed: SeedOption = 0,
    search: SearchOption = Search.best,
    transition: TransitionOption = Transition.auto,
    time_budget: BudgetOption = TIME_BUDGET,
    min_success: SuccessOption = MIN_SUCCESS,
    hand_errors: Annotated[
        float,
        level_option(
            '--hand-errors', 'Errors of the hand in the samples of search and certificate.'
        ),
    ] = PlanRequest.hand_errors,
    json_out: JsonOption = None,
    figures: Annotated[
        Path | None,
        typer.Option('--figures', metavar='DIR', help='Draw what the search reached into DIR.'),
    ] = None,
) -> None:
    """Plan a scenario: contact states from start to goal, the trajectory through them, verified.

    Example: wholearm plan asymmetric_hexagon --seed 1 --json plan.json
    """
    request = PlanRequest(
        search=search.value,
        seed=seed,
        transition=transition.value,
        time_budget=time_budget,
        min_success=min_success,
        hand_errors=hand_errors,
    )
    result = plan_scenario(load_asked(scenario, goal_edge), request)
    if json_out:
        write_text(json_out, result.plan.to_json(), '--json')
    if figures is not None:
        for written in write_search_figures(figures, result.plan):
            print_plain(f'figure {written}')
    if result.trajectory is None:
        print_plain(advice_for(scenario))
    finish(result.trajectory is not None)
