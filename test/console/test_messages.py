"""What a page may send is read, whatever else is refused with a reason, and who may command is one page."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wholearm_ros.console.control import Control
from wholearm_ros.console.messages import PageError, Stop, Turn, id_of, read_message
from wholearm_ros.errors import WholeArmError

GOOD = [
    {'type': 'stop'},
    {'type': 'stop', 'drives': True, 'id': 3},
    {'type': 'turn', 'edge': 5},
    {'type': 'control', 'how': 'take'},
    {'type': 'record', 'on': False},
    {'type': 'replay', 'bag': '2026-11-28_10-00-00'},
]
BAD = [
    {'type': 'turn', 'edge': '5'},
    {'type': 'turn', 'edge': -1},
    {'type': 'turn'},
    {'type': 'stop', 'drives': 1},
    {'type': 'stop', 'more': 1},
    {'type': 'replay', 'bag': '../secret'},
    {'type': 'save', 'name': 'a/b', 'scenario': {}},
    {'type': 'eval', 'code': '1'},
    {'type': ['stop']},
    [],
    None,
    7,
]


@pytest.mark.parametrize('message', GOOD)
def test_what_is_allowed_is_read(message):
    assert read_message(json.dumps(message)).type == message['type']


@pytest.mark.parametrize('message', BAD)
def test_what_is_not_is_refused_with_what_was_got(message):
    with pytest.raises(PageError, match='got'):
        read_message(json.dumps(message))


@given(st.text() | st.binary().map(lambda b: b.decode('latin1')))
def test_any_text_is_read_or_refused(text):
    try:
        read_message(text)
    except WholeArmError as error:
        assert len(str(error)) < 700
    id_of(text)


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=9), inner, max_size=4)
    ),
)


@given(
    st.fixed_dictionaries(
        {'type': st.sampled_from(['stop', 'turn', 'check', 'save']) | VALUES},
        optional={
            'id': VALUES,
            'edge': VALUES,
            'drives': VALUES,
            'scenario': VALUES,
            'name': VALUES,
        },
    )
)
def test_any_json_is_read_or_refused(message):
    try:
        found = read_message(json.dumps(message))
    except PageError:
        return
    assert not isinstance(found, Turn) or 0 <= found.edge < 64
    assert not isinstance(found, Stop) or isinstance(found.drives, bool)


def test_an_answer_to_what_cannot_be_read_has_its_number():
    assert id_of('{"type": "dance", "id": 9}') == 9
    assert id_of('{"id": "9"}') is None and id_of('nothing') is None


def test_one_page_has_control_until_it_is_taken_given_up_or_gone():
    control, refusal = Control().asked(1)
    assert control.holder == 1 and not refusal and not control.refusal(1)
    same, refusal = control.asked(2)
    assert same.holder == 1 and 'page 1 has control' in refusal and same.refusal(2)
    taken, refusal = control.asked(2, take=True)
    assert taken.holder == 2 and not refusal and taken.refusal(1)
    assert taken.released(1) == taken and taken.released(2).holder is None
