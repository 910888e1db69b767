"""Planning as the commands do it: with progress on the terminal, and the verdict first when it is
printed.
"""

from pathlib import Path

from rich.markup import escape

from wholearm_ros.cli.output import err, out, print_plain
from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.plan import FORMAT, ContactPlan
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.model.yaml_text import read_text
from wholearm_ros.package_share import scenario_path
from wholearm_ros.planner.planner import plan_and_verify
from wholearm_ros.planner.request import PlanRequest, PlanResult
from wholearm_ros.suite.suite_file import MAX_BYTES
from wholearm_ros.trajectory.main_trajectory import generate


def plan_scenario(name: str, request: PlanRequest) -> PlanResult:
    """Plan a scenario file, or a shipped scenario by name, and print what was found."""
    scenario = load_scenario(name)
    with err.status('planning') as status:
        result = plan_and_verify(
            scenario,
            request,
            progress=lambda line: status.update(f'planning: {escape(line)}'),
        )
    print_plan(result)
    return result


def print_plan(result: PlanResult) -> None:
    """The verdict on the first line; then the route, the counts of the search and the times."""
    plan, trajectory, verified = result.plan, result.trajectory, result.verification
    if trajectory is None or verified is None:
        out.print(f'[bold red]no plan[/] ({plan.outcome}): {escape(plan.reason)}', soft_wrap=True)
    else:
        survived = verified.to_dict()
        out.print(
            f'[bold green]plan found[/]: {trajectory.duration:.2f} s '
            f'along {len(plan.path)} subgoals; '
            f'{survived["survived"]} of {survived["copies"]} simulated samples reach the goal',
            soft_wrap=True,
        )
        if plan.certificate is not None:
            print_plain(f'certificate: {plan.certificate}')
        print_plain(f'id {plan.id}; {plan.reason}')
    counts = [f'{value} {name.replace("_", " ")}' for name, value in plan.counts.items()]
    times = [f'{k.removesuffix("_ms")} {v:.0f} ms' for k, v in result.timings.items()]
    print_plain(f'search: {", ".join(counts)}; {", ".join(times)}')


def read_plan(name: str) -> tuple[ContactPlan, ManipulationTrajectory] | None:
    """The plan document in the file `name` with its trajectory; None when the file is no plan
    document.
    """
    path = Path(name)
    if not path.exists() and scenario_path(name).is_file():
        return None
    text = read_text(path, MAX_BYTES)
    if FORMAT not in text[:200]:
        return None
    plan = ContactPlan.from_json(text)
    if not plan.found:
        raise WholeArmError(f'{path}: holds no plan: {plan.reason}; allowed: a plan that was found')
    return plan, generate(plan.scenario, plan)
