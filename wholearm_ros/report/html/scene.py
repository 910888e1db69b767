"""The hand and the object as a page draws them: outlines in their own frames [mm], and what is to
be seen of the plane.
"""

from typing import Any

import numpy as np

from wholearm_ros.model.scenario import Scenario
from wholearm_ros.report.figures.outlines import view_box


def scene(scenario: Scenario, poses: np.ndarray, angles: np.ndarray) -> dict[str, Any]:
    """Fingers along +x from their axes, the object about its centroid; the box holds poses (m, 3)
    and angles (m, 2).
    """
    left, right, bottom, top = view_box(scenario, poses, angles)
    fingers = []
    for finger in (scenario.hand.left, scenario.hand.right):
        fingers.append(
            {
                'axis': numbers(1e3 * finger.axis, 2),
                'outline': numbers(1e3 * finger.shape.outline, 2),
            }
        )
    return {
        'box': numbers(1e3 * np.array([left, -top, right - left, top - bottom]), 1),
        'fingers': fingers,
        'palm': numbers(1e3 * scenario.palm.vertices, 2),
        'object': numbers(1e3 * scenario.object.polygon.vertices_about_centroid, 2),
    }


def numbers(values: Any, digits: int) -> Any:
    """As lists for JSON, rounded; NaN becomes null."""

    def shown(value: Any) -> Any:
        if isinstance(value, list):
            return [shown(v) for v in value]
        return None if value != value else value

    return shown(np.round(np.asarray(values, dtype=float), digits).tolist())
