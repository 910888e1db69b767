"""Suite files: many scenarios in one JSON document, `wholearm-suite/1`."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from wholearm_ros.errors import DocumentError, ScenarioError
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.scenario_file import parse_scenario
from wholearm_ros.model.yaml_text import read_text

FORMAT = 'wholearm-suite/1'
MAX_BYTES = 64 * 1024 * 1024


@dataclass(frozen=True)
class SuiteEntry:
    """name; scenario: the keys of a scenario file, not checked yet, so that a bad one only spoils
    itself; besides them `sequence`, edges that the object shall lie on one after the other.
    """

    name: str
    scenario: dict[str, Any]

    def parsed(self) -> tuple[Scenario, tuple[int, ...]]:
        """(scenario, edges of its sequence); the goal is then the first of them. Raises
        ScenarioError.
        """
        if not isinstance(self.scenario, dict) or 'sequence' not in self.scenario:
            return parse_scenario(self.scenario, self.name), ()
        keys = {key: value for key, value in self.scenario.items() if key != 'sequence'}
        faces = self.scenario['sequence']
        whole = isinstance(faces, list) and all(type(face) is int for face in faces)
        if not whole or not faces:
            raise ScenarioError(
                f'{self.name}: sequence: got {faces!r}; allowed: a list of at least one edge'
            )
        if 'goal' in keys:
            raise ScenarioError(
                f'{self.name}: goal: got one beside a sequence; allowed: either of them'
            )
        each = [parse_scenario({**keys, 'goal': {'edge': face}}, self.name) for face in faces]
        return each[0], tuple(faces)


def load_suite(path: str | Path) -> tuple[SuiteEntry, ...]:
    """The tasks of the suite at `path`; raises ScenarioError or DocumentError."""
    text = read_text(path, MAX_BYTES)
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise DocumentError(f'{path}: is not JSON: {error}') from error
    got = document.get('format') if isinstance(document, dict) else type(document).__name__
    if got != FORMAT:
        raise DocumentError(f'{path}: format: got {got!r}; allowed: {FORMAT!r}')
    tasks = document.get('tasks')
    if not isinstance(tasks, list) or not tasks:
        raise DocumentError(
            f'{path}: tasks: got {type(tasks).__name__}; allowed: a list of at least one scenario'
        )
    return tuple(SuiteEntry(_name(task, k), task) for k, task in enumerate(tasks))


def _name(task: Any, k: int) -> str:
    name = task.get('name') if isinstance(task, dict) else None
    return name if isinstance(name, str) and name else f'task {k}'
