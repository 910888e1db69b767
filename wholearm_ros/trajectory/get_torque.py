"""GET_TORQUE: the torque of the torque-controlled finger, inside its range and never faster than its slew limit (III-B.6)."""

import numpy as np

from wholearm_ros.kernels.interpolation import held_within, slew_limited
from wholearm_ros.model.hand import CLOSING
from wholearm_ros.trajectory.execution_options import ExecutionOptions


def quasi_static_torque(
    statics: np.ndarray, torque_finger: int, options: ExecutionOptions, limit: float
) -> np.ndarray:
    """Get_TorqueQuasiStatic: τ_min + τ_margin towards closing, held inside the range, slew-limited; (k,) [N m].

    statics: (k, 4) as `Followed.statics`; limit: of the motor [N m]. τ_min is the end of the range at which the finger
    presses least. Where the part of the range that is good with friction is empty, the middle between the two is the best
    there is. Where there is no range at all, as for an instant near a singular configuration, the torque goes straight
    from one side of it to the other.
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
    return sign * np.clip(
        held_within(slew_limited(torque, torque[0], step), low, high, step), -limit, limit
    )


def dynamic_torque(
    transition, torque_finger: int, options: ExecutionOptions, limit: float
) -> float:
    """Get_TorqueDyn: τ_dyn = τ_max + τ_extra of the contact state before the transition [N m], within the motor's limit.

    transition: its TransitionReport. Whether it brings about the contact state wanted is for verification to say (Check_Dyn).
    """
    sign = CLOSING[torque_finger]
    _, high = _pressing(*transition.range_before, sign)
    return sign * min(high + options.extra_torque, limit)


def _pressing(low, high, sign):
    return (low, high) if sign > 0 else (-high, -low)
