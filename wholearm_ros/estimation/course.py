"""Courses: whether both fingers went the way they go when the object arrives.

Edges that feel alike cannot be told apart once the object lies. What tells a turn from a slip back
is the way. The planner keeps the angles over time of samples that reach the goal, and of samples
that end on another edge (`ContactPlan.courses`, `ContactPlan.strayed`). A run arrived whose angles
are near those of a sample that did all the time, and that is like these rather than the others.
"""

import numpy as np

# [rad] of either angle, from the nearest sample that arrived: farther from all of them likeness
# means nothing. Right runs of the regular hexagon behind a bridge are up to 0.037 off.
NEAR = 0.06
# [rad] where no sample strayed, so nothing else tells: of 34 runs of two regular hexagons that
# ended on another edge, the nearest was 0.048 off.
NEAR_ALONE = 0.032
SLACK = 2  # rows by which the instants of two courses may differ
# [rad] by which any angle may differ from those of samples besides, standard deviation: the samples
# are of our own simulation.
DEVIATION = 0.005
LIKE = 0.6  # least likeness: 1 is that of the mean sample that arrives, 0 is half way


def went_as_planned(
    course: np.ndarray, courses: np.ndarray | None, strayed: np.ndarray | None
) -> bool:
    """Whether a run arrived, as far as the way tells.

    course (m, 2), courses (k, r, 2), strayed (s, r, 2) [rad], rows at the same period. Never where
    courses of either kind are not known.
    """
    if courses is None or strayed is None:
        return False
    if nearest_course(course, courses) >= (NEAR if len(strayed) else NEAR_ALONE):
        return False
    return likeness(course, courses, strayed) > LIKE


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


def likeness(course: np.ndarray, courses: np.ndarray, strayed: np.ndarray) -> float:
    """How a course lies between the means of those that arrived (1) and of those that strayed (−1),
    by their linear discriminant; infinite where none strayed.

    The discriminant weighs an instant by how far the two kinds differ there and how little each
    varies, so errors that all samples of a hand share hardly count. Shapes as above.
    """
    if len(strayed) == 0:
        return float('inf')
    arrived, astray = (c.reshape(len(c), -1) for c in (courses, strayed))  # (k, 2 r), (s, 2 r)
    mean, other = arrived.mean(axis=0), astray.mean(axis=0)
    spread = np.vstack([arrived - mean, astray - other])
    covariance = spread.T @ spread / len(spread) + DEVIATION**2 * np.eye(len(mean))
    apart = mean - other
    weights = np.linalg.solve(covariance, apart)
    run = course[: courses.shape[1]].ravel()
    return float(2.0 * weights @ (run - (mean + other) / 2.0) / (weights @ apart))
