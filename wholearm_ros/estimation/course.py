"""Courses: whether both fingers went the way they go when the object arrives.

Edges that feel alike cannot be told apart once the object lies. What tells a turn from a slip back
is the way: of samples that reach the goal the planner keeps the angles over time
(`ContactPlan.courses`), and a run whose angles are near those of one of them all the time did what
that one did.
"""

import numpy as np

# [rad] of either angle: of 34 runs of two regular hexagons that ended on another edge, from which
# this was also chosen, the nearest was 0.048 off.
NEAR = 0.032
FAIRLY_NEAR = 0.042  # enough where the fingers kept to the plan's band, too
SLACK = 2  # rows by which the instants of two courses may differ


def nearest_course(course: np.ndarray, courses: np.ndarray | None) -> float:
    """[rad] largest difference at any instant from the nearest of the courses (k, r, 2); infinite
    where there is none.

    course: (m, 2) [rad], its rows at the same period.
    """
    if courses is None or len(courses) == 0 or len(course) < courses.shape[1]:
        return float('inf')
    rows = np.arange(courses.shape[1])
    off = np.full(courses.shape[:2], np.inf)
    for shift in range(-SLACK, SLACK + 1):
        shifted = courses[:, np.clip(rows + shift, 0, rows[-1])]  # (k, r, 2)
        off = np.minimum(off, np.abs(shifted - course[: len(rows)]).max(axis=2))
    return float(off.max(axis=1).min())
