"""Beliefs: where the closed loop has brought each perturbed sample of a scenario, and the courses
that lead them on.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.kernels.geometry import left_the_hand
from wholearm_ros.kernels.rollout import Start
from wholearm_ros.kernels.switch_law import Course
from wholearm_ros.model.configuration import POSE, SIZE
from wholearm_ros.planning.problem import PlanningProblem
from wholearm_ros.rollout.parallel import parallel_map
from wholearm_ros.rollout.perturbed_samples import PerturbedSample, Run, follow_course
from wholearm_ros.rollout.primitive_rollout import Rest
from wholearm_ros.rollout.verification import MARGIN, MOST_BEYOND, SETTLE, most_beyond

SPREAD = 0.08  # in scaled coordinates, by which samples may differ from the plan
# [1/s] in scaled coordinates: speeds of the nominal sample at rest, from where primitives are
# simulated, and of others, which go on from where and as fast as they are
STILL, SLOW = 0.05, 0.5
LEFT_PRICE = 2.0  # of a sample that has left the hand, against one that rests elsewhere in it


@dataclass(frozen=True, eq=False)
class Belief:
    """states: q, v (5,) of each sample, the nominal one first, None for those that did not arrive;
    loss: share of those, the ones that have left the hand counted LEFT_PRICE times.
    """

    states: tuple[tuple[np.ndarray, np.ndarray] | None, ...]
    loss: float = 0.0


@dataclass(frozen=True, eq=False)
class Passage:
    """A course that leads from `rest`, after the velocity finger `finger` (−1 for none), to the
    pose `end` (3,); at_goal: whether that is the goal.
    """

    course: Course
    rest: Rest
    finger: int
    end: np.ndarray
    at_goal: bool


class Samples:
    """Common random numbers: the same perturbed samples on every passage.

    rollouts: how many were made so far; least: share of the samples that must arrive.
    """

    def __init__(
        self,
        problem: PlanningProblem,
        samples: Sequence[PerturbedSample],
        least: float,
        controls: ControlOptions,
    ) -> None:
        self._samples, self._controls, self._scale = samples, controls, problem.world.scale
        self._least = least
        self.rollouts = 0
        self.start = Belief(tuple((s.start, np.zeros(SIZE)) for s in samples))
        self._turns = [sample.goal.rotation - samples[0].goal.rotation for sample in samples]
        self._failures = np.zeros(len(samples), int)

    def after(self, passage: Passage, before: Belief) -> Belief | None:
        """The belief after a passage; None as soon as the nominal sample, or too many, are lost.

        The nominal sample goes first and alone, then those that failed most often.
        """
        states, total = list(before.states), len(before.states)
        alive = [k for k, state in enumerate(states) if state is not None]
        others = sorted(alive[1:], key=lambda k: -self._failures[k])
        lost, price = total - len(alive), before.loss
        for k, run in chain(*(self._runs(passage, before, group) for group in ([0], others))):
            if self._arrived(k, run, passage):
                states[k] = run.q, run.v
                continue
            states[k], lost = None, lost + 1
            price += (LEFT_PRICE if self._has_left(k, run) else 1.0) / total
            self._failures[k] += 1
            if k == 0 or total - lost < self._least * total:
                return None
        return Belief(tuple(states), price)

    def _runs(
        self, passage: Passage, before: Belief, numbers: list[int]
    ) -> Iterator[tuple[int, Run]]:
        """(number of a sample, its run along the passage)."""
        controls, settle = self._controls, SETTLE if passage.at_goal else 0.0

        def execute(k: int) -> Run:
            state = before.states[k]
            assert state is not None, 'only samples that have arrived go on'
            start = Start(*state, passage.rest.efforts, False, passage.finger)
            return follow_course(self._samples[k], passage.course, start, controls, settle)

        for k, run in zip(numbers, parallel_map(execute, numbers)):
            self.rollouts += 1
            yield k, run

    def _has_left(self, k: int, run: Run) -> bool:
        return bool(left_the_hand(self._samples[k].world, run.q))

    def _arrived(self, k: int, run: Run, passage: Passage) -> bool:
        """Whether a run ended at rest near the planned pose, turned as the edges of a perturbed
        object are.
        """
        speed = np.abs(run.v / self._scale).max()
        if run.stopped or run.stops_met.any() or speed > (SLOW if k else STILL):
            return False
        if most_beyond(self._samples[k], run) > MOST_BEYOND:
            return False
        if passage.at_goal:
            return not self._samples[k].goal.missing(run.q[POSE], MARGIN)
        off = run.q[POSE] - passage.end - [0.0, 0.0, self._turns[k]]
        return bool((np.abs(off) / self._scale[POSE] <= SPREAD).all())
