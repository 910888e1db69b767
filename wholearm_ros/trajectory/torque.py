"""GET_TORQUE: the torque of the torque-controlled finger, inside its range and never faster than its slew limit (III-B.6)."""
import numpy as np

from ..model.hand import CLOSING
from .options import ExecutionOptions


def quasi_static_torque(statics: np.ndarray, torque_finger: int, options: ExecutionOptions, limit: float) -> np.ndarray:
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
    return sign * np.clip(_within(slew_limited(torque, torque[0], step), low, high, step), -limit, limit)


def _within(torque, low, high, step):
    """The slew-limited torque held inside a range, by bounds that are slew-limited themselves; the range's middle where
    it moves faster than that."""
    for bound, better in ((low := low.copy(), max), (high := high.copy(), min)):
        change = step if better is min else -step
        for i in range(len(bound) - 2, -1, -1):
            bound[i] = better(bound[i], bound[i + 1] + change)
        for i in range(1, len(bound)):
            bound[i] = better(bound[i], bound[i - 1] + change)
    apart = low > high
    low[apart] = high[apart] = 0.5 * (low + high)[apart]
    return np.clip(torque, low, high)


def dynamic_torque(transition, torque_finger: int, options: ExecutionOptions, limit: float) -> float:
    """Get_TorqueDyn: τ_dyn = τ_max + τ_extra of the contact state before the transition [N m], within the motor's limit.

    transition: its TransitionReport. Whether it brings about the contact state wanted is for verification to say (Check_Dyn).
    """
    sign = CLOSING[torque_finger]
    _, high = _pressing(*transition.range_before, sign)
    return sign * min(high + options.extra_torque, limit)


def _pressing(low, high, sign):
    return (low, high) if sign > 0 else (-high, -low)


def slew_limited(torque: np.ndarray, start: float, step: float) -> np.ndarray:
    """The torque (k,) with no more than `step` [N m] from one sample to the next and from `start` to the first.

    Rises and falls begin early enough to arrive in time, as the future is known: a backward and a forward pass.
    """
    out = np.concatenate([[start], torque])
    for i in range(len(out) - 2, 0, -1):
        out[i] = min(max(out[i], out[i + 1] - step), out[i + 1] + step)
    for i in range(1, len(out)):
        out[i] = min(max(out[i], out[i - 1] - step), out[i - 1] + step)
    return out[1:]
