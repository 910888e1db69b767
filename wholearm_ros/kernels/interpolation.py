"""Interpolation in compiled code: the polynomials of motion, and courses of a torque whose rate of
change is limited.
"""

from wholearm_ros.kernels import allocating, inlined
from wholearm_ros.model import interpolation

quintic = inlined(interpolation.quintic)
fade = inlined(interpolation.fade)
hermite = inlined(interpolation.hermite)


@allocating
def slew_limited(torque, start, step):
    """The torque (k,) with no more than `step` [N m] from one sample to the next and from `start`
    to the first.

    Rises and falls begin early enough to arrive in time, as the future is known: a backward and a
    forward pass.
    """
    out = torque.copy()
    for i in range(len(out) - 2, -1, -1):
        out[i] = min(max(out[i], out[i + 1] - step), out[i + 1] + step)
    before = start
    for i in range(len(out)):
        out[i] = min(max(out[i], before - step), before + step)
        before = out[i]
    return out


@allocating
def held_within(torque, low, high, step):
    """The slew-limited torque (k,) held inside a range (k,), (k,), by bounds that are slew-limited
    themselves; the middle of those where the range moves faster than that.
    """
    lower, upper, out = low.copy(), high.copy(), torque.copy()
    for i in range(len(out) - 2, -1, -1):
        lower[i], upper[i] = max(lower[i], lower[i + 1] - step), min(upper[i], upper[i + 1] + step)
    for i in range(1, len(out)):
        lower[i], upper[i] = max(lower[i], lower[i - 1] - step), min(upper[i], upper[i - 1] + step)
    for i in range(len(out)):
        if lower[i] > upper[i]:
            lower[i] = upper[i] = 0.5 * (lower[i] + upper[i])
        out[i] = min(max(out[i], lower[i]), upper[i])
    return out
