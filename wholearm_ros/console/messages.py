"""What a page may send, and what of it needs control. Nothing else is understood."""

from typing import Annotated, Any, Literal, Union

from pydantic import BaseModel, ConfigDict, Field, Strict, TypeAdapter, ValidationError

from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.scenario_schema import Edge

MOST_BYTES = 512 * 1024  # of one message: an outline to import is the largest
SHOWN = 200  # characters of a refusal

Flag = Annotated[bool, Strict()]
Name = Annotated[str, Strict(), Field(pattern=r'^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$')]


class PageError(WholeArmError):
    """A message that is none of those below."""


class _Message(BaseModel):
    model_config = ConfigDict(extra='forbid', frozen=True)
    id: Annotated[int, Strict(), Field(ge=0, lt=2**31)] | None = None


class Stop(_Message):
    """Hold at once; drives: past every other node, until the reset."""

    type: Literal['stop']
    drives: Flag = False


class Control(_Message):
    """Ask for control, take it from whoever has it, or give it up."""

    type: Literal['control']
    how: Literal['ask', 'take', 'release']


class Turn(_Message):
    """Lay the object on an edge, by any way."""

    type: Literal['turn']
    edge: Edge


class Simple(_Message):
    """A command without more to say."""

    type: Literal['feel', 'cancel', 'reset', 'restart']


class Record(_Message):
    """Begin or end a bag."""

    type: Literal['record']
    on: Flag


class MakeMap(_Message):
    """Begin or end the making of a face map, of the object in the hand unless another is given."""

    type: Literal['map']
    on: Flag
    scenario: dict[str, Any] | None = None


class Check(_Message):
    """What is wrong with a scenario, if anything."""

    type: Literal['check']
    scenario: dict[str, Any]


class Load(_Message):
    """Put the object of a scenario into the simulated hand."""

    type: Literal['load']
    scenario: dict[str, Any]


class Save(_Message):
    """Keep a scenario in a file; replace: also one that is there."""

    type: Literal['save']
    name: Name
    scenario: dict[str, Any]
    replace: Flag = False


class Open(_Message):
    """The scenario of a file, or of those that ship."""

    type: Literal['open']
    name: Name


class Import(_Message):
    """The outline in a drawing."""

    type: Literal['import']
    kind: Literal['svg', 'dxf']
    text: Annotated[str, Strict()]


class Files(_Message):
    """The bags and the scenarios there are."""

    type: Literal['files']


class Replay(_Message):
    """The run in a bag."""

    type: Literal['replay']
    bag: Name


FromPage = Union[
    Stop,
    Control,
    Turn,
    Simple,
    Record,
    MakeMap,
    Check,
    Load,
    Save,
    Open,
    Import,
    Files,
    Replay,
]
NEED_CONTROL = (Turn, Simple, Record, MakeMap, Load, Save)
_ADAPTER: TypeAdapter[FromPage] = TypeAdapter(Annotated[FromPage, Field(discriminator='type')])


def read_message(text: str) -> FromPage:
    """Raises PageError that says what was got and what is allowed."""
    try:
        return _ADAPTER.validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        place = '.'.join(map(str, first['loc'])) or 'message'
        got = repr(first.get('input'))[:SHOWN]
        raise PageError(f'{place[:SHOWN]}: got {got}; {first["msg"][:SHOWN]}') from error


def id_of(text: str) -> int | None:
    """The number under which the page waits for an answer to a message that cannot be read."""
    try:
        return _Numbered.model_validate_json(text).id
    except ValidationError:
        return None


class _Numbered(BaseModel):
    id: Annotated[int, Strict(), Field(ge=0, lt=2**31)]
