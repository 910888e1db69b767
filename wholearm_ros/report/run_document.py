"""The document `wholearm-run/1`: a run without ROS with its plan and trajectory, as `wholearm
simulate --run` writes it.
"""

import json
from typing import Any

import numpy as np

from wholearm_ros.control.setpoints import ControlOptions
from wholearm_ros.errors import DocumentError
from wholearm_ros.model.perturbation import NOMINAL
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario_file import parse_scenario, scenario_to_dict
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.report.run_view import RunView, view_of
from wholearm_ros.report.versions import versions
from wholearm_ros.simulation.closed_loop import RunRecord

FORMAT = 'wholearm-run/1'
ARRAYS = ('times', 'angles', 'velocities', 'efforts', 'poses', 'object_velocities')
DIGITS = 7  # of what is written


def run_document(
    plan: ContactPlan,
    trajectory: ManipulationTrajectory,
    record: RunRecord,
    facts: dict[str, Any],
) -> str:
    """facts: name → text, shown in the report."""
    run = {name: np.round(getattr(record, name), DIGITS).tolist() for name in ARRAYS}
    return json.dumps(
        {
            'format': FORMAT,
            'facts': {**facts, 'run with': ', '.join(f'{k} {v}' for k, v in versions().items())},
            'truth': scenario_to_dict(record.truth),
            'reason': record.reason,
            'modes': list(record.modes),
            'run': run,
            'trajectory': json.loads(trajectory.to_json()),
            'plan': json.loads(plan.to_json()),
        },
        separators=(',', ':'),
        allow_nan=False,
    )


def read_run_document(text: str) -> tuple[ContactPlan, ManipulationTrajectory, RunView]:
    """Raises DocumentError when it is damaged."""
    try:
        d = json.loads(text)
        plan = ContactPlan.from_json(json.dumps(d['plan']))
        trajectory = ManipulationTrajectory.from_json(json.dumps(d['trajectory']))
        columns = [np.array(d['run'][name], dtype=float) for name in ARRAYS]
        times, angles, velocities, efforts, poses, object_velocities = columns
        lengths = {len(d['modes']), *map(len, columns)}
        if len(lengths) != 1 or len(d['modes']) < 2:
            raise DocumentError(
                'run document: its arrays differ in length; '
                'allowed: one row a period in each, two at least'
            )
        record = RunRecord(
            times,
            angles,
            velocities,
            efforts,
            poses,
            object_velocities,
            tuple(d['modes']),
            d['reason'],
            parse_scenario(d['truth'], 'run document'),
            NOMINAL,
        )
        return plan, trajectory, view_of(record, plan.scenario, ControlOptions(), d['facts'])
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise DocumentError(f'run document is damaged: {type(error).__name__}: {error}') from error
