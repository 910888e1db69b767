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

    search: best or random; seed: of the random search and of the perturbed samples; transition: dwell, dynamic or auto;
    limit: of expansions of the arc search; moves: how many dynamic primitives may be simulated where arcs alone do not do,
    0 for none; candidates: trajectories to try before giving up on the arcs, and again on the primitives (so that the answer
    does not depend on the machine); time_budget: [s] after which the search ends with what it has.

    samples, level: how many perturbed samples a candidate is rolled out on, and how strongly they are perturbed;
    target_success: success rate over them with which the search ends soon; least_success: with which the best candidate is
    still offered when none reached the target; early_stop_success: beyond which nothing better is looked for;
    improvement_budget: candidates to try for a better one after the first that reached the target;
    stress_levels, stress_samples: levels, and samples at each, on which ways to make the transitions are compared.

    certificate_samples, certificate_level: fresh samples on which the chosen candidate is certified, 0 for no certificate;
    min_success: least lower bound of its success rate with which it is offered; certifications: candidates that may be
    refused before the search gives up.
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


@dataclass(frozen=True, eq=False)
class PlanResult:
    """plan: always there, with a route or the reason why there is none; trajectory: verified, or None;
    timings: plan_ms, generate_ms, verify_ms; verification: of the trajectory, or of the best one that was not good enough."""

    plan: ContactPlan
    trajectory: ManipulationTrajectory | None
    timings: dict[str, float]
    verification: Verification | None = None
