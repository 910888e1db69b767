"""How the tasks of a suite are planned and executed."""

from dataclasses import dataclass, field

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.model.backends import DEFAULT_BACKEND
from wholearm_ros.planner.request import PlanRequest


@dataclass(frozen=True)
class SuiteOptions:
    """Options of planning, of the perturbations and of the simulated hand.

    seed: of the search and of the perturbations; perturb: their level, 0 for none; draws: perturbed
    runs a task; search, transition, candidates, moves, time_budget [s], min_success: of the
    planning request; backend (or JURY), rate [Hz]: of the hand; attempts: trajectories at most in
    each run; probe: whether the end of each is felt. The jury does neither.
    """

    seed: int = 0
    perturb: float = 0.0
    draws: int = 1
    search: str = 'best'
    transition: str = 'auto'
    candidates: int = PlanRequest.candidates
    moves: int = PlanRequest.moves
    time_budget: float = PlanRequest.time_budget
    min_success: float = PlanRequest.min_success
    backend: str = DEFAULT_BACKEND
    rate: float = 1000.0
    controls: ControlOptions = field(default_factory=ControlOptions)
    attempts: int = 1
    probe: bool = True

    def request(self) -> PlanRequest:
        """The planning request of every task."""
        return PlanRequest(
            search=self.search,
            seed=self.seed,
            transition=self.transition,
            candidates=self.candidates,
            moves=self.moves,
            time_budget=self.time_budget,
            min_success=self.min_success,
        )
