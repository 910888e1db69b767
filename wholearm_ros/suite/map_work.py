"""The ways of a face map, worked on by several processes and kept as soon as each is done."""

from collections.abc import Iterator, Sequence
from functools import partial

from wholearm_ros.model.scenario import GoalOnEdge, Scenario, StartOnEdge
from wholearm_ros.planner.face_map import Refused, Way
from wholearm_ros.planner.map_making import MapOptions, make_way
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.suite.workers import work_on


def try_ways(
    wanted: Sequence[Scenario], store: MapStore, options: MapOptions, jobs: int
) -> Iterator[Way | Refused]:
    """What came of each, as it is done. Raises WholeArmError when it cannot be kept."""
    work = partial(make_way, options=options)
    for k, tried in work_on(wanted, work, _lost, min(jobs, max(len(wanted), 1))):
        store.save(wanted[k], tried)
        yield tried


def _lost(scenario: Scenario, why: str) -> Refused:
    """Of a worker that died."""
    start, goal = scenario.start, scenario.goal
    assert isinstance(start, StartOnEdge) and isinstance(goal, GoalOnEdge)
    return Refused(start, goal, f'error: {why}')
