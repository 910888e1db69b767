"""Strict reading of small YAML or JSON files: bounded size, no aliases, no key twice."""

import re
from pathlib import Path
from typing import Any

import yaml

from wholearm_ros.errors import ScenarioError

MAX_BYTES = 256 * 1024  # a scenario is a few kB; more is a mistake


class _StrictLoader(yaml.SafeLoader):  # type: ignore[misc]  # PyYAML has no types
    """SafeLoader that refuses aliases (they can blow up) and keys given twice."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            raise yaml.constructor.ConstructorError(
                None, None, 'an alias (*) is not allowed here', self.peek_event().start_mark
            )
        return super().compose_node(parent, index)

    def construct_mapping(self, node: Any, deep: bool = False) -> Any:
        seen = set()
        for key_node, _ in node.value:
            key = key_node.value if isinstance(key_node, yaml.ScalarNode) else None
            if key in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f'key {key!r} is given twice', key_node.start_mark
                )
            seen.add(key)
        return super().construct_mapping(node, deep)


# YAML 1.1 reads 1e-3 as text; YAML 1.2 and JSON read it as a number, and so do people.
_StrictLoader.add_implicit_resolver(
    'tag:yaml.org,2002:float',
    re.compile(r'^[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)[eE][-+]?[0-9]+$'),
    list('-+.0123456789'),
)


def read_mapping(path: str | Path) -> dict[str, Any]:
    """The table in the file at `path`; raises ScenarioError."""
    return parse_mapping(read_text(path), str(path))


def read_text(path: str | Path, max_bytes: int = MAX_BYTES) -> str:
    """The text of a file; raises ScenarioError when it is unreadable, too large or not UTF-8."""
    path = Path(path)
    try:
        with path.open('rb') as stream:
            data = stream.read(max_bytes + 1)
    except OSError as error:
        raise ScenarioError(f'{path}: cannot be read: {error.strerror or error}') from error
    if len(data) > max_bytes:
        raise ScenarioError(
            f'{path}: got more than {max_bytes} bytes; allowed: at most {max_bytes}'
        )
    try:
        return data.decode('utf-8')
    except UnicodeDecodeError as error:
        raise ScenarioError(
            f'{path}: got bytes that are not text; allowed: UTF-8 (YAML or JSON)'
        ) from error


def parse_mapping(text: str, source: str) -> dict[str, Any]:
    """The table in YAML or JSON `text`; raises ScenarioError."""
    try:
        data = yaml.load(text, Loader=_StrictLoader)
    except yaml.YAMLError as error:
        raise ScenarioError(f'{source}: is not YAML or JSON: {_where(error)}') from error
    except (RecursionError, ValueError) as error:
        raise ScenarioError(f'{source}: is not a scenario: {error}') from error
    if not isinstance(data, dict):
        got = 'nothing' if data is None else type(data).__name__
        raise ScenarioError(
            f'{source}: got {got}; '
            'allowed: a table with the keys object, hand, palm, gravity, start, goal'
        )
    return data


def _where(error: yaml.YAMLError) -> str:
    mark = getattr(error, 'problem_mark', None) or getattr(error, 'context_mark', None)
    what = getattr(error, 'problem', None) or str(error).splitlines()[0]
    return f'{what} (line {mark.line + 1}, column {mark.column + 1})' if mark else what
