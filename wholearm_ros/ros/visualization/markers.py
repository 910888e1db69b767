"""Markers for RViz and Foxglove: the object, the palm, contacts with their normals, ghosts.

All of them are in the palm's frame, so that nothing needs to be configured.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from wholearm_ros.model.frame import placed
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.ros.interface.channels import PALM_FRAME
from wholearm_ros.simulation.contact_point import ContactPoint

Colour = tuple[float, float, float, float]  # red, green, blue, opacity
LINE, THIN = 0.002, 0.0006  # [m]
NORMAL_LENGTH = 0.03  # [m]
GHOSTS = 8  # poses of the plan that are drawn
MOST_CONTACTS = 8
OBJECT_COLOUR, PALM_COLOUR = (0.95, 0.6, 0.1, 1.0), (0.5, 0.5, 0.5, 1.0)
CONTACT_COLOUR, GHOST_COLOUR = (0.9, 0.1, 0.1, 1.0), (0.3, 0.6, 0.9, 0.5)
ESTIMATE_COLOUR = (0.1, 0.6, 0.3, 1.0)


def state_markers(
    scenario: Scenario, pose: np.ndarray, contacts: Sequence[ContactPoint]
) -> MarkerArray:
    """The object at `pose` (3,), the palm and the contacts now."""
    markers = [
        _line('object', 0, _outline(scenario, pose), LINE, OBJECT_COLOUR),
        _line('palm', 0, scenario.palm.vertices, LINE, PALM_COLOUR),
    ]
    for k in range(MOST_CONTACTS):
        if k < len(contacts):
            tip = contacts[k].point + NORMAL_LENGTH * contacts[k].normal
            markers.append(_arrow(k, contacts[k].point, tip))
        else:
            markers.append(_gone('contacts', k))
    return MarkerArray(markers=markers)


def plan_markers(scenario: Scenario, trajectory: ManipulationTrajectory) -> MarkerArray:
    """The object at a few poses of the trajectory."""
    rows = np.linspace(0, len(trajectory.poses) - 1, GHOSTS).round().astype(int)
    return MarkerArray(
        markers=[
            _line('plan', k, _outline(scenario, trajectory.poses[row]), THIN, GHOST_COLOUR)
            for k, row in enumerate(rows)
        ]
    )


def estimate_markers(scenario: Scenario, pose: np.ndarray | None) -> MarkerArray:
    """The object where the observer takes it to be (3,); nothing when it does not know."""
    if pose is None:
        return MarkerArray(markers=[_gone('estimate', 0)])
    outline = _outline(scenario, pose)
    return MarkerArray(markers=[_line('estimate', 0, outline, 2 * THIN, ESTIMATE_COLOUR)])


def _outline(scenario: Scenario, pose: np.ndarray) -> np.ndarray:
    """(n + 1, 2) [m]: the polygon at `pose`, closed."""
    outline = placed(scenario.object.polygon.vertices_about_centroid, pose)
    return np.vstack([outline, outline[:1]])


def _marker(namespace: str, number: int, kind: int, colour: Colour) -> Marker:
    marker = Marker(
        ns=namespace,
        id=number,
        type=kind,
        action=Marker.ADD,
        color=ColorRGBA(r=colour[0], g=colour[1], b=colour[2], a=colour[3]),
    )
    marker.header.frame_id = PALM_FRAME
    marker.pose.orientation.w = 1.0
    return marker


def _line(namespace: str, number: int, points: np.ndarray, width: float, colour: Colour) -> Marker:
    marker = _marker(namespace, number, Marker.LINE_STRIP, colour)
    marker.scale.x = width
    marker.points = _points(points)
    return marker


def _arrow(number: int, tail: np.ndarray, tip: np.ndarray) -> Marker:
    marker = _marker('contacts', number, Marker.ARROW, CONTACT_COLOUR)
    marker.scale.x, marker.scale.y = LINE, 2 * LINE  # shaft and head diameter
    marker.points = _points([tail, tip])
    return marker


def _gone(namespace: str, number: int) -> Marker:
    marker = Marker(ns=namespace, id=number, action=Marker.DELETE)
    marker.header.frame_id = PALM_FRAME
    return marker


def _points(rows: Iterable[np.ndarray]) -> list[Point]:
    return [Point(x=float(x), y=float(y)) for x, y in rows]
