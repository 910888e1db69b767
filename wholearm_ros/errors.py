"""The errors of this package: one root, a child for each thing a caller can do about it."""


class WholeArmError(Exception):
    """Root of every error that this package raises on purpose."""


class ScenarioError(WholeArmError):
    """A scenario that cannot be used: says the file, the key, what was got and what is allowed."""


class DocumentError(WholeArmError):
    """A JSON document (plan, trajectory, suite) that is damaged, of another version or of another
    scenario.
    """


class SolverError(WholeArmError):
    """A numerical solver returned an answer that its own residual contradicts."""


class HardwareError(WholeArmError):
    """The hand, real or simulated, cannot do what was asked."""


class BagError(WholeArmError):
    """A bag that cannot be read or written."""
