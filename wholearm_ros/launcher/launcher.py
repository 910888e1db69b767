"""One run of the whole graph: processes, plan, goal, the object's final pose against its goal."""

import json
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Optional

import numpy as np

from wholearm_ros.estimation.claim import Claim
from wholearm_ros.launcher.client import Client, GraphError, LatestMessages, Values
from wholearm_ros.launcher.processes import Processes, alone_in_domain
from wholearm_ros.model.backends import BACKENDS, DEFAULT_BACKEND
from wholearm_ros.model.choices import Hardware, Pacing, Storage
from wholearm_ros.model.modes import PLANNING
from wholearm_ros.model.orientation import goal_rotation, start_rotation
from wholearm_ros.model.outcomes import SUCCEEDED
from wholearm_ros.model.perturbation import NOMINAL, numbered_perturbation
from wholearm_ros.model.scenario import GoalOnEdge, Scenario
from wholearm_ros.model.scenario_file import scenario_to_dict
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.planner.supervision import MAX_ATTEMPTS
from wholearm_ros.ros.interface import channels
from wholearm_ros.simulation.closed_loop import RunRecord
from wholearm_ros.simulation.outcome import Outcome, outcome

Tell = Callable[..., None]  # of a line, and of the progress
START_WITHIN = 300.0  # [s] the first time, everything is compiled
# [s] beyond its own duration that a run may take in real time; lockstep takes what it takes
SLACK = 60.0
LOCKSTEP_SLOWNESS = 60.0
BRIDGE = 'ros2_control_bridge'
# Two of these would act on one hand.
COMMANDING = (
    BRIDGE,
    'hand_hardware',
    'mode_switcher',
    'velocity_controller',
    'torque_controller',
    'trajectory_generator',
)
ACTIVE_WITHIN = 20.0  # [s] once the graph is up: the broadcaster and the controller must be there
ANSWER_WITHIN = 30.0  # [s] of the supervisor to another scenario
LONGEST_SILENCE = 30.0  # [s] of the supervisor while it executes
# of the nodes of the closed loop in real time, and of the recorder: kept waiting, it loses messages
LOOP_PRIORITY = 20


@dataclass(frozen=True)
class RunOptions:
    """What `wholearm run` was told.

    rate: of the motors [Hz]; record: directory of the bag, or None; topics: what goes into it, all
    when empty; time_budget: for planning [s]; hardware: the physics of the simulated hand, none
    where a hand is there, or ros2_control; params: a parameter file for every node; then: faces to
    be reached after the scenario's goal, one after the other, without a reset; perturb,
    hand_errors: levels of the simulated hand's errors, those of number `seed`.
    """

    scenario: str
    pacing: str = Pacing.realtime.value
    seed: int = 0
    record: Optional[Path] = None
    storage: str = Storage.mcap.value
    topics: tuple[str, ...] = ()
    view: bool = False
    rate: float = 1000.0
    hardware: str = DEFAULT_BACKEND
    params: Optional[Path] = None
    search: str = PlanRequest.search
    transition: str = PlanRequest.transition
    probe: bool = True
    attempts: int = MAX_ATTEMPTS
    time_budget: float = PlanRequest.time_budget
    then: tuple[int, ...] = ()
    perturb: float = 0.0
    hand_errors: float = 0.0

    @property
    def simulated(self) -> bool:
        """Whether the hand is ours, and the truth about the object is known."""
        return self.hardware in BACKENDS

    def truth(self, scenario: Scenario) -> Scenario:
        """The scenario as the simulated hand has it."""
        drawn = numbered_perturbation(self.perturb, self.seed, scenario, self.hand_errors)
        return drawn.applied(scenario)


@dataclass(frozen=True, eq=False)
class RunReport:
    """What came of a run.

    planned: whether there was a plan; message: one line about it; planner: figures of the search;
    result: of the goal; judged: the object's pose against its goal, None when nothing was
    executed; modes: seconds in each, as planned; timings [s]: of start, planning and execution;
    attempts: in order, what was felt after each trajectory, and after a probe alone (planned:
    False); scenario: whose goal it was; before: reports of the goals before it in a sequence; left:
    faces of the sequence that were not tried any more.
    """

    scenario: Scenario
    planned: bool
    message: str
    planner: dict[str, str]
    result: dict[str, str]
    judged: Optional[Outcome]
    modes: dict[str, float]
    timings: dict[str, float]
    path_length: int = 0
    attempts: tuple[dict[str, Any], ...] = ()
    before: 'tuple[RunReport, ...]' = ()
    left: tuple[int, ...] = ()

    @property
    def reached(self) -> bool:
        """Whether this goal succeeded, and the object rests at it where the truth is known."""
        truly = self.judged is None or self.judged.executed
        return self.planned and truly and self.result.get('outcome') == SUCCEEDED

    @property
    def success(self) -> bool:
        """Whether all goals were reached."""
        return not self.left and all(one.reached for one in (*self.before, self))


