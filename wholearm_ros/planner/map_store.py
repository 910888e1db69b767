"""Face maps on disk: a file a way, under the hash of the object and the hand, so that a map that is
being made can be used, and one that was interrupted goes on.
"""

import hashlib
import json
import os
from collections.abc import Iterable
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.plan import TIME_SPENT, ContactPlan
from wholearm_ros.model.scenario import GoalOnEdge, Scenario, StartOnEdge
from wholearm_ros.model.scenario_file import scenario_to_dict
from wholearm_ros.planner.face_map import FaceMap, Refused, Way

DIRECTORY = 'WHOLEARM_MAPS'  # environment variable: where maps are kept


def maps_directory() -> Path:
    """Where maps are kept: $WHOLEARM_MAPS, else in the user's cache."""
    cache = Path(os.environ.get('XDG_CACHE_HOME') or Path.home() / '.cache')
    return Path(os.environ.get(DIRECTORY) or cache / 'wholearm_ros' / 'maps')


class MapStore:
    """The map of one object in one hand: what was tried, with whatever options."""

    def __init__(self, scenario: Scenario, maps: Path | None = None) -> None:
        self.scenario = scenario
        self.directory = (maps or maps_directory()) / _key(scenario)

    def load(self) -> FaceMap:
        """The map as far as it is made."""
        tried = [_tried(file) for file in sorted(self.directory.glob('*.json'))]
        ways = tuple(t for t in tried if isinstance(t, Way))
        refused = tuple(t for t in tried if isinstance(t, Refused))
        return FaceMap(self.scenario.object.polygon.resting_edges, ways, refused)

    def untried(self, scenarios: Iterable[Scenario], moves: int = 0) -> list[Scenario]:
        """Those between whose start and goal no way was tried yet, or not as long (see `has`)."""
        return [scenario for scenario in scenarios if not self.has(scenario, moves)]

    def has(self, scenario: Scenario, moves: int = 0) -> bool:
        """Whether the way between a scenario's start and goal was tried, and neither for too short
        a time nor, in vain, with fewer simulations than `moves`.
        """
        tried = _tried(self._file(scenario))
        if not isinstance(tried, Refused):
            return tried is not None
        enough = tried.moves is None or tried.moves >= moves
        return enough and not tried.reason.startswith(TIME_SPENT)

    def save(self, scenario: Scenario, tried: Way | Refused) -> None:
        """Keep what was tried; raises WholeArmError when it cannot be written."""
        document: dict[str, Any] = {'start': vars(tried.start), 'goal': vars(tried.goal)}
        if isinstance(tried, Way):
            document |= {'reach': tried.reach, 'end_x': tried.end.x, 'plan': tried.plan.to_json()}
        else:
            document |= {'reason': tried.reason, 'moves': tried.moves}
        file = self._file(scenario)
        part = file.with_suffix(f'.{os.getpid()}.part')
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            part.write_text(json.dumps(document), encoding='utf-8')
            part.replace(file)
        except OSError as error:
            reason = error.strerror or error
            raise WholeArmError(
                f'{file}: cannot be written: {reason}; allowed: another place for maps, '
                f'in the environment variable {DIRECTORY}'
            ) from error

    def _file(self, scenario: Scenario) -> Path:
        start, goal = scenario.start, scenario.goal
        assert isinstance(start, StartOnEdge) and isinstance(goal, GoalOnEdge)
        x = '' if goal.x is None else f'_at{1e3 * goal.x:+.1f}'
        name = f'{start.edge}_at{1e3 * start.x:+.1f}_to_{goal.edge}_{goal.direction or "slide"}{x}'
        return self.directory / f'{name}.json'


def _tried(file: Path) -> Way | Refused | None:
    """None of one that is not there, or damaged: it is tried again."""
    return _read_file(file, file.stat().st_mtime_ns) if file.is_file() else None


@lru_cache(maxsize=4096)
def _read_file(file: Path, time: int) -> Way | Refused | None:
    """A file that has not changed since `time` [ns] is read once by a process."""
    try:
        return _read(json.loads(file.read_text(encoding='utf-8')))
    except (OSError, ValueError, KeyError, TypeError, WholeArmError):
        return None


def _read(document: dict[str, Any]) -> Way | Refused:
    start, goal = StartOnEdge(**document['start']), GoalOnEdge(**document['goal'])
    if 'reason' in document:
        return Refused(start, goal, document['reason'], document.get('moves'))
    plan = ContactPlan.from_json(document['plan'])
    end = StartOnEdge(goal.edge, document['end_x'])
    return Way(start, document['reach'], goal, end, plan)


def _version() -> str:
    try:
        return version('wholearm_ros')
    except PackageNotFoundError:  # a source tree
        return ''


def _key(scenario: Scenario) -> str:
    """Hash of all that a map depends on: object, hand, palm, gravity, this version."""
    told = scenario_to_dict(scenario)
    depends = {key: told[key] for key in ('object', 'hand', 'palm', 'gravity')}
    depends['version'] = _version()
    text = json.dumps(depends, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
