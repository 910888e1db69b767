"""One run of the whole graph: separate processes, plan, goal, the object's final pose against its
goal.
"""

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Optional

import numpy as np

from wholearm_ros.launcher.client import Client
from wholearm_ros.launcher.processes import Processes, alone_in_domain
from wholearm_ros.model.backends import DEFAULT_BACKEND
from wholearm_ros.model.orientation import start_rotation
from wholearm_ros.model.perturbation import NOMINAL
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.ros.interface import channels
from wholearm_ros.simulation.closed_loop import RunRecord
from wholearm_ros.simulation.outcome import Outcome, outcome

START_WITHIN = 300.0  # [s] the first time, everything is compiled
# [s] beyond its own duration that a run may take in real time; lockstep takes what it takes
SLACK = 60.0
LOCKSTEP_SLOWNESS = 60.0
# of the nodes of the closed loop in real time, and of the recorder: kept waiting, it loses messages
LOOP_PRIORITY = 20


@dataclass(frozen=True)
class RunOptions:
    """What `wholearm run` was told. rate: of the motors [Hz]; record: directory of the bag, or
    None; topics: what goes into it, all when empty; time_budget: for planning [s].
    """

    scenario: str
    pacing: str = 'realtime'
    seed: int = 0
    record: Optional[Path] = None
    storage: str = 'mcap'
    topics: tuple = ()
    view: bool = False
    rate: float = 1000.0
    backend: str = DEFAULT_BACKEND
    search: str = 'best'
    transition: str = 'auto'
    probe: bool = True
    time_budget: float = 180.0


@dataclass(frozen=True, eq=False)
class RunReport:
    """planned: whether there was a plan; message: one line about it; planner: figures of the
    search; result: of the goal; judged: the object's pose against its goal, None when nothing was
    executed; modes: seconds in each, as planned; timings [s]: of start, planning and execution.
    """

    planned: bool
    message: str
    planner: dict
    result: dict
    judged: Optional[Outcome]
    modes: dict
    timings: dict
    path_length: int = 0

    @property
    def success(self) -> bool:
        return (
            self.judged is not None
            and self.judged.executed
            and self.result.get('outcome') == 'succeeded'
        )


def node_parameters(options: RunOptions) -> dict:
    """Parameters by node, in the order in which the nodes are started."""
    scenario, pacing = {'scenario': options.scenario}, {'pacing': options.pacing}
    loop = {'priority': LOOP_PRIORITY} if options.pacing == 'realtime' else {}
    nodes = {}
    if options.record:
        nodes['bag_recorder'] = {
            'path': str(options.record),
            'storage': options.storage,
            'priority': LOOP_PRIORITY,
            **({'topics': list(options.topics)} if options.topics else {}),
        }
    return {
        **nodes,
        'hand_hardware': {
            **scenario,
            **pacing,
            **loop,
            'backend': options.backend,
            'view': options.view,
            'motor_rate': options.rate,
        },
        'mode_switcher': {**pacing, **loop, 'probe': options.probe},
        'velocity_controller': {**scenario, **loop},
        'torque_controller': {**scenario, **loop, 'motor_rate': options.rate},
        'trajectory_generator': {},
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
    tell: Callable[..., None],
    log_directory: Path = None,
    on_client_ready: Callable[[Client], None] = lambda client: None,
) -> RunReport:
    """Raises DomainTaken at the start, NodeDied or GraphError when the graph breaks. `tell(line)`
    or `tell(line, progress)`, 0 to 1.

    on_client_ready: is given the client before anything happens, to listen to more of the run.
    """
    with alone_in_domain(), tempfile.TemporaryDirectory(prefix='wholearm_') as scratch:
        with Processes(Path(log_directory or scratch)) as processes:
            for node, parameters in node_parameters(options).items():
                processes.start(node, parameters)
            client = Client(watch=processes.check)
            try:
                on_client_ready(client)
                return _plan_and_execute(client, scenario, options, tell)
            finally:
                client.close()


def _plan_and_execute(client: Client, scenario, options, tell) -> RunReport:
    clock = [time.monotonic()]
    tell('starting the nodes')
    client.wait_for_graph(START_WITHIN)
    if options.record:
        client.wait(
            lambda: client.node.count_subscribers(channels.OBJECT_POSE.name) >= 2,
            START_WITHIN,
            'bag_recorder',
        )
    clock.append(time.monotonic())
    tell('planning')
    answer = client.call(channels.PLAN_SCENARIO, START_WITHIN + options.time_budget)
    clock.append(time.monotonic())
    tell(answer.message)
    latest = client.latest
    if not answer.success:
        return RunReport(False, answer.message, latest.planner, {}, None, {}, _timings(clock))
    client.wait(
        lambda: latest.plan and latest.trajectory and latest.trajectory.plan_id == latest.plan.id,
        SLACK,
        'manipulation_trajectory',
    )
    client.send_goal(latest.plan.id)
    _follow(client, options, tell)
    clock.append(time.monotonic())
    judged = _judge(client, scenario)
    return RunReport(
        True,
        answer.message,
        latest.planner,
        latest.result,
        judged,
        latest.trajectory.time_in_modes(),
        _timings(clock),
        len(latest.plan.path),
    )


def _follow(client: Client, options, tell) -> None:
    latest = client.latest
    slowness = LOCKSTEP_SLOWNESS if options.pacing == 'lockstep' else 1.0
    deadline = time.monotonic() + latest.trajectory.duration * slowness + SLACK
    while not latest.result:
        before = latest.feedback
        client.wait(
            lambda: latest.result or latest.feedback is not before,
            max(0.1, deadline - time.monotonic()),
            'trajectory_generator/result',
        )
        if latest.feedback.get('mode'):
            tell(latest.feedback['mode'], float(latest.feedback['progress'] or 0.0))
    tell(latest.result_message, 1.0)


def _judge(client: Client, scenario) -> Outcome:
    stamp = int(client.latest.result.get('stamp') or 0)
    times, poses = client.final_poses(stamp, SLACK)
    poses[:, 2] = np.unwrap(poses[:, 2])
    poses[:, 2] += 2 * np.pi * np.round((start_rotation(scenario) - poses[0, 2]) / (2 * np.pi))
    nothing = np.zeros((len(times), 2))
    reason = (
        ''
        if client.latest.result.get('outcome') == 'succeeded'
        else client.latest.result.get('reason', '')
    )
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


def _timings(clock) -> dict:
    names = ('start', 'plan', 'execute')
    return {name: b - a for name, a, b in zip(names, clock, clock[1:])}