def node_parameters(options: RunOptions) -> dict[str, dict[str, Any]]:
    """Parameters by node, in the order in which the nodes are started."""
    scenario, pacing = {'scenario': options.scenario}, {'pacing': options.pacing}
    loop = {'priority': LOOP_PRIORITY} if options.pacing == Pacing.realtime.value else {}
    nodes: dict[str, dict[str, Any]] = {}
    if options.record:
        nodes['bag_recorder'] = {
            'path': str(options.record),
            'storage': options.storage,
            'priority': LOOP_PRIORITY,
            **({'topics': list(options.topics)} if options.topics else {}),
        }
    if options.hardware == Hardware.ros2_control.value:
        nodes[BRIDGE] = {**scenario, **loop}
    if options.simulated:
        nodes['hand_hardware'] = {
            **scenario,
            **pacing,
            **loop,
            'backend': options.hardware,
            'view': options.view,
            'motor_rate': options.rate,
            'perturb': float(options.perturb),
            'hand_errors': float(options.hand_errors),
            'perturb_number': options.seed,
        }
    return {
        **nodes,
        'mode_switcher': {**pacing, **loop, 'probe': options.probe},
        'velocity_controller': {**scenario, **loop},
        'torque_controller': {**scenario, **loop, 'motor_rate': options.rate},
        'trajectory_generator': {**scenario},
        'reorientation': {**scenario, 'max_attempts': options.attempts},
        'object_observer': {**scenario},
        'contact_state_planner': {
            **scenario,
            'seed': options.seed,
            'search': options.search,
            'transition': options.transition,
            'time_budget': float(options.time_budget),
        },
    }


def run_graph(
    scenario: Scenario,
    options: RunOptions,
    tell: Tell,
    log_directory: Optional[Path] = None,
    on_client_ready: Callable[[Client], None] = lambda client: None,
) -> RunReport:
    """Start the graph, plan, execute, judge, stop the graph.

    Raises DomainTaken at the start, NodeDied or GraphError when the graph breaks. `tell(line)` or
    `tell(line, progress)`, 0 to 1.

    on_client_ready: is given the client before anything happens, to listen to more of the run.
    """
    with running_graph(node_parameters(options), log_directory, options.params) as client:
        on_client_ready(client)
        return _plan_and_execute(client, scenario, options, tell)


@contextmanager
def running_graph(
    parameters: dict[str, dict[str, Any]],
    log_directory: Optional[Path] = None,
    params: Optional[Path] = None,
) -> Iterator[Client]:
    """A client of the nodes that are named, each a process, until the context ends.

    parameters: by node, see `node_parameters`; log_directory: of their output, none is kept by
    default; params: a parameter file for all of them, which `parameters` override. Raises
    DomainTaken at the start, NodeDied when a node ends while the client waits.
    """
    with alone_in_domain(), tempfile.TemporaryDirectory(prefix='wholearm_') as scratch:
        with Processes(Path(log_directory or scratch)) as processes:
            for node, values in parameters.items():
                processes.start(node, values, params=params)
            client = Client(watch=processes.check)
            try:
                yield client
            finally:
                client.close()


def _plan_and_execute(
    client: Client, scenario: Scenario, options: RunOptions, tell: Tell
) -> RunReport:
    clock = [time.monotonic()]
    tell('starting the nodes')
    all_recorded = options.record is not None and not options.topics
    client.wait_for_graph(START_WITHIN, all_recorded)
    client.wait_until_alone([n for n in node_parameters(options) if n in COMMANDING])
    client.wait_for_subscribers(START_WITHIN, ((channels.OBJECT_POSE, 2 if options.record else 1),))
    client.wait_for_supervisor(START_WITHIN, all_recorded)
    if options.hardware == Hardware.ros2_control.value:
        tell('activating the motors')
        client.activate(BRIDGE, ACTIVE_WITHIN)
    clock.append(time.monotonic())
    done: list[RunReport] = []
    left, asked = list(options.then), scenario
    while True:
        report = _pursue(client, asked, options, tell, clock, again=bool(done))
        done.append(report)
        following = _from_felt(report) if left else None
        if following is None:
            return replace(report, before=tuple(done[:-1]), left=tuple(left))
        asked = replace(following, goal=GoalOnEdge(left.pop(0)))
        _configure(client, asked)
        clock = [time.monotonic()] * 2


def _configure(client: Client, scenario: Scenario) -> None:
    """Make it the supervisor's scenario; raises GraphError when that refuses it."""
    answer = client.tell_supervisor(json.dumps(scenario_to_dict(scenario)))
    client.wait(answer.done, ANSWER_WITHIN, 'reorientation/set_parameters')
    (result,) = answer.result().results
    if not result.successful:
        raise GraphError(f'reorientation refuses the scenario: {result.reason}')


