"""GET_TORQUE: the torque of the torque-controlled finger, inside its range and never faster than its slew limit (III-B.6)."""
import numpy as np

from ..model.hand import CLOSING
from .options import ExecutionOptions

EDGE_MARGIN = 0.15  # of the range, kept free at both ends when it is too narrow for more


def quasi_static_torque(statics: np.ndarray, torque_finger: int, options: ExecutionOptions) -> np.ndarray:
    """Get_TorqueQuasiStatic: τ_min + τ_margin towards closing, held inside the range; (k,) [N m].

    statics: (k, 4) as `Followed.statics`. τ_min is the end of the range at which the finger presses least. Where the part
    of the range that is good with friction is empty, the middle of the two is the best there is.
    """
    sign = CLOSING[torque_finger]
    low, high = _pressing(statics[:, 0], statics[:, 1], sign)
    low_robust, high_robust = _pressing(statics[:, 2], statics[:, 3], sign)
    narrow = low_robust > high_robust
    middle = np.clip(0.5 * (low_robust + high_robust), low, np.maximum(low, high))
    low, high = np.where(narrow, middle, low_robust), np.where(narrow, middle, high_robust)
    width = high - low
    return sign * (low + np.minimum(options.torque_margin, options.range_fraction * width))


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
