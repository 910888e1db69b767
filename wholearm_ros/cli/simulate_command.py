"""`wholearm simulate`: execute a plan on a simulated hand, without ROS."""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from wholearm_ros.cli.options import (
    MIN_SUCCESS,
    TIME_BUDGET,
    BudgetOption,
    GoalEdgeOption,
    HandErrorsOption,
    JsonOption,
    JudgeOption,
    PerturbOption,
    SearchOption,
    SeedOption,
    SuccessOption,
    TransitionOption,
    ViewOption,
    output_file,
)
from wholearm_ros.cli.output import finish, out, print_plain, write_json, write_text
from wholearm_ros.cli.planning import load_asked, plan_scenario, read_plan
from wholearm_ros.model.backends import DEFAULT_BACKEND
from wholearm_ros.model.choices import Search, Transition
from wholearm_ros.planner.legs import leg_of, whole_task
from wholearm_ros.planner.request import PlanRequest, PlanResult
from wholearm_ros.report.run_document import run_document
from wholearm_ros.simulation.closed_loop import LoopOptions
from wholearm_ros.suite.execution import JudgedRun, execute
from wholearm_ros.suite.suite_options import SuiteOptions


def simulate(
    source: Annotated[
        str,
        typer.Argument(
            metavar='PLAN_OR_SCENARIO',
            help='A plan of `wholearm plan --json`, a scenario file, or the name of a shipped '
            'scenario.',
        ),
    ],
    goal_edge: GoalEdgeOption = None,
    seed: SeedOption = 0,
    perturb: PerturbOption = 0.0,
    hand_errors: HandErrorsOption = 0.0,
    search: SearchOption = Search.best,
    transition: TransitionOption = Transition.auto,
    time_budget: BudgetOption = TIME_BUDGET,
    min_success: SuccessOption = MIN_SUCCESS,
    backend: JudgeOption = DEFAULT_BACKEND,
    rate: Annotated[
        float, typer.Option('--rate', min=50.0, max=10000.0, help='Control rate in Hz.')
    ] = 1000.0,
    view: ViewOption = False,
    run_out: Annotated[
        Path | None, output_file('--run', 'Write the whole run here, for `wholearm report`.')
    ] = None,
    json_out: JsonOption = None,
) -> None:
    """Execute a plan on a simulated hand, without ROS; a scenario is planned first.

    Example: wholearm simulate asymmetric_hexagon --perturb 1 --seed 3
    """
    planned = read_plan(source)
    if planned is not None:
        plan, trajectory = planned
    else:
        request = PlanRequest(
            search=search.value,
            seed=seed,
            transition=transition.value,
            time_budget=time_budget,
            min_success=min_success,
        )
        result = plan_scenario(load_asked(source, goal_edge), request)
        if result.trajectory is None:
            finish(False)
        plan, trajectory = result.plan, result.trajectory
    loop = LoopOptions(rate, view=view)
    options = SuiteOptions(
        PlanRequest(seed=seed), perturb, backend=backend, loop=loop, hand_errors=hand_errors
    )
    asked = whole_task(plan)
    leg = leg_of(asked, PlanResult(plan, trajectory, {}))
    execution = execute(asked, leg, options)
    if json_out:
        write_json(json_out, _document(execution, trajectory.plan_id, options))
    if run_out:
        facts = {'source': 'wholearm simulate', 'backend': backend, 'perturbation': perturb}
        write_text(run_out, run_document(plan, trajectory, execution.record, facts), '--run')
    _print(execution)
    finish(execution.judged.executed)


def _document(execution: JudgedRun, plan_id: str, options: SuiteOptions) -> dict[str, Any]:
    judged = execution.judged
    jury = {} if execution.verdict is None else {'jury': execution.verdict.to_dict()}
    return {
        **jury,
        'name': execution.scenario.name,
        'plan_id': plan_id,
        'seed': options.seed,
        'perturb': options.perturb,
        'hand_errors': options.hand_errors,
        'executed': judged.executed,
        'reason': judged.reason,
        'final_pose': judged.pose.tolist(),
        'angle_error': judged.angle_error,
        'gap': judged.gap,
        'modes': execution.record.time_in_modes(),
        'perturbation': execution.perturbation.to_dict(),
    }


def _print(execution: JudgedRun) -> None:
    """The verdict first, then how the run went."""
    record, judged = execution.record, execution.judged
    if judged.executed:
        out.print('[bold green]at rest at the goal[/]')
    else:
        out.print('[bold red]not at the goal:[/]', end=' ')
        print_plain(judged.reason)
    for line in () if execution.verdict is None else execution.verdict.lines():
        print_plain(line)
    x, y, turn = judged.pose
    left, right = np.abs(record.efforts).max(axis=0)
    modes = [f'{mode} {seconds:.2f} s' for mode, seconds in record.time_in_modes().items()]
    print_plain(
        f'final pose: x {x:.4f} m, y {y:.4f} m, {turn:.4f} rad; '
        f'{judged.angle_error:+.4f} rad from the goal, {1e3 * judged.gap:+.2f} mm from the palm'
    )
    print_plain(f'modes: {", ".join(modes)}')
    print_plain(f'largest torques: left {left:.2f}, right {right:.2f} N m')
