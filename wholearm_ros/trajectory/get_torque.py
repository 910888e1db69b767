"""GET_TORQUE: the torque of the torque-controlled finger, inside its range and never faster than
its slew limit (III-B.6).
"""

import numpy as np

from wholearm_ros.kernels.interpolation import held_within, slew_limited
from wholearm_ros.model.hand import CLOSING
from wholearm_ros.model.interpolation import Value
from wholearm_ros.trajectory.check_transition import TransitionReport
from wholearm_ros.trajectory.execution_options import ExecutionOptions


def quasi_static_torque(
    statics: np.ndarray, torque_finger: int, options: ExecutionOptions, limit: float
) -> np.ndarray:
    """Get_TorqueQuasiStatic: (k,) τ_min + τ_margin towards closing [N m], kept inside the range,
    slew-limited.

    statics: (k, 4) as `Followed.statics`; limit: of the motor [N m]. τ_min is the end of the range
    at which the finger presses least. Where the friction-robust part of the range is empty, the
    torque is the middle between its two ends. Where the range itself is empty, as for an instant
    near a singular configuration, the torque is interpolated between the samples that have one.
    """
    sign = CLOSING[torque_finger]
    low, high = _pressing(statics[:, 0], statics[:, 1], sign)
    low_robust, high_robust = _pressing(statics[:, 2], statics[:, 3], sign)
    none = (low > high) | (np.maximum(np.abs(low), np.abs(high)) > 2.0 * limit)
    narrow = low_robust > high_robust
    middle = np.clip(0.5 * (low_robust + high_robust), low, np.maximum(low, high))
    low, high = np.where(narrow, middle, low_robust), np.where(narrow, middle, high_robust)
    torque = low + np.minimum(options.torque_margin, options.range_fraction * (high - low))
    if none.any() and not none.all():
        places = np.arange(len(torque))
        for values in (torque, low, high):
            values[none] = np.interp(places[none], places[~none], values[~none])
    step = options.slew * options.period
    held = held_within(slew_limited(torque, torque[0], step), low, high, step)
    limited: np.ndarray = sign * np.clip(held, -limit, limit)
    return limited


def dynamic_torque(
    transition: TransitionReport, torque_finger: int, options: ExecutionOptions, limit: float
) -> float:
    """Get_TorqueDyn: τ_dyn = τ_max + τ_extra of the contact state before the transition [N m],
    within the limit of the motor [N m].

    Whether it brings about the contact state that is wanted is decided by Check_Dyn and by
    verification.
    """
    sign = CLOSING[torque_finger]
    _, high = _pressing(*transition.range_before, sign)
    return float(sign * min(high + options.extra_torque, limit))


def _pressing(low: Value, high: Value, sign: float) -> tuple[Value, Value]:
    """A range (numbers or arrays) as seen in the direction in which the finger closes."""
    return (low, high) if sign > 0 else (-high, -low)
