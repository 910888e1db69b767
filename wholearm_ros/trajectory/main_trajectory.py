"""MAIN_TRAJECTORY: from a contact plan to the motion and torque of both fingers over time (III-B.5)."""

from dataclasses import replace

import numpy as np

from wholearm_ros.errors import DocumentError
from wholearm_ros.kernels.interpolation import slew_limited
from wholearm_ros.mechanics.contacts import contact_rows, pair_exists, pair_from_name
from wholearm_ros.mechanics.mirror import mirror_plan, mirror_trajectory
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.hand import CLOSING
from wholearm_ros.model.interpolation import quintic
from wholearm_ros.model.orientation import turns_clockwise
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import CAGING, DYNAMIC, QUASI_STATIC, ManipulationTrajectory
from wholearm_ros.trajectory.check_transition import check_dyn, check_transition
from wholearm_ros.trajectory.execution_options import ExecutionOptions
from wholearm_ros.trajectory.get_torque import dynamic_torque, quasi_static_torque
from wholearm_ros.trajectory.joint_trajectory import TrajectoryBuilder
from wholearm_ros.trajectory.monotone_segments import follow, pieces_of
from wholearm_ros.trajectory.timing import stroke_duration

FINAL_HOLD = 0.3  # [s] at the goal, before the trajectory ends
LARGEST_GAP = 1e-5  # [m] of a contact that the plan says is closed


def generate(
    scenario: Scenario, plan: ContactPlan, options: ExecutionOptions = None
) -> ManipulationTrajectory:
    """The trajectory that executes `plan`. Without `options` those of the plan document are used.

    Raises DocumentError when the plan has no route, or does not fit the scenario.
    """
    if not plan.legs:
        raise DocumentError(
            f'plan {plan.id} has no route to execute ({plan.outcome}: {plan.reason})'
        )
    band = (
        None if options else plan.band
    )  # it was measured on a trajectory of the plan's own options
    options = options or ExecutionOptions.from_dict(plan.execution)
    _require_fit(build_world(scenario), plan)
    if turns_clockwise(scenario):
        mirrored = scenario.mirrored()
        trajectory = mirror_trajectory(
            _generate(mirrored, mirror_plan(plan, mirrored), options, plan.id), scenario
        )
    else:
        trajectory = _generate(scenario, plan, options, plan.id)
    return replace(trajectory, band=band)


def _generate(scenario, plan, options, plan_id):
    world = build_world(scenario)
    builder = TrajectoryBuilder(world, plan.legs[0].configurations[0], options)
    pieces = [piece for leg in plan.legs for piece in pieces_of(world, leg, options)]  # step 1
    untransitable = None  # the transition report when condition 2 fails where the stroke begins
    try:
        while pieces:
            if pieces[0].mode == DYNAMIC:
                piece = pieces.pop(0)
                builder.extend_move(piece.move, piece.pairs)
                continue
            if pieces[0].mode == CAGING:
                _lower(builder, pieces.pop(0))
                continue
            stroke, transitions = _boundary(world, pieces)  # steps 2–4
            _stroke(builder, stroke, untransitable)  # steps 5–8
            builder.transitions.extend(report.to_dict() for report in transitions)
            untransitable = _parted(stroke, transitions, pieces)
            del pieces[: len(stroke)]  # step 9
    except ValueError as error:
        raise DocumentError(f'plan {plan_id} does not fit its scenario: {error}') from error
    builder.hold(FINAL_HOLD)  # steps 10, 11
    return builder.finish(plan_id)


def _require_fit(world, plan):
    """Raises DocumentError unless the plan's contacts exist in this world and are closed where its legs begin."""
    known = len(world.obj), len(world.palm)
    for k, leg in enumerate(plan.legs):
        try:
            pairs = tuple(pair_from_name(name) for name in leg.contacts)
        except (ValueError, KeyError, IndexError, AttributeError, OverflowError) as error:
            raise DocumentError(
                f'plan {plan.id} does not fit its scenario: contacts of leg {k}: {error}'
            ) from error
        there = all(pair_exists(pair, *known) for pair in pairs)
        if not there or len(leg.configurations) < 2:
            raise DocumentError(
                f'plan {plan.id} does not fit its scenario: leg {k} with contacts {leg.contacts}'
            )
        if leg.mode == QUASI_STATIC:
            gap = (
                np.abs(contact_rows(world, pairs, leg.configurations[0])[1]).max()
                if len(pairs) == 4
                else np.inf
            )
            if not gap <= LARGEST_GAP:
                raise DocumentError(
                    f'plan {plan.id} does not fit its scenario: contacts of leg {k} are {gap:.1e} m apart; '
                    f'allowed: four contacts, {LARGEST_GAP:.0e} m'
                )


def _boundary(world, pieces):
    """Set_BoundarySubgoal, Check_Transition: the pieces up to where the velocity finger reverses or the ranges part."""
    stroke, reports = [pieces[0]], []
    for before, after in zip(pieces[:-1], pieces[1:]):
        report = check_transition(world, before, after)
        if report is not None:
            reports.append(report)
        turns_on = (after.velocity_finger, after.direction) == (
            before.velocity_finger,
            before.direction,
        )
        if after.mode != QUASI_STATIC or not turns_on or not report.quasi_static:
            return stroke, reports
        stroke.append(after)
    return stroke, reports


