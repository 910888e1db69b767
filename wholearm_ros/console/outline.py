"""Scenarios as the page draws them: checked with the place of what is wrong, opened, saved."""

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import yaml

from wholearm_ros.errors import ScenarioError, WholeArmError
from wholearm_ros.model.scenario import Scenario, StartOnEdge
from wholearm_ros.model.scenario_file import load_scenario, parse_scenario, scenario_to_dict
from wholearm_ros.model.start_checks import problems_at_start
from wholearm_ros.package_share import shipped_scenarios
from wholearm_ros.report.html.scene import numbers

SOURCE = 'scenario'
_PLACES = re.compile(r'\b(vertex|edges?) (\d+(?:(?:, | and )\d+)*)')


def read(mapping: Mapping[str, Any]) -> Scenario:
    """The scenario that a page sends. Raises ScenarioError."""
    return parse_scenario(mapping, SOURCE)


def check(mapping: Mapping[str, Any]) -> dict[str, Any]:
    """What the scenario checks say of it.

    problems: each its text, and the vertices and edges of the object that it is about; of a sound
    one also faces: edges on which it can rest, and why not both fingers reach it there; centroid
    [mm] and area [cm²].
    """
    try:
        scenario = read(mapping)
    except ScenarioError as error:
        return {'problems': [_placed(line) for line in str(error).split('\n')]}
    polygon = scenario.object.polygon
    return {
        'problems': [],
        'faces': [{'edge': k, 'reach': _reach(scenario, k)} for k in polygon.resting_edges],
        'centroid': numbers(1e3 * polygon.centroid, 2),
        'area': round(1e4 * polygon.area, 2),
    }


def _placed(line: str) -> dict[str, Any]:
    text = line.removeprefix(f'{SOURCE}: ')
    places: dict[str, list[int]] = {'vertices': [], 'edges': []}
    if text.startswith('object.vertices'):
        for kind, listed in _PLACES.findall(text.partition('; allowed')[0]):
            places['vertices' if kind == 'vertex' else 'edges'] += map(
                int, re.findall(r'\d+', listed)
            )
    return {'text': text, **places}


def _reach(scenario: Scenario, edge: int) -> str:
    """Why the hand cannot take hold of the object on `edge`, at the start's x; '' when it can."""
    start = scenario.start
    x = start.x if isinstance(start, StartOnEdge) else float(start.pose[0])
    problems = problems_at_start(replace(scenario, start=StartOnEdge(edge, x)))
    return '; '.join(problem.partition('; allowed')[0] for problem in problems)


class Scenarios:
    """The scenarios that ship, and those in a directory."""

    def __init__(self, directory: Path) -> None:
        self._directory = directory

    def names(self) -> list[str]:
        """Without their endings; those of the directory first."""
        return sorted({*self._own(), *shipped_scenarios()}, key=lambda n: (n not in self._own(), n))

    def open(self, name: str) -> dict[str, Any]:
        """The keys of a scenario file. Raises WholeArmError."""
        found = {**shipped_scenarios(), **self._own()}
        if name not in found:
            raise WholeArmError(f'scenario {name}: not there; allowed: {", ".join(found)}')
        return scenario_to_dict(load_scenario(found[name]))

    def save(self, name: str, mapping: Mapping[str, Any], over: bool) -> str:
        """A line that says where it is now. Raises WholeArmError."""
        scenario = replace(read(mapping), name=name)
        file = self._directory / f'{name}.yaml'
        text = yaml.safe_dump(scenario_to_dict(scenario), sort_keys=False, default_flow_style=None)
        try:
            self._directory.mkdir(parents=True, exist_ok=True)
            with file.open('w' if over else 'x', encoding='utf-8') as out:
                out.write(text)
        except FileExistsError as error:
            raise WholeArmError(
                f'{file}: exists already; allowed: another name, or to replace it'
            ) from error
        except OSError as error:
            raise WholeArmError(f'{file}: cannot be written: {error.strerror or error}') from error
        return f'saved as {file}'

    def _own(self) -> dict[str, Path]:
        return {p.stem: p for p in sorted(self._directory.glob('*.yaml')) if p.is_file()}
