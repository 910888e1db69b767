"""The document wholearm-contact-plan/1: there and back without loss, and whatever is damaged is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from problems import ASYMMETRIC, REGULAR, SQUARE

from wholearm_ros.errors import DocumentError
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.planning.routes import RANDOM, SearchOptions, plan

PLAN = plan(ASYMMETRIC)
TEXT = PLAN.to_json()
DOCUMENT = json.loads(TEXT)


@pytest.mark.parametrize(
    'made',
    [
        PLAN,
        plan(REGULAR, SearchOptions(RANDOM, 4)),
        plan(SQUARE),
        plan(ASYMMETRIC.mirrored()),
        PLAN.with_execution({'torque_margin': 1.5}),
        replace(PLAN, courses=np.ones((3, 4, 2)), strayed=np.zeros((2, 4, 2))),
        replace(PLAN, courses=np.ones((3, 4, 2)), strayed=np.empty((0, 4, 2))),
    ],
    ids=['best', 'random', 'none', 'clockwise', 'executed', 'strayed', 'none strayed'],
)
def test_a_plan_survives_its_document(made):
    """The same bytes, id and arrays."""
    read = ContactPlan.from_json(made.to_json())
    assert (
        read.to_json() == made.to_json() and read.id == made.id and read.summary() == made.summary()
    )
    np.testing.assert_array_equal(read.object_path(), made.object_path())


def test_the_id_is_of_the_content():
    assert PLAN.id == plan(ASYMMETRIC).id
    assert len({PLAN.id, plan(REGULAR).id, PLAN.with_execution({'torque_margin': 1.5}).id}) == 3


@given(st.integers(0, len(TEXT) - 1))
@settings(max_examples=60)
def test_a_truncated_document_is_refused(length):
    with pytest.raises(DocumentError):
        ContactPlan.from_json(TEXT[:length])


@given(st.integers(0, len(TEXT) - 1), st.characters(codec='ascii'))
@settings(max_examples=100)
def test_a_changed_byte_is_noticed(place, byte):
    """Refused, or (a digit beyond a double's precision, a space) still the very same plan."""
    damaged = TEXT[:place] + byte + TEXT[place + 1 :]
    try:
        read = ContactPlan.from_json(damaged)
    except DocumentError:
        return
    assert read.to_json() == TEXT


@given(st.binary(max_size=40))
@settings(max_examples=60)
def test_any_other_text_is_refused(data):
    with pytest.raises(DocumentError):
        ContactPlan.from_json(data.decode('latin-1'))


@pytest.mark.parametrize(
    'text',
    ['', 'null', '[]', '{}', '7', '"plan"', '[' * 100_000, '{"format": "wholearm-contact-plan/1"}'],
)
def test_what_is_no_plan_document_is_refused(text):
    with pytest.raises(DocumentError):
        ContactPlan.from_json(text)


def test_another_version_is_refused_by_name():
    with pytest.raises(DocumentError, match='wholearm-contact-plan/2'):
        ContactPlan.from_json(json.dumps({**DOCUMENT, 'format': 'wholearm-contact-plan/2'}))


def test_a_changed_number_is_an_id_that_does_not_match():
    changed = {**DOCUMENT, 'seed': DOCUMENT['seed'] + 1}
    with pytest.raises(DocumentError, match='id'):
        ContactPlan.from_json(json.dumps(changed))


@pytest.mark.parametrize('key', [k for k in DOCUMENT if k not in ('format', 'id')])
@pytest.mark.parametrize(
    'value', [None, 'x', 5, [], {}, [1], [[]], {'a': 1}, True, 1e999, 10**400], ids=str
)
def test_a_wrong_type_anywhere_at_the_top_is_refused(key, value):
    if DOCUMENT[key] == value:
        return
    with pytest.raises(DocumentError):
        ContactPlan.from_json(json.dumps({**DOCUMENT, key: value}))


@pytest.mark.parametrize(
    'value', [None, 'x', [], {}, float('nan'), 1e999, 10**400, [1.0, 2.0]], ids=lambda v: str(v)[:8]
)
def test_a_wrong_number_inside_is_refused(value):
    for place in ('subgoals', 'legs'):
        damaged = json.loads(TEXT)
        key = 'configuration' if place == 'subgoals' else 'configurations'
        damaged[place][0][key][0] = value
        with pytest.raises(DocumentError):
            ContactPlan.from_json(json.dumps(damaged))


@pytest.mark.parametrize('key', list(DOCUMENT))
def test_a_missing_key_is_refused(key):
    with pytest.raises(DocumentError):
        ContactPlan.from_json(json.dumps({k: v for k, v in DOCUMENT.items() if k != key}))
