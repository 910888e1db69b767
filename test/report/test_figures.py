"""What the figures show is what the run did."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from problems import OF_SHAPES

from wholearm_ros.model.hand import CLOSING
from wholearm_ros.report.figures.figures import write_figures
from wholearm_ros.report.figures.mode_spans import executed_spans, key_instants, planned_spans
from wholearm_ros.report.figures.outlines import finger_outline, object_outline, touching
from wholearm_ros.report.run_view import controlled, errors, setpoints_at


def test_figures_are_written_and_not_empty(told, tmp_path):
    written = write_figures(tmp_path / 'new', *told)
    assert [path.name for path in written] == [
        'contact_states.png',
        'torque_and_angle.png',
        'film_strip.png',
        'animation.gif',
    ]
    for path in written:
        with Image.open(path) as image:
            assert len(image.convert('RGB').getcolors(maxcolors=1 << 20)) > 8
            assert path.suffix != '.gif' or image.n_frames > 40
        assert path.stat().st_size < 1 << 20


def test_executed_values_are_those_of_the_finger_in_that_role(told):
    _, trajectory, run = told
    both = controlled(trajectory, run)
    for t in (0.05, 0.4 * trajectory.duration, 0.9 * trajectory.duration):
        k = int(np.argmin(np.abs(run.times - t)))
        segment = trajectory.segment_at(run.times[k])
        side = segment.torque_finger
        assert both.torque_side[k] == side
        assert both.torque[k] == CLOSING[side] * run.efforts[k, side]
        assert both.angle[k] == run.angles[k, segment.velocity_finger]
        assert both.planned_angle[k] == pytest.approx(
            trajectory.sample(run.times[k]).angles[segment.velocity_finger], abs=1e-9
        )


def test_planned_torque_lies_in_the_range_that_is_hatched(told):
    both = controlled(*told[1:])
    low, high = both.torque_range.T
    known = np.isfinite(low)
    assert known.any()
    assert (both.planned_torque[known] > low[known] - 0.05).all() and (
        both.planned_torque[known] < high[known] + 0.05
    ).all()


def test_setpoints_are_the_trajectorys_own(told):
    trajectory = told[1]
    times = np.linspace(-0.2, trajectory.duration + 0.3, 101)
    efforts, angles = setpoints_at(trajectory, times)
    own = [trajectory.sample(t) for t in times]
    assert np.allclose(efforts, [s.efforts for s in own], atol=1e-9)
    assert np.allclose(angles, [s.angles for s in own], atol=1e-9)


def test_a_run_without_error_has_none(told):
    _, trajectory, run = told
    values = errors(trajectory, run)
    assert (
        0.0
        < values['velocity finger, RMS error'][0]
        <= values['velocity finger, largest error'][0]
        < 200.0
    )


def test_modes_cover_the_run_without_gaps(told):
    _, trajectory, run = told
    for spans, first, last in (
        (executed_spans(run), run.times[0], run.times[-1]),
        (planned_spans(trajectory), 0.0, trajectory.duration),
    ):
        assert spans[0][0] == first and spans[-1][1] == pytest.approx(last)
        assert all(a[1] == b[0] and a[2] != b[2] for a, b in zip(spans, spans[1:]))
    instants = key_instants(trajectory, run)
    assert 2 <= len(instants) <= 8 and (np.diff(instants) > 0.0).all()


def test_outlines_are_rigid(told):
    scenario = told[0].scenario
    finger = scenario.hand.left
    sides = np.linalg.norm(
        np.diff(finger_outline(finger, 1.1), axis=0, append=finger_outline(finger, 1.1)[:1]), axis=1
    )
    assert sorted(np.round(sides, 9)) == sorted(
        [2 * finger.shape.half_width] * 2 + [finger.shape.length] * 2
    )
    moved = object_outline(scenario, np.array([0.1, 0.2, 0.7]))
    assert np.allclose(
        moved.mean(axis=0),
        object_outline(scenario, np.array([0.1, 0.2, -0.7])).mean(axis=0),
        atol=0.02,
    )


def test_a_finger_of_several_parts_is_drawn_as_one_outline():
    finger = OF_SHAPES['hooked_fingers'].hand.left
    outline = finger_outline(finger, 0.0) - finger.axis
    np.testing.assert_allclose(finger_outline(finger, 0.5).shape, outline.shape)
    corners = np.vstack(finger.shape.parts)
    hidden = [[0.128, -0.003], [0.147, -0.003]]
    drawn = [any(np.allclose(p, c, atol=1e-7) for p in outline) for c in corners]
    assert [list(c) for c, seen in zip(corners, drawn) if not seen] == hidden
    assert len(outline) == 8, 'six corners, and two where the hook enters the shaft'


def test_what_touches_at_the_start_are_four_contacts_or_more(told):
    plan, _, run = told
    points, normals = touching(plan.scenario, plan.subgoals[0].configuration)
    assert len(points) >= 4 and np.allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert len(touching(plan.scenario, np.full(5, np.nan))[0]) == 0


def test_normals_point_into_the_object_and_each_pushing_feature_has_one(told):
    """At a finger's corner the pair with the edge on its far side is as near as the one that pushes."""
    plan, _, run = told
    seen = 0
    for pose, angles in zip(run.poses[::20], run.angles[::20]):
        points, normals = touching(plan.scenario, np.concatenate([pose, angles]))
        assert ((normals * (pose[:2] - points)).sum(axis=1) > 0.0).all()
        seen += len(points)
    assert seen > 3 * len(run.times[::20])


def test_a_range_in_which_nothing_bears_the_object_is_not_hatched(told):
    """Its ends the wrong way round, low above high: turned over it would look like the widest of all."""
    _, trajectory, run = told
    empty = replace(trajectory, torque_ranges=trajectory.torque_ranges[:, ::-1])
    assert np.isfinite(controlled(trajectory, run).torque_range).any()
    assert np.isnan(controlled(empty, run).torque_range).all()
