"""Certification: a chosen candidate is run on fresh samples and given a certificate when the bound
of its success rate is good enough. Several turns in a row are run one after the other.
"""

from collections.abc import Sequence

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.model.certificate import Certificate, certificate, lower_bound
from wholearm_ros.model.configuration import X
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.planner.evaluation import Candidate
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.planner.stopwatch import VERIFY, Stopwatch
from wholearm_ros.rollout.courses import has_strayed
from wholearm_ros.rollout.perturbed_samples import (
    PerturbedSample,
    build_perturbed_samples,
    moved_sample,
)
from wholearm_ros.rollout.verification import Rollout, parallel_rollouts
from wholearm_ros.trajectory.main_trajectory import generate

STREAM = 59  # of the random numbers: apart from those of the samples that candidates are chosen on
IN_A_ROW = 61  # likewise, of several turns
HARDER = 67  # likewise, with larger errors
HARDER_LEVELS = (2.0, 3.0, 4.0, 6.0)
FEW = 5  # samples that stray: with fewer, the next level is tried, too
HARDER_SAMPLES = 50  # at each of them


class Certification:
    """best: the best certificate so far, or None; refused: how many candidates were refused;
    rollouts: those of the last candidate.
    """

    def __init__(
        self, scenario: Scenario, request: PlanRequest, controls: ControlOptions, watch: Stopwatch
    ) -> None:
        self.scenario, self.request, self.controls, self.watch = scenario, request, controls, watch
        self.best: Certificate | None = None
        self.refused = 0
        self.rollouts: list[Rollout] = []

    @property
    def given_up(self) -> bool:
        """Whether so many were refused that no further candidate is tried."""
        return self.refused >= self.request.certifications

    def certify(self, candidate: Candidate) -> Certificate | None:
        """Its certificate, or None when its bound is below `min_success`; every refusal changes the
        samples of the next call.
        """
        with self.watch.stage(VERIFY):
            found = self._run(candidate)
        if self.best is None or found.lower_bound > self.best.lower_bound:
            self.best = found
        if found.lower_bound >= self.request.min_success:
            return found
        self.refused += 1
        return None

    def _run(self, candidate: Candidate) -> Certificate:
        """On as many samples as were asked for; on fewer when the bound is out of reach, or the
        time is spent.
        """
        r, self.rollouts = self.request, []
        count, level = r.certificate_samples, r.certificate_level
        samples = _fresh_samples(self.scenario, r, count, level, (STREAM, self.refused))
        for rollout in parallel_rollouts(candidate.trajectory, samples, self.controls):
            self.rollouts.append(rollout)
            done, survived = len(self.rollouts), sum(r.success for r in self.rollouts)
            possible = survived + count - done
            if lower_bound(count, possible) < r.min_success or self.watch.over():
                break
        return certificate(level, done, survived, r.hand_errors)


def harder_rollouts(
    candidate: Candidate, scenario: Scenario, request: PlanRequest, controls: ControlOptions
) -> list[Rollout]:
    """On samples with larger errors than those of the certificate, so that some of them stray."""
    found: list[Rollout] = []
    for number, level in enumerate(HARDER_LEVELS):
        if sum(has_strayed(scenario, rollout) for rollout in found) >= FEW:
            break
        samples = _fresh_samples(scenario, request, HARDER_SAMPLES, level, (HARDER, number))
        found.extend(parallel_rollouts(candidate.trajectory, samples, controls))
    return found


def _fresh_samples(
    scenario: Scenario, request: PlanRequest, count: int, level: float, stream: tuple[int, ...]
) -> Sequence[PerturbedSample]:
    """Perturbed ones alone, of a stream of random numbers of their own."""
    seed, errors, x_error = (request.seed, *stream), request.hand_errors, request.start_x_error
    return build_perturbed_samples(scenario, count, level, seed, errors, x_error)[1:]


def certify_in_a_row(
    turns: Sequence[ContactPlan],
    request: PlanRequest,
    controls: ControlOptions = ControlOptions(),
) -> Certificate | None:
    """Of turns each of which begins where the one before ends: every fresh sample is the same hand
    and object in all of them, set between the fingers anew where it has come to rest. None when no
    certificates are asked for.
    """
    count, level = request.certificate_samples, request.certificate_level
    if not count:
        return None
    samples: Sequence[PerturbedSample] = build_perturbed_samples(
        turns[0].scenario, count, level, (request.seed, IN_A_ROW), request.hand_errors
    )[1:]
    ends: list[float] = []
    for number, turn in enumerate(turns):
        if number:
            samples = [moved_sample(turn.scenario, s, x) for s, x in zip(samples, ends)]
        done = list(parallel_rollouts(generate(turn.scenario, turn), samples, controls))
        samples = [s for s, rollout in zip(samples, done) if rollout.success]
        ends = [float(r.configurations[-1, X]) for r in done if r.success]
    return certificate(level, count, len(samples), request.hand_errors)