def _from_felt(report: RunReport) -> Scenario | None:
    """The scenario with the start where the object was felt last; None when that is not known."""
    start = Claim.from_dict(report.result).place
    return None if start is None else replace(report.scenario, start=start)


def _pursue(
    client: Client,
    scenario: Scenario,
    options: RunOptions,
    tell: Tell,
    clock: list[float],
    again: bool,
) -> RunReport:
    """Until the supervisor has reached the scenario's goal, or given up.

    clock: when the graph was begun and was ready [s]; again: whether the object was turned before.
    """
    tell('planning')
    client.reorient()
    latest = client.latest
    planned_at = _follow(client, options, tell)
    clock = [*clock, planned_at, time.monotonic()]
    reached = latest.reached
    attempts = tuple(json.loads(reached.get('tries') or '[]'))
    if not attempts:
        reason, times = reached.get('reason', ''), _timings(clock[:3])
        return RunReport(scenario, False, reason, latest.planner, reached, None, {}, times)
    judged = None
    if options.simulated:
        judged = _judge(client, options.truth(scenario), again or len(attempts) > 1)
    return RunReport(
        scenario,
        True,
        latest.planner.get('message', ''),
        latest.planner,
        reached,
        judged,
        latest.trajectory.time_in_modes() if latest.trajectory else {},
        _timings(clock),
        len(latest.plan.path) if latest.plan else 0,
        attempts,
    )


def _follow(client: Client, options: RunOptions, tell: Tell) -> float:
    """Until the supervisor's result.

    Returns the instant [s] at which the first plan was there, or none could be made.
    """
    latest, planned_at, told = client.latest, 0.0, 0
    slowness = LOCKSTEP_SLOWNESS if options.pacing == Pacing.lockstep.value else 1.0
    while not latest.reached:
        before = latest.reorientation
        longest = START_WITHIN + options.time_budget
        if before.get('phase', PLANNING) != PLANNING:
            longest = LONGEST_SILENCE * slowness + SLACK
            planned_at = planned_at or time.monotonic()
        client.wait(partial(_has_news, latest, before), longest, 'reorientation/result')
        told = _tell(latest, tell, told)
    tell(latest.reached_message, 1.0)
    return planned_at or time.monotonic()


def _has_news(latest: LatestMessages, known: Values) -> bool:
    """Whether the supervisor has said something since its feedback was `known`."""
    return bool(latest.reached) or latest.reorientation is not known


def _tell(latest: LatestMessages, tell: Tell, told: int) -> int:
    """Attempts that have ended since `told` of them had, and what goes on; how many have."""
    now = latest.reorientation
    ended = json.loads((latest.reached or now).get('tries') or '[]')
    for place, attempt in enumerate(ended[told:], told + 1):
        tell(attempt_line(place, attempt))
    if now and not latest.reached:
        before = f'attempt {now["attempt"]} of {now["max_attempts"]}: ' if ended else ''
        doing = now['mode'] if now['phase'] != PLANNING else PLANNING
        if doing:
            tell(f'{before}{doing}', float(now.get('progress') or 0.0))
    return len(ended)


def attempt_line(place: int, attempt: dict[str, Any]) -> str:
    """What came of one motion of a run, for people."""
    kind = 'attempt' if attempt['planned'] else 'felt again'
    if attempt.get('stop', '') != '':
        kind += f' (to edge {attempt["stop"]}, on the way)'
    return f'{place}. {kind}: {attempt["claimed"] or attempt["outcome"]}: {attempt["reason"]}'


def _judge(client: Client, scenario: Scenario, several: bool) -> Outcome:
    """The object's true pose at the end against its goal.

    scenario: with the true object; several: whether there were several motions; then whole turns do
    not count.
    """
    reached = client.latest.reached
    times, poses = client.final_poses(int(reached.get('stamp') or 0), SLACK)
    poses[:, 2] = np.unwrap(poses[:, 2])
    wanted = start_rotation(scenario) - poses[0, 2]
    if several:
        wanted = goal_rotation(scenario) - poses[-1, 2]
    poses[:, 2] += 2 * np.pi * np.round(wanted / (2 * np.pi))
    nothing = np.zeros((len(times), 2))
    ended = reached.get('outcome') == SUCCEEDED or bool(reached.get('claimed'))
    reason = '' if ended else reached.get('reason', '')
    return outcome(
        scenario,
        RunRecord(
            times,
            nothing,
            nothing,
            nothing,
            poses,
            np.zeros_like(poses),
            ('',) * len(times),
            reason,
            scenario,
            NOMINAL,
        ),
    )


def _timings(clock: list[float]) -> dict[str, float]:
    names = ('start', 'plan', 'execute')
    return {name: b - a for name, a, b in zip(names, clock, clock[1:])}
