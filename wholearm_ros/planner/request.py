"""A verified planning call: what is asked for, and what is answered."""

from dataclasses import dataclass

from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.planning.routes import BEST, SearchOptions
from wholearm_ros.rollout.verification import Verification
from wholearm_ros.trajectory.execution_options import AUTO


@dataclass(frozen=True)
class PlanRequest:
    """What to plan with.

    search: 'best' or 'random'; seed: of the random search and of the perturbed samples; transition:
    'dwell', 'dynamic' or 'auto'; limit: of expansions in a graph of arcs; moves: how many
    simulations the search over states at rest may make, 0 for arcs only and no limit;
    candidates: trajectories to try before giving up, so that the answer does not depend on the
    machine; time_budget: after which the search ends with what it has [s].

    samples, level: perturbed samples on which a candidate is rolled out, and how strongly they are
    perturbed; target_success: success rate over them at which the search ends soon;
    least_success: share of the samples that must arrive in every state of the search, and at which
    the best candidate is still certified when none reached the target;
    early_stop_success: at which the search ends at once; improvement_budget: candidates to try for
    a better one after the first that reached the target; stress_levels, stress_samples: levels, and
    samples at each, on which ways to make the transitions are compared.

    certificate_samples, certificate_level: fresh samples on which the chosen candidate is
    certified, 0 for no certificate; min_success: least lower bound of its success rate with which
    it is given; certifications: candidates that may be refused before the search gives up.

    hand_errors: level of the errors of the hand (see HandErrors) in all these samples;
    start_x_error: how far from the told x [m] on its edge the object may lie at the start, in the
    perturbed samples and in those of the certificate.
    """

    search: str = BEST
    seed: int = 0
    transition: str = AUTO
    limit: int = SearchOptions.limit
    moves: int = SearchOptions.move_limit
    candidates: int = 100
    time_budget: float = 180.0
    samples: int = 12
    level: float = 1.4
    target_success: float = 0.8
    least_success: float = 0.65
    early_stop_success: float = 0.9
    improvement_budget: int = 30
    stress_levels: tuple[float, ...] = (2.0, 3.0)
    stress_samples: int = 4
    certificate_samples: int = 59
    certificate_level: float = 1.0
    min_success: float = 0.8
    certifications: int = 3
    hand_errors: float = 1.0
    start_x_error: float = 0.0


@dataclass(frozen=True, eq=False)
class PlanResult:
    """plan: with a route, or with the reason why there is none; trajectory: verified, or None;
    timings: plan_ms, generate_ms, verify_ms; verification: of the trajectory, or of the best one
    that was not good enough.
    """

    plan: ContactPlan
    trajectory: ManipulationTrajectory | None
    timings: dict[str, float]
    verification: Verification | None = None

    @property
    def success_rate(self) -> float:
        """Lower bound of its certificate, or without one its share over the samples that it was
        chosen on; −1 without a plan.
        """
        if self.trajectory is None:
            return -1.0
        if self.plan.certificate is not None:
            return self.plan.certificate.lower_bound
        return self.verification.success_rate if self.verification else 0.0

    @property
    def certain(self) -> bool:
        """Whether no other plan could do better on the samples of its certificate."""
        certificate = self.plan.certificate
        return (
            self.trajectory is not None
            and certificate is not None
            and certificate.survived == certificate.samples
        )
