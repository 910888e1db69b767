"""The document wholearm-trajectory/2: whatever is damaged or inconsistent is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from problems import ASYMMETRIC

from wholearm_ros.errors import DocumentError
from wholearm_ros.model.band import Band
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.planning.routes import plan
from wholearm_ros.trajectory.execution_options import ExecutionOptions
from wholearm_ros.trajectory.main_trajectory import generate

MADE = generate(
    ASYMMETRIC, plan(ASYMMETRIC), ExecutionOptions(period=0.08)
)  # few samples: a small document
TEXT = MADE.to_json()
DOCUMENT = json.loads(TEXT)


@given(st.integers(0, len(TEXT) - 1))
@settings(max_examples=60)
def test_a_truncated_document_is_refused(length):
    with pytest.raises(DocumentError):
        ManipulationTrajectory.from_json(TEXT[:length])


@given(st.integers(0, len(TEXT) - 1), st.characters(codec='ascii'))
@settings(max_examples=80)
def test_a_changed_byte_is_refused_or_leaves_a_consistent_trajectory(place, byte):
    """It has no id: a changed digit is another trajectory, but one of finite numbers, segments without gaps, equal lengths."""
    try:
        read = ManipulationTrajectory.from_json(TEXT[:place] + byte + TEXT[place + 1 :])
    except DocumentError:
        return
    assert (
        len(read.angles)
        == len(read.velocities)
        == len(read.efforts)
        == len(read.poses)
        == len(read.torque_ranges)
    )
    assert all(
        np.isfinite(values).all()
        for values in (read.angles, read.velocities, read.efforts, read.poses)
    )
    assert abs(read.segments[-1].end - read.duration) < 1e-6


@pytest.mark.parametrize('key', list(DOCUMENT))
def test_a_missing_key_is_refused(key):
    if key == 'joint_names':  # for readers: the order is fixed
        return
    with pytest.raises(DocumentError):
        ManipulationTrajectory.from_json(
            json.dumps({k: v for k, v in DOCUMENT.items() if k != key})
        )


@pytest.mark.parametrize(
    'change',
    [
        {'format': 'wholearm-trajectory/3'},
        {'period': 0.0},
        {'period': -1.0},
        {'period': 'x'},
        {'period': 10**400},
        {'angles': DOCUMENT['angles'][:-1]},
        {'angles': [[1.0]]},
        {'efforts': [[None, 1.0]] * len(DOCUMENT['efforts'])},
        {'segments': []},
        {'segments': DOCUMENT['segments'][1:]},
        {'segments': DOCUMENT['segments'][:-1]},
        {'segments': [{**DOCUMENT['segments'][0], 'mode': 'throwing'}, *DOCUMENT['segments'][1:]]},
        {
            'segments': [
                {**DOCUMENT['segments'][0], 'velocity_finger': 'middle'},
                *DOCUMENT['segments'][1:],
            ]
        },
        {'segments': [{**DOCUMENT['segments'][0], 'end': 0.0}, *DOCUMENT['segments'][1:]]},
        {'torque_ranges': [[10**400, 0.0]] * len(DOCUMENT['angles'])},
        {'plan_id': None},
        {'poses': []},
    ],
    ids=lambda c: next(iter(c)),
)
def test_an_inconsistent_document_is_refused(change):
    with pytest.raises(DocumentError):
        ManipulationTrajectory.from_json(json.dumps({**DOCUMENT, **change}))


@pytest.mark.parametrize('text', ['', 'null', '[]', '{}', '7', '[' * 100_000])
def test_what_is_no_trajectory_document_is_refused(text):
    with pytest.raises(DocumentError):
        ManipulationTrajectory.from_json(text)


BAND = Band(0.02, np.zeros((3, 2)), np.ones((3, 2)), 0.2)


def test_a_band_is_read_back_and_a_document_without_one_has_none():
    read = ManipulationTrajectory.from_json(replace(MADE, band=BAND).to_json()).band
    np.testing.assert_array_equal([read.low, read.high], [BAND.low, BAND.high])
    assert (read.period, read.patience) == (BAND.period, BAND.patience)
    assert ManipulationTrajectory.from_json(TEXT).band is None


@pytest.mark.parametrize(
    'change',
    [
        {'low': [[0.0, 0.0]]},
        {'low': [[2.0, 0.0]] * 3},
        {'high': [[1.0]] * 3},
        {'period': 0.0},
        {'period': None},
        {'patience': -1.0},
        {'patience': 'long'},
    ],
)
def test_a_damaged_band_is_refused(change):
    document = {**DOCUMENT, 'band': {**BAND.to_dict(), **change}}
    with pytest.raises(DocumentError, match='band'):
        ManipulationTrajectory.from_json(json.dumps(document))
