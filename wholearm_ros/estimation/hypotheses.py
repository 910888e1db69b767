"""Hypotheses: the ways in which the object of a scenario may lie in the hand, and which of them no
finger can tell apart.
"""

from wholearm_ros.estimation.squeeze import Resting, SqueezeModel
from wholearm_ros.model.polygon import ALIKE, Polygon, same_outlines

# Share of an edge's length by which the centroid may stand beside it: the true object's may not.
NEARLY_STABLE = 0.06


def resting_hypotheses(model: SqueezeModel) -> tuple[Resting, ...]:
    """Each edge that can carry the object, or nearly, upon each segment of the
    palm.
    """
    polygon, palm = model.scenario.object.polygon, model.scenario.palm
    edges = [k for k in range(len(polygon.vertices)) if _may_rest_on(polygon, k)]
    segments = range(len(palm.vertices) - 1)
    return tuple(model.resting(edge, segment) for segment in segments for edge in edges)


def alike(model: SqueezeModel, hypotheses: tuple[Resting, ...]) -> tuple[tuple[int, ...], ...]:
    """(tuple of places in `hypotheses`, ...): classes that feel the same, a regular polygon's edges
    for one.
    """
    polygon = model.scenario.object.polygon
    classes: list[list[int]] = []
    for k, one in enumerate(hypotheses):
        for members in classes:
            other = hypotheses[members[0]]
            if one.segment == other.segment and same_outlines(polygon, one.edge, other.edge, ALIKE):
                members.append(k)
                break
        else:
            classes.append([k])
    return tuple(tuple(members) for members in classes)


def _may_rest_on(polygon: Polygon, edge: int) -> bool:
    e = polygon.edges[edge]
    along = float((polygon.centroid - polygon.vertices[edge]) @ e / (e @ e))
    return -NEARLY_STABLE < along < 1.0 + NEARLY_STABLE
