"""What the controllers are told, what the joints report, and the options of control."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from wholearm_ros.kernels.control_law import ControlLaw, PdGains, TorqueSetpoint, VelocitySetpoint
from wholearm_ros.kernels.switch_law import SwitchLaw
from wholearm_ros.model.arrays import readonly

__all__ = [
    'ControlOptions',
    'Joints',
    'PdGains',
    'Setpoints',
    'TorqueSetpoint',
    'VelocitySetpoint',
    'readonly_pair',
]

Setpoints = tuple[VelocitySetpoint, TorqueSetpoint]  # of the two fingers, one each


@dataclass(frozen=True, eq=False)
class Joints:
    """What the hand measures. stamp [s]; angles, velocities, efforts: (2,) [rad, rad/s, N m], left
    then right; efforts are NaN where the drives measure none.

    Not refused when a number is not finite: the mode switch must see that and stop.
    """

    stamp: float
    angles: np.ndarray
    velocities: np.ndarray
    efforts: np.ndarray = field(default_factory=lambda: np.zeros(2))

    @property
    def finite(self) -> bool:
        """Whether every angle and velocity can be used."""
        return bool(np.isfinite(self.angles).all() and np.isfinite(self.velocities).all())

    @property
    def known_efforts(self) -> np.ndarray:
        """(2,) [N m], zero where none is measured."""
        return np.where(np.isfinite(self.efforts), self.efforts, 0.0)


@dataclass(frozen=True)
class ControlOptions:
    """Everything that may be tuned in control; the defaults are the ones in config/control.yaml.

    gains: chosen for a joint inertia of 0.0062 kg m² and 0 to 6 ms of actuation delay
    (docs/control.md);
    slew_limit [N m/s]: of the torque-controlled finger's effort; a step of 3 N m in one tick throws
    the object;
    ramp [s]: from the efforts and angles found at the start to the trajectory's first ones;
    handover [s]: in which a finger that becomes velocity-controlled is brought from where it is to
    where it should be;
    max_tracking_error [rad]: of the velocity-controlled finger; beyond it the run stops;
    stop_outside: whether a run that has left its trajectory's band stops; else that is only said;
    stale_after [s]: age of the joint state beyond which the run stops.
    """

    gains: PdGains = PdGains(kp=30.0, kd=0.85)
    slew_limit: float = 60.0
    ramp: float = 0.3
    handover: float = 0.1
    max_tracking_error: float = 0.25
    stop_outside: bool = False
    stale_after: float = 0.1

    def law(self, period: float) -> ControlLaw:
        """What the controllers obey; period [s]: of control."""
        return ControlLaw(self.gains, self.slew_limit, period)

    def switch_law(self) -> SwitchLaw:
        """What the mode switch obeys."""
        return SwitchLaw(self.ramp, self.handover, self.max_tracking_error, self.stop_outside)


def readonly_pair(values: ArrayLike) -> np.ndarray:
    """(2,) read-only. Raises ValueError when there are not two, or one is not finite."""
    return readonly(values, (2,))
