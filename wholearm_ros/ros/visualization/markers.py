"""Markers for RViz and Foxglove: the object, the palm, contacts with their normals, ghosts.

All of them are in the palm's frame (`frame`), so that nothing needs to be configured.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from wholearm_ros.model.frame import placed
from wholearm_ros.model.scenario import CCW, CW, Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.planner.face_map import FaceMap
from wholearm_ros.report.figures.ring import outline_on_ring, ring_of_faces
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
TURN_COLOURS = {CCW: (0.2, 0.5, 0.8, 1.0), CW: (0.8, 0.4, 0.2, 1.0)}
RING, RING_CENTRE = 0.12, np.array([0.0, 0.38])  # [m] of the faces of a map, above the hand
BESIDE, SHORTENED = 0.06, 0.3  # of the ring's radius, and of an arrow's length at either end
MOST_FACES = 16


def state_markers(
    scenario: Scenario,
    pose: np.ndarray,
    contacts: Sequence[ContactPoint],
    frame: str = PALM_FRAME,
) -> MarkerArray:
    """The object at `pose` (3,), the palm and the contacts now."""
    markers = [
        _line('object', 0, _outline(scenario, pose), LINE, OBJECT_COLOUR),
        _line('palm', 0, scenario.palm.vertices, LINE, PALM_COLOUR),
    ]
    for k in range(MOST_CONTACTS):
        if k < len(contacts):
            tip = contacts[k].point + NORMAL_LENGTH * contacts[k].normal
            markers.append(_arrow('contacts', k, contacts[k].point, tip, LINE, CONTACT_COLOUR))
        else:
            markers.append(_gone('contacts', k))
    return _in_frame(frame, markers)


def plan_markers(
    scenario: Scenario, trajectory: ManipulationTrajectory, frame: str = PALM_FRAME
) -> MarkerArray:
    """The object at a few poses of the trajectory."""
    rows = np.linspace(0, len(trajectory.poses) - 1, GHOSTS).round().astype(int)
    return _in_frame(
        frame,
        [
            _line('plan', k, _outline(scenario, trajectory.poses[row]), THIN, GHOST_COLOUR)
            for k, row in enumerate(rows)
        ],
    )


def estimate_markers(
    scenario: Scenario, pose: np.ndarray | None, frame: str = PALM_FRAME
) -> MarkerArray:
    """The object where the observer takes it to be (3,); nothing when it does not know."""
    if pose is None:
        return _in_frame(frame, [_gone('estimate', 0)])
    outline = _outline(scenario, pose)
    return _in_frame(frame, [_line('estimate', 0, outline, 2 * THIN, ESTIMATE_COLOUR)])


def map_markers(scenario: Scenario, face_map: FaceMap, frame: str = PALM_FRAME) -> MarkerArray:
    """The object's faces in a ring above the hand, and the turns between them: the wider an arrow,
    the surer the turn.
    """
    polygon, markers = scenario.object.polygon, []
    centres = {face: RING * at + RING_CENTRE for face, at in ring_of_faces(polygon).items()}
    for face, centre in centres.items():
        outline = centre + RING * outline_on_ring(polygon, face)
        markers.append(_line('faces', face, np.vstack([outline, outline[:1]]), THIN, OBJECT_COLOUR))
    known = {
        (turn.start, turn.direction): (turn, way) for turn, way in face_map.best_turns().items()
    }
    for face in range(MOST_FACES):  # what an object before this one had goes
        markers += [] if face in centres else [_gone('faces', face)]
        for k, direction in enumerate((CCW, CW)):
            number = 2 * face + k
            if (face, direction) not in known:
                markers.append(_gone('turns', number))
                continue
            turn, way = known[face, direction]
            tail, tip = centres[turn.start], centres[turn.end]
            along = tip - tail
            beside = BESIDE * RING * np.array([along[1], -along[0]]) / np.linalg.norm(along)
            ends = tail + SHORTENED * along + beside, tip - SHORTENED * along + beside
            markers.append(
                _arrow('turns', number, *ends, LINE * way.success_rate, TURN_COLOURS[direction])
            )
    return _in_frame(frame, markers)


def _in_frame(frame: str, markers: list[Marker]) -> MarkerArray:
    for marker in markers:
        marker.header.frame_id = frame
    return MarkerArray(markers=markers)


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
    marker.pose.orientation.w = 1.0
    return marker


def _line(namespace: str, number: int, points: np.ndarray, width: float, colour: Colour) -> Marker:
    marker = _marker(namespace, number, Marker.LINE_STRIP, colour)
    marker.scale.x = width
    marker.points = _points(points)
    return marker


def _arrow(
    namespace: str, number: int, tail: np.ndarray, tip: np.ndarray, width: float, colour: Colour
) -> Marker:
    marker = _marker(namespace, number, Marker.ARROW, colour)
    marker.scale.x, marker.scale.y = width, 2 * width  # shaft and head diameter
    marker.points = _points([tail, tip])
    return marker


def _gone(namespace: str, number: int) -> Marker:
    return Marker(ns=namespace, id=number, action=Marker.DELETE)


def _points(rows: Iterable[np.ndarray]) -> list[Point]:
    return [Point(x=float(x), y=float(y)) for x, y in rows]
