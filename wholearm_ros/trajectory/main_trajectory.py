"""MAIN_TRAJECTORY: from a contact plan to the motion and torque of both fingers over time
(III-B.5).
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from wholearm_ros.errors import DocumentError
from wholearm_ros.mechanics.mirror import mirror_plan, mirror_trajectory
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.orientation import turns_clockwise
from wholearm_ros.model.plan import ContactPlan, Leg
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.rollout.primitive_rollout import released
from wholearm_ros.trajectory.boundary_subgoals import boundary_subgoals
from wholearm_ros.trajectory.check_transition import TransitionReport
from wholearm_ros.trajectory.execution_options import ExecutionOptions
from wholearm_ros.trajectory.joint_trajectory import TrajectoryBuilder
from wholearm_ros.trajectory.monotone_segments import pieces_of
from wholearm_ros.trajectory.plan_fit import require_fit
from wholearm_ros.trajectory.segment_motion import motion_of

FINAL_HOLD = 0.3  # [s] at the goal, before the trajectory ends


def generate(
    scenario: Scenario, plan: ContactPlan, options: ExecutionOptions | None = None
) -> ManipulationTrajectory:
    """The trajectory that executes `plan`; deterministic. Without `options` those of the plan
    document are used.

    Raises DocumentError when the plan has no route, or does not fit the scenario.
    """
    band = plan.band if options is None else None  # it belongs to the plan's own options
    options = options or ExecutionOptions.from_dict(plan.execution)
    require_fit(scenario, plan)
    if turns_clockwise(scenario):  # generated as its mirror image
        mirrored = scenario.mirrored()
        ccw = _generate(mirrored, mirror_plan(plan, mirrored), options, plan.id)
        trajectory = mirror_trajectory(ccw, scenario)
    else:
        trajectory = _generate(scenario, plan, options, plan.id)
    return replace(trajectory, band=band, courses=plan.courses, strayed=plan.strayed)


def _generate(
    scenario: Scenario, plan: ContactPlan, options: ExecutionOptions, plan_id: str
) -> ManipulationTrajectory:
    """MAIN_TRAJECTORY of a counter-clockwise scenario."""
    world = build_world(scenario)
    builder = TrajectoryBuilder(world, released(world, plan.legs[0].configurations[0]), options)
    try:
        reports = [r for legs in _stretches(plan.legs, options) for r in append(builder, legs)]
    except ValueError as error:
        raise DocumentError(f'plan {plan_id} does not fit its scenario: {error}') from error
    # 10, 11 stop at X_goal
    builder.hold(FINAL_HOLD)
    return builder.finish(plan_id, tuple(report.to_dict() for report in reports))


def append(builder: TrajectoryBuilder, legs: Sequence[Leg]) -> list[TransitionReport]:
    """Steps 1 to 9 of MAIN_TRAJECTORY: lead the hand along legs, to rest at their end.

    Raises ValueError when their contacts cannot be kept closed (the plan is not of this scenario).
    """
    world, options = builder.world, builder.options
    # 1 Read_Subgoal; with the control mode of every leg (III-B.4)
    pieces = [piece for leg in legs for piece in pieces_of(world, leg, options)]
    # 2, 3 Set_BoundarySubgoal, 4 Check_Transition
    segments = boundary_subgoals(world, pieces)
    # 5 Make_JointTraj, 6 FwdKinematics, 7 GET_TORQUE
    motions = [motion_of(world, segment, options) for segment in segments]
    # 8 Get_NewConfig, 9 the next segment
    for motion, following in zip(motions, (*motions[1:], None)):
        builder.append(motion, following)
    return [report for segment in segments for report in segment.transitions]


def _stretches(legs: tuple[Leg, ...], options: ExecutionOptions) -> list[list[Leg]]:
    """The legs, cut where the hand stops whatever follows: at the nodes of the route."""
    if not options.stops:
        return [list(legs)]
    stretches = [[legs[0]]]
    for before, leg in pairwise(legs):
        if before.end == leg.start:
            stretches[-1].append(leg)
        else:
            stretches.append([leg])
    return stretches
