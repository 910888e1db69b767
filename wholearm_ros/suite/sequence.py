"""A sequence of faces that one hand lays the object on, one after the other, without a reset."""

from typing import Any

from wholearm_ros.model.scenario import Scenario
from wholearm_ros.planner.legs import Leg
from wholearm_ros.simulation.outcome import outcome
from wholearm_ros.suite.attempts import Attempts
from wholearm_ros.suite.execution import drawn_perturbation
from wholearm_ros.suite.session import HandSession, Pursuit
from wholearm_ros.suite.suite_options import SuiteOptions


def run_sequence(
    scenario: Scenario,
    faces: tuple[int, ...],
    first: Leg | None,
    options: SuiteOptions,
    draw: int = 0,
    name: str = '',
) -> dict[str, Any]:
    """A draw of a suite's result: `reached` has an entry a face, whether it was begun or not.

    first: the leg from the scenario's start to the first face.
    """
    perturbation = drawn_perturbation(scenario, options, draw, name)
    with HandSession(scenario, perturbation, options) as session:
        made = session.pursue_faces(scenario, faces, Pursuit(scenario, first, options))
    reached = [_told(face, attempts) for face, attempts in zip(faces, made)]
    reached += [_not_begun(face) for face in faces[len(made) :]]
    last = made[-1]
    missed = [one for one in reached if not one['executed']]
    return {
        **last.to_dict(),
        'executed': not missed,
        'reason': '; '.join(f'edge {one["edge"]}: {one["claim_reason"]}' for one in missed),
        'final_pose': session.motions[-1].record.poses[-1].tolist() if session.motions else None,
        'attempts': sum(one['attempts'] for one in reached),
        'reached': reached,
        'perturbation': perturbation.to_dict(),
    }


def _told(face: int, attempts: Attempts) -> dict[str, Any]:
    executed = bool(attempts.motions) and outcome(attempts.scenario, attempts.last).executed
    return {'edge': face, 'executed': executed, **attempts.to_dict()}


def _not_begun(face: int) -> dict[str, Any]:
    return {
        'edge': face,
        'executed': False,
        'claimed': 'not_begun',
        'claim_reason': 'the object was lost, or not known where, before',
        'attempts': 0,
    }
