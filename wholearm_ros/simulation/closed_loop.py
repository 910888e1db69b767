"""The closed loop without ROS: mode switch and controllers of the nodes, on a simulated hand."""

from dataclasses import dataclass, field

import numpy as np

from wholearm_ros.control.execution import Execution
from wholearm_ros.control.open_loop_torque import torque_effort
from wholearm_ros.control.pd_velocity import velocity_effort
from wholearm_ros.control.setpoints import (
    ControlOptions,
    Joints,
    TorqueSetpoint,
    VelocitySetpoint,
)
from wholearm_ros.kernels.control_law import ControlLaw
from wholearm_ros.model.backends import DEFAULT_BACKEND
from wholearm_ros.model.hand import Hand
from wholearm_ros.model.modes import DONE, STOPPED
from wholearm_ros.model.perturbation import NOMINAL, Perturbation
from wholearm_ros.model.probe import Probe
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.rollout.initial_state import perturbed_start
from wholearm_ros.simulation.factory import make_hand
from wholearm_ros.simulation.hand import HandBackend


@dataclass(frozen=True)
class LoopOptions:
    """rate [Hz]: of control and physics; settle [s]: how long the end is held, also after a stop;
    view: whether PyBullet shows its window.
    """

    rate: float = 1000.0
    controls: ControlOptions = ControlOptions()
    settle: float = 0.5
    view: bool = False


@dataclass(frozen=True, eq=False)
class RunRecord:
    """One run, a row a period.

    times: (m,) [s]; angles, velocities, efforts: (m, 2) measured and commanded, left then right
    [rad, rad/s, N m]; poses, object_velocities: (m, 3) the truth [m, m, rad] and their rates;
    modes: (m,) names; reason: why the switch stopped, '' when it did not; truth: the scenario with
    the perturbation applied; pairs: (2,) each [rad], what the probe measured; interrupted: why it
    ended early, '' when it did not; deviated: where and how the fingers left the trajectory's
    band, '' when they did not; in_band, course (r, 2) [rad]: see `Execution`.
    """

    times: np.ndarray
    angles: np.ndarray
    velocities: np.ndarray
    efforts: np.ndarray
    poses: np.ndarray
    object_velocities: np.ndarray
    modes: tuple[str, ...]
    reason: str
    truth: Scenario
    perturbation: Perturbation
    pairs: tuple[np.ndarray, ...] = ()
    interrupted: str = ''
    deviated: str = ''
    in_band: bool = False
    course: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))

    def time_in_modes(self) -> dict[str, float]:
        """Seconds in each mode that occurred, in order of appearance."""
        period = float(self.times[1] - self.times[0])
        return {mode: period * self.modes.count(mode) for mode in dict.fromkeys(self.modes)}


def run(
    scenario: Scenario,
    trajectory: ManipulationTrajectory,
    backend: str = DEFAULT_BACKEND,
    perturbation: Perturbation = NOMINAL,
    loop: LoopOptions = LoopOptions(),
    probe: Probe | None = None,
) -> RunRecord:
    """Execute `trajectory`, then hold its end.

    The object is set down where the perturbed scenario's start says, the fingers closed on it.
    scenario: as told to the planner; perturbation: what is truly different; probe: the motion that
    then feels where the object lies. Raises HardwareError when the backend is not there.
    """
    hand = make_hand(backend, scenario, loop.rate, perturbation, loop.view)
    try:
        hand.reset(perturbed_start(scenario, hand.scenario))
        execution = Execution(trajectory, loop.controls, loop.settle, probe)
        return lead(hand, execution, loop, perturbation)
    finally:
        hand.disconnect()


def commanded_efforts(
    hand: Hand, law: ControlLaw, motion: VelocitySetpoint, torque: TorqueSetpoint, joints: Joints
) -> np.ndarray:
    """(2,) [N m]: both controllers' answer to both setpoints.

    joints: as measured, with the efforts of the period before.
    """
    efforts = np.empty(2)
    v, t = motion.joint, torque.joint
    efforts[v] = velocity_effort(law.gains, hand[v], motion, joints.angles[v], joints.velocities[v])
    efforts[t] = torque_effort(hand[t], torque, joints.efforts[t], law.slew_limit, law.period)
    return efforts


def lead(
    hand: HandBackend, execution: Execution, loop: LoopOptions, perturbation: Perturbation
) -> RunRecord:
    """The execution on a hand as it is, to the end of its settling, and until its probe is over."""
    controls, fingers = loop.controls, hand.scenario.hand
    law = controls.law(hand.period)
    seconds = controls.ramp + execution.trajectory.duration + loop.settle
    steps = int(np.ceil(seconds * loop.rate))
    rows: list[np.ndarray] = []
    modes: list[str] = []
    previous = hand.efforts().copy()
    probing = execution.probe is not None
    while len(rows) < steps or (probing and not execution.over and not execution.reason):
        joints = Joints(hand.time, *hand.joints(), previous)
        motion, torque = execution.step(hand.time, joints)
        previous = commanded_efforts(fingers, law, motion, torque, joints)
        truth = (hand.object_pose(), hand.object_velocity())
        rows.append(np.hstack([hand.time, joints.angles, joints.velocities, previous, *truth]))
        modes.append(execution.shown)
        hand.step(previous)
    table = np.array(rows)
    return RunRecord(
        table[:, 0],
        table[:, 1:3],
        table[:, 3:5],
        table[:, 5:7],
        table[:, 7:10],
        table[:, 10:13],
        tuple(modes),
        execution.reason,
        hand.scenario,
        perturbation,
        execution.pairs,
        execution.interrupted,
        execution.deviated,
        execution.in_band,
        execution.course,
    )


def finished(record: RunRecord) -> bool:
    """Whether the trajectory was led to its end without a stop."""
    return record.modes[-1] == DONE and STOPPED not in record.modes
