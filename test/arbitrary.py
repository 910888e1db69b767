"""Hypothesis strategies for any message or request class, from its own description."""

from hypothesis import strategies as st
from rosidl_parser.definition import (
    AbstractNestedType,
    AbstractString,
    Array,
    BasicType,
    BoundedSequence,
    NamespacedType,
)

from wholearm_ros.model.hand import JOINT_NAMES

INTEGERS = {
    f'{sign}int{bits}': (
        0 if sign else -(2 ** (bits - 1)),
        2**bits - 1 if sign else 2 ** (bits - 1) - 1,
    )
    for sign in ('', 'u')
    for bits in (8, 16, 32, 64)
}
WORDS = (
    *JOINT_NAMES,
    '',
    'palm',
    'object',
    'done',
    'stopped',
    'idle',
    'quasi_static',
    '{}',
    '[1',
    'null',
)
texts = st.one_of(
    st.sampled_from(WORDS),
    st.text(st.characters(exclude_characters='\0', exclude_categories=['Cs']), max_size=12),
)


def messages(kind: type):
    """Any instance of the message or request class `kind`, its sequences no longer than three."""
    names = list(kind.get_fields_and_field_types())
    return st.builds(
        kind, **{name: _values(described) for name, described in zip(names, kind.SLOT_TYPES)}
    )


def _values(described):
    if isinstance(described, BasicType):
        return _basic(described.typename)
    if isinstance(described, AbstractString):
        return texts
    if isinstance(described, NamespacedType):
        return messages(_class_of(described))
    assert isinstance(described, AbstractNestedType), described
    least, most = 0, 3
    if isinstance(described, Array):
        least = most = described.size
    if isinstance(described, BoundedSequence):
        most = min(most, described.maximum_size)
    return st.lists(_values(described.value_type), min_size=least, max_size=most)


def _basic(name: str):
    if name == 'boolean':
        return st.booleans()
    if name == 'octet':
        return st.binary(min_size=1, max_size=1)
    if name in ('double', 'float'):
        return st.floats(width=64 if name == 'double' else 32)
    return st.integers(*INTEGERS[name])


def _class_of(described: NamespacedType) -> type:
    module = __import__('.'.join(described.namespaces), fromlist=[described.name])
    return getattr(module, described.name)
