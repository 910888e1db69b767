"""Markers: what they draw is what is known."""

from dataclasses import replace

import numpy as np
import pytest
from visualization_msgs.msg import Marker

from wholearm_ros.model.certificate import certificate
from wholearm_ros.model.scenario import CCW, CW, GoalOnEdge, StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.planner.face_map import FaceMap, Way
from wholearm_ros.planning.routes import plan
from wholearm_ros.ros.visualization.markers import map_markers

SCENARIO = load_scenario('asymmetric_hexagon')
FACES = SCENARIO.object.polygon.resting_edges


def way(start, end, direction, survived):
    told = replace(plan(SCENARIO), certificate=certificate(1.0, 59, survived))
    return Way(
        StartOnEdge(start, 0.0), 0.006, GoalOnEdge(end, direction), StartOnEdge(end, 0.0), told
    )


def test_the_turns_of_a_map_are_arrows_as_wide_as_they_are_sure():
    sure, doubtful = way(0, 5, CCW, 59), way(5, 0, CW, 30)
    told = map_markers(SCENARIO, FaceMap(FACES, (way(0, 5, CCW, 40), sure, doubtful))).markers
    shown = {(m.ns, m.id): m for m in told if m.action == Marker.ADD}
    there, back = ('turns', 2 * 0), ('turns', 2 * 5 + 1)
    assert set(shown) == {('faces', face) for face in FACES} | {there, back}
    ratio = shown[there].scale.x / shown[back].scale.x
    assert ratio == pytest.approx(sure.success_rate / doubtful.success_rate)
    ways = [np.subtract(*[(p.x, p.y) for p in shown[k].points]) for k in (there, back)]
    assert ways[0] == pytest.approx(-ways[1])


def test_what_a_map_no_longer_knows_goes():
    told = map_markers(SCENARIO, FaceMap(FACES)).markers
    gone = {m.id for m in told if m.ns == 'turns' and m.action == Marker.DELETE}
    assert {2 * face + k for face in FACES for k in (0, 1)} <= gone
