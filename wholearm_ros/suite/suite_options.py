"""How the tasks of a suite are planned and executed."""

from dataclasses import dataclass

from wholearm_ros.model.backends import DEFAULT_BACKEND
from wholearm_ros.planner.request import PlanRequest
from wholearm_ros.simulation.closed_loop import LoopOptions


@dataclass(frozen=True)
class SuiteOptions:
    """Options of planning, of the perturbations and of the simulated hand.

    request: how every task is planned; perturb: level of the perturbations, 0 for none; draws:
    perturbed runs of each plan; backend (or JURY) and loop: of the simulated hand; attempts:
    trajectories at most in each run; probe: whether the end of each is felt; the jury does neither;
    maps: whether goals without a direction are looked up in the object's map, if one was made;
    hand_errors: level of the errors of the hand, 0 for none.
    """

    request: PlanRequest = PlanRequest()
    perturb: float = 0.0
    draws: int = 1
    backend: str = DEFAULT_BACKEND
    loop: LoopOptions = LoopOptions()
    attempts: int = 1
    probe: bool = True
    maps: bool = True
    hand_errors: float = 0.0

    @property
    def perturbed(self) -> bool:
        """Whether the true hand or object is another one than planned with."""
        return self.perturb > 0.0 or self.hand_errors > 0.0

    @property
    def seed(self) -> int:
        """Of the search and of the perturbations."""
        return self.request.seed
