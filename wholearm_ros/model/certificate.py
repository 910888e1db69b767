"""A certificate: how surely a plan succeeds, from fresh samples that had no part in choosing it."""

from dataclasses import asdict, dataclass

from scipy.special import betaincinv

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Certificate:
    """Of `samples` perturbed samples at `level`, `survived` ended at the goal; so, with that confidence, a run at that level
    succeeds with a probability of at least `lower_bound` (Clopper–Pearson, one-sided)."""

    level: float
    samples: int
    survived: int
    lower_bound: float
    confidence: float = CONFIDENCE

    def to_dict(self) -> dict[str, float]:
        return asdict(self)

    def __str__(self) -> str:
        return (
            f'{self.survived} of {self.samples} fresh samples at level {self.level:g} succeed, '
            f'success rate at least {self.lower_bound:.2f} ({self.confidence:.0%} confidence)'
        )


def certificate(level: float, samples: int, survived: int) -> Certificate:
    """With the Clopper–Pearson bound: the rate at which so many survivors have a probability of 1 − confidence."""
    return Certificate(level, samples, survived, lower_bound(samples, survived))


def lower_bound(samples: int, survived: int, confidence: float = CONFIDENCE) -> float:
    """Largest rate p such that `survived` or more of `samples` are no likelier than 1 − confidence; 0 without survivors."""
    if survived == 0:
        return 0.0
    return float(betaincinv(survived, samples - survived + 1, 1.0 - confidence))