def _parted(stroke, transitions, pieces):
    """The report of the transition that ends the stroke, if the ranges part there under one velocity finger."""
    after = pieces[len(stroke)] if len(stroke) < len(pieces) else None
    if (
        after is None
        or after.mode != QUASI_STATIC
        or after.velocity_finger != stroke[-1].velocity_finger
    ):
        return None
    return None if transitions[-1].quasi_static else transitions[-1]


def _stroke(builder, stroke, untransitable=None):
    """Make_JointTraj, FwdKinematics and GET_TORQUE for one stroke.

    It is preceded by the ramp of the torque at rest, or, where the ranges part and the options say so, by a dynamic
    transition: the torque passes the range of the contact state before already on the way to the end of that stroke.
    """
    world, options = builder.world, builder.options
    side = stroke[0].velocity_finger
    start = stroke[0].samples[0, 3 + side]
    turn = sum(piece.turn for piece in stroke)
    duration = stroke_duration(
        turn, max(_fastest(world, p) for p in stroke), options.speed, options.acceleration
    )
    count = int(np.ceil(duration / options.period))
    position, _ = quintic(np.linspace(0.0, 1.0, count + 1))
    thetas = start + turn * position
    followed, of_piece = _follow_all(world, stroke, thetas)
    torque = quasi_static_torque(followed.statics, 1 - side, options, world.torque_limits[1 - side])
    dynamic = untransitable is not None and options.transition == DYNAMIC
    if dynamic:
        first = dynamic_torque(untransitable, 1 - side, options, world.torque_limits[1 - side])
        dynamic = check_dyn(
            world, followed.configurations[0], untransitable, 1 - side, first, stroke[0].direction
        )
    if dynamic:
        torque = slew_limited(torque, first, options.slew * options.period)
    efforts = np.empty((count + 1, 2))
    efforts[:, 1 - side] = torque
    efforts[:, side] = followed.gains[:, 0] + followed.gains[:, 1] * torque
    if dynamic:
        builder.break_equilibrium(efforts[0], side, stroke[0].pairs)
    else:
        builder.ramp_to(efforts[0], side, stroke[0].pairs)
    builder.extend(
        QUASI_STATIC,
        side,
        followed.configurations,
        efforts,
        followed.statics[:, :2],
        stroke,
        of_piece,
    )


def _follow_all(world, stroke, thetas):
    """Followed configurations for all angles, each by the piece in whose reach it lies; and which piece that is."""
    column = 3 + stroke[0].velocity_finger
    ends = np.array([piece.samples[-1, column] for piece in stroke[:-1]])
    of_piece = np.searchsorted(
        ends * stroke[0].direction, thetas * stroke[0].direction, side='left'
    )
    parts = [follow(world, piece, thetas[of_piece == k]) for k, piece in enumerate(stroke)]
    joined = [
        np.concatenate([getattr(part, name) for part in parts])
        for name in ('configurations', 'statics', 'gains')
    ]
    return type(parts[0])(*joined), of_piece


def _fastest(world, piece):
    """How many times as fast as the velocity finger the fastest coordinate of the piece moves."""
    steps = np.abs(np.diff(piece.samples, axis=0) / world.scale)
    driven = np.maximum(steps[:, 3 + piece.velocity_finger], 1e-9)
    return float((steps.max(axis=1) / driven).max())


def _lower(builder, piece):
    """Caging: the object is laid down at a limited speed between the fingers, then held (III-B.3).

    One finger is velocity-controlled and keeps closed on where the object should be, the other has a small torque.
    """
    world, options, samples, side = (
        builder.world,
        builder.options,
        piece.samples,
        piece.velocity_finger,
    )
    turn = samples[-1, 2] - samples[0, 2]
    fastest = float(
        (np.abs(np.diff(samples[:, 3 + side])) / np.maximum(np.diff(samples[:, 2]), 1e-9)).max()
    )
    count = int(
        np.ceil(
            stroke_duration(turn, fastest, options.speed, options.acceleration) / options.period
        )
    )
    angle = samples[0, 2] + turn * quintic(np.linspace(0.0, 1.0, count + 1))[0]
    q = np.column_stack([np.interp(angle, samples[:, 2], samples[:, j]) for j in range(5)])
    efforts = world.finger_moment * np.cos(q[:, 3:])
    holding = efforts[-1].copy()
    efforts[:, 1 - side] += CLOSING[1 - side] * options.caging_torque
    holding[1 - side] += CLOSING[1 - side] * options.holding_torque
    builder.ramp_to(efforts[0], side, piece.pairs)
    builder.extend(
        CAGING, side, q, efforts, np.full((count + 1, 2), np.nan), [piece], np.zeros(count + 1, int)
    )
    builder.ramp_to(holding, side, piece.pairs)
