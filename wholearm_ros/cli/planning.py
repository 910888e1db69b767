"""Planning as the commands do it: with progress on the terminal, and the verdict first when it is
printed.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.markup import escape
from rich.status import Status

from wholearm_ros.cli.output import err, out, print_plain
from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.plan import FORMAT, ContactPlan
from wholearm_ros.model.scenario import GoalOnEdge, Scenario
from wholearm_ros.model.scenario_file import load_scenario, parse_scenario, scenario_to_dict
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.model.yaml_text import read_text
from wholearm_ros.package_share import scenario_path
from wholearm_ros.planner.legs import LegPlanner
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.planner.request import PlanRequest, PlanResult
from wholearm_ros.planner.warm import warm
from wholearm_ros.rollout.verification import Verification
from wholearm_ros.suite.suite_file import MAX_BYTES
from wholearm_ros.trajectory.main_trajectory import generate


def load_asked(name: str, goal_edge: int | None) -> Scenario:
    """A scenario file, or a shipped scenario by name, its goal replaced by what the command line
    asks for. Raises ScenarioError.
    """
    scenario = load_scenario(name)
    if goal_edge is None:
        return scenario
    return parse_scenario(
        {**scenario_to_dict(scenario), 'goal': {'edge': goal_edge}}, '--goal-edge'
    )


@contextmanager
def planning_shown() -> Iterator[Status]:
    """That something is being planned, on the terminal. Kernels are loaded first: where they have
    yet to be compiled, no time budget pays for it.
    """
    with err.status('loading kernels (the first time they are compiled, for a minute)') as status:
        warm()
        status.update('planning')
        yield status


def plan_scenario(scenario: Scenario, request: PlanRequest) -> PlanResult:
    """Plan a scenario, from its object's map where there is one, and print what was found."""
    with planning_shown() as status:
        result = LegPlanner(request, MapStore(scenario)).plan(
            scenario, lambda line: status.update(f'planning: {escape(line)}')
        )
    print_plan(result)
    return result


def print_plan(result: PlanResult) -> None:
    """The verdict on the first line; then the route, the counts of the search and the times."""
    plan, trajectory, verified = result.plan, result.trajectory, result.verification
    if trajectory is None:
        out.print(f'[bold red]no plan[/] ({plan.outcome}): {escape(plan.reason)}', soft_wrap=True)
    else:
        out.print(
            f'[bold green]plan found[/]: {trajectory.duration:.2f} s '
            f'along {len(plan.path)} subgoals; {_survived(verified)}',
            soft_wrap=True,
        )
        if plan.certificate is not None:
            print_plain(f'certificate: {plan.certificate}')
        print_plain(f'route: {_route(plan)}; plan {plan.id}')
        for line in _later_turns(plan):
            print_plain(line)
    counts = [f'{value} {name.replace("_", " ")}' for name, value in plan.counts.items()]
    times = [f'{k.removesuffix("_ms")} {v:.0f} ms' for k, v in result.timings.items()]
    print_plain(f'search: {", ".join(counts)}; {", ".join(times)}')


def _later_turns(plan: ContactPlan) -> list[str]:
    """What comes after the first turn of several."""
    if not plan.then:
        return []
    turns = [turn.scenario.goal for turn in (plan, *plan.then)]
    edges = ', then '.join(f'edge {g.edge}' for g in turns if isinstance(g, GoalOnEdge))
    return [
        f'this is the first turn of {len(turns)}: {edges}; the hand feels between two',
        f'certificate of all in a row: {plan.overall}',
    ]


def _route(plan: ContactPlan) -> str:
    """How sure its torques are; in the words of the search where it does not say."""
    margin = plan.cost.get('margin')
    if margin is None:
        return plan.reason
    if margin <= 0.0:
        return 'no torque margin at its narrowest place'
    return f'torque margin {margin:.3f} N m at its narrowest place'


def _survived(verified: Verification | None) -> str:
    if verified is None:
        return "from the object's map"
    told = verified.to_dict()
    return f'{told["survived"]} of {told["copies"]} simulated samples reach the goal'


def advice_for(scenario: str) -> str:
    """What to do next when the scenario of this name or file has no plan."""
    return f'wholearm advise {scenario} looks for the smallest change that has a plan'


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
