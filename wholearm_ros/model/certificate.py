"""A certificate: how surely a plan succeeds, from fresh samples that did not help to choose it."""

from dataclasses import asdict, dataclass

from scipy.special import betaincinv

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Certificate:
    """Of `samples` samples perturbed at `level`, and with errors of the hand at the level
    `hand_errors`, `survived` reached the goal. With probability
    `confidence`, the success rate of a run at that level is therefore at least `lower_bound`
    (Clopper–Pearson, one-sided).
    """

    level: float
    samples: int
    survived: int
    lower_bound: float
    confidence: float = CONFIDENCE
    hand_errors: float = 0.0

    def to_dict(self) -> dict[str, float]:
        """The fields by name, for documents; `hand_errors` where there were some."""
        told: dict[str, float] = asdict(self)
        if not self.hand_errors:
            del told['hand_errors']
        return told

    def __str__(self) -> str:
        hand = f' (hand: {self.hand_errors:g})' if self.hand_errors else ''
        return (
            f'{self.survived} of {self.samples} fresh samples at level {self.level:g}{hand} succeed'
            f', success rate at least {self.lower_bound:.2f} ({self.confidence:.0%} confidence)'
        )


def certificate(level: float, samples: int, survived: int, hand_errors: float = 0.0) -> Certificate:
    """The certificate of `survived` out of `samples` samples at these levels."""
    bound = lower_bound(samples, survived)
    return Certificate(level, samples, survived, bound, hand_errors=hand_errors)


def lower_bound(samples: int, survived: int, confidence: float = CONFIDENCE) -> float:
    """Clopper–Pearson: the largest success rate at which at least `survived` of `samples` survive
    with a probability of at most 1 − confidence; 0 without survivors.
    """
    if survived == 0:
        return 0.0
    return float(betaincinv(survived, samples - survived + 1, 1.0 - confidence))
