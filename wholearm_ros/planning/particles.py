"""Particles: perturbed samples of the scenario that execute every primitive of a route in closed
loop, to tell whether physics does the same for all of them.
"""

import numpy as np

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.kernels.rollout import Start
from wholearm_ros.model.configuration import POSE, SIZE
from wholearm_ros.planning.problem import PlanningProblem
from wholearm_ros.rollout.parallel import parallel_map
from wholearm_ros.rollout.perturbed_samples import Run, build_perturbed_samples, follow_course
from wholearm_ros.rollout.primitive_rollout import PrimitiveRecord, Rest

PERTURBED = 3  # particles besides the nominal one
LEVEL = 1.0  # of their perturbations
SPREAD = 0.08  # in scaled coordinates, by which particles may differ from the plan
STILL = 0.05  # [1/s] in scaled coordinates, of a particle at rest
ParticleStates = tuple[tuple[np.ndarray, np.ndarray], ...]  # q, v (5,) of each particle


class Particles:
    """start: their states before the first primitive; rollouts: how many were made so far."""

    def __init__(self, problem: PlanningProblem, seed: int) -> None:
        self._scale, self._controls = problem.world.scale, ControlOptions()
        self._samples = build_perturbed_samples(problem.scenario, PERTURBED, LEVEL, seed)
        self.start: ParticleStates = tuple((s.start, np.zeros(SIZE)) for s in self._samples)
        self.rollouts = 0
        nominal = self._samples[0].goal.rotation
        self._turns = [sample.goal.rotation - nominal for sample in self._samples]

    def after(
        self, record: PrimitiveRecord, rest: Rest, states: ParticleStates, velocity_finger: int
    ) -> ParticleStates | None:
        """Their states after a primitive that was simulated from `rest`, or None as soon as one of
        them does not end like the plan.

        velocity_finger: of the primitive before, −1 when there was none.
        """
        course = record.course(rest)

        def execute(k: int) -> Run:
            q, v = states[k]
            start = Start(q, v, rest.efforts, False, velocity_finger)
            return follow_course(self._samples[k], course, start, self._controls)

        after = []
        planned = record.configurations[-1, POSE]
        for turn, run in zip(self._turns, parallel_map(execute, range(len(states)))):
            self.rollouts += 1
            if not self._agrees(run, planned, turn):
                return None
            after.append((run.q, run.v))
        return tuple(after)

    def _agrees(self, run: Run, planned: np.ndarray, turn: float) -> bool:
        """Whether a run ended at rest near the planned pose (3,), turned by `turn` [rad] as the
        edges of a perturbed object are.
        """
        if run.stopped or run.stops_met.any():
            return False
        far = (np.abs(run.q[POSE] - planned - [0.0, 0.0, turn]) / self._scale[POSE] > SPREAD).any()
        return not far and bool(np.abs(run.v / self._scale).max() <= STILL)
