"""Rollouts: a trajectory under the closed loop, and a motion primitive, stepped in compiled code.

The closed loop is that of `control/` and `simulation/`, period by period: encoders, mode switch
(ramp, handover, stop on a tracking error), both controllers (PD; open-loop torque with its slew
limit), drives (hold, delay, limits, gain errors), physics.
"""

from typing import NamedTuple

import numpy as np

from wholearm_ros.kernels import allocating, control_law, inlined, switch_law
from wholearm_ros.kernels.control_law import HOLD_GAINS, PdGains, VelocitySetpoint
from wholearm_ros.kernels.geometry import left_the_hand
from wholearm_ros.kernels.interpolation import quintic
from wholearm_ros.kernels.statics import weight_at
from wholearm_ros.kernels.time_stepping import new_workspace, step
from wholearm_ros.kernels.world import joint

pd_effort = inlined(control_law.pd_effort)
slewed_effort = inlined(control_law.slewed_effort)
holding_effort = inlined(control_law.holding_effort)
switch_at = inlined(switch_law.switch_at)
switch_period = inlined(switch_law.switch_period)


class Plant(NamedTuple):
    """What a sample has of its own beside its world: friction; torque_factors: (2,) of the motors;
    delay: periods from a command to its torque; zeros: (2,) added to every reading of the angles
    [rad]; noise: (n, 2, 2) added to the n-th reading of angles and velocities [rad, rad/s], none
    beyond.
    """

    friction: float
    torque_factors: np.ndarray
    delay: int
    zeros: np.ndarray
    noise: np.ndarray


class ClosedLoop(NamedTuple):
    """A plant and its control: law: a `ControlLaw`; switching: a `SwitchLaw`."""

    plant: Plant
    law: control_law.ControlLaw
    switching: switch_law.SwitchLaw


class State(NamedTuple):
    """q, v: (5,), see `model/configuration.py`."""

    q: np.ndarray
    v: np.ndarray


class Motors(NamedTuple):
    """angles, velocities: (2,) as read [rad, rad/s]; commands: (2,) [N m]; pipe: (d + 1, 2) those
    on their way; applied: (2,) torques now [N m].
    """

    angles: np.ndarray
    velocities: np.ndarray
    commands: np.ndarray
    pipe: np.ndarray
    applied: np.ndarray


class Start(NamedTuple):
    """q, v: (5,); efforts: (2,) commanded before [N m]; at_rest: the drives hold the fingers and
    the run begins with its ramp, else it is under way already; velocity_finger: the one so far,
    −1 for none.
    """

    q: np.ndarray
    v: np.ndarray
    efforts: np.ndarray
    at_rest: bool
    velocity_finger: int


class Record(NamedTuple):
    """What is filled in: q, v: (r, 5) every `every` periods from the end of the ramp on; last_q,
    last_v: (5,) at the end; commands: (c, 2) [N m] of the first c periods; stops_met: (2, 2)
    bool, which joint (left, right) came to bear on its (low, high) end stop.
    """

    q: np.ndarray
    v: np.ndarray
    every: int
    last_q: np.ndarray
    last_v: np.ndarray
    commands: np.ndarray
    stops_met: np.ndarray


@allocating
def run_trajectory(world, loop, course, start, settle, record):
    """The `ClosedLoop` along the whole course, and `settle` [s] of holding its end. A run that the
    mode switch stops ends there.

    Returns (records, largest LCP residual, the `Switch` at the end).
    """
    plant, law, switching = loop.plant, loop.law, loop.switching
    work = new_workspace(world, plant.friction, law.period)
    state, motors = State(start.q.copy(), start.v.copy()), _new_motors(plant, start)
    h, ramp, last = law.period, switching.ramp, course.angles.shape[0] - 1
    began = 0.0 if start.at_rest else -ramp
    lead = int(round(ramp / h)) if start.at_rest else 0
    total = int(np.ceil((began + ramp + course.period * last + settle) / h - 1e-9))
    switch = switch_at(began, start.velocity_finger)
    worst, count, t = 0.0, 0, 0.0
    for n in range(total):
        if n >= lead and (n - lead) % record.every == 0 and count < record.q.shape[0]:
            record.q[count], record.v[count] = state.q, state.v
            count += 1
        _read(plant, n, state, motors)
        switch, motion, torque = switch_period(
            switching, course, start.efforts, switch, t, motors.angles
        )
        if switch.stops:
            break
        _control(world, law, motion, torque, motors)
        if n < record.commands.shape[0]:
            record.commands[n] = motors.commands
        _drive(world, plant, start, n, state, motors)
        _, residual = step(world, work, motors.applied, state.q, state.v)
        worst = max(worst, residual)
        t += h
    if count < record.q.shape[0]:
        record.q[count], record.v[count] = state.q, state.v
        count += 1
    record.last_q[:], record.last_v[:] = state.q, state.v
    record.stops_met[:] = work.stops_met
    return count, worst, switch


@allocating
def _new_motors(plant, start):
    """Before the first period."""
    pipe = np.zeros((plant.delay + 1, 2))
    return Motors(np.empty(2), np.empty(2), start.efforts.copy(), pipe, np.empty(2))


@inlined
def _read(plant, n, state, motors):
    """The encoders' readings number n of both joints."""
    for side in range(2):
        angle, velocity = state.q[joint(side)] + plant.zeros[side], state.v[joint(side)]
        if n < plant.noise.shape[0]:
            angle += plant.noise[n, 0, side]
            velocity += plant.noise[n, 1, side]
        motors.angles[side], motors.velocities[side] = angle, velocity


@inlined
def _control(world, law, motion, torque, motors):
    """Both controllers' commands for their setpoints."""
    a, b, commands = motion.joint, torque.joint, motors.commands
    commands[a] = pd_effort(
        law.gains, world.torque_limits[a], motion, motors.angles[a], motors.velocities[a]
    )
    commands[b] = slewed_effort(
        world.torque_limits[b], law.slew_limit * law.period, torque.effort, commands[b]
    )


@inlined
def _drive(world, plant, start, n, state, motors):
    """Torques of period n: the command of `delay` periods before; what there was before the first
    one.
    """
    pipe = motors.pipe
    for side in range(2):
        pipe[n % (plant.delay + 1), side] = motors.commands[side]
        acting = pipe[(n + 1) % (plant.delay + 1), side]
        if n < plant.delay:
            acting = start.efforts[side]
            if start.at_rest:
                j = joint(side)
                weight = weight_at(world.finger_weights, side, state.q[j])
                acting = holding_effort(HOLD_GAINS, weight, start.q[j], state.q[j], state.v[j])
        limit = world.torque_limits[side]
        motors.applied[side] = min(max(acting, -limit), limit) * plant.torque_factors[side]


class Primitive(NamedTuple):
    """Finger `side` turns by `turn` [rad] from rest to rest, in turn_steps, while the other one's
    torque goes to `torque` [N m] in ramp_steps before it and stays; then settle_steps of rest.
    gains: of the turning finger; h [s]: of a step.
    """

    side: int
    turn: float
    torque: float
    ramp_steps: int
    turn_steps: int
    settle_steps: int
    gains: PdGains
    h: float


class PrimitiveCourse(NamedTuple):
    """What is filled in, every `every` steps: q, v: (r, 5); efforts: (r, 2), the turning finger's
    averaged [N m]; wanted: (r,) angle of the turning finger [rad]; last_q, last_v: (5,) at the
    end; stops_met: as in `Record`.
    """

    q: np.ndarray
    v: np.ndarray
    efforts: np.ndarray
    wanted: np.ndarray
    every: int
    last_q: np.ndarray
    last_v: np.ndarray
    stops_met: np.ndarray


@allocating
def run_primitive(world, primitive, q0, efforts, record):
    """Forward dynamics of a motion primitive from rest in q0 (5,) under efforts (2,) [N m].

    Returns (records, largest LCP residual). Stops early when the object leaves the hand or a finger
    bears on an end stop.
    """
    work = new_workspace(world, 0.0, primitive.h)
    q, v, side = q0.copy(), np.zeros(q0.shape[0]), primitive.side
    j, other = joint(side), 1 - side
    applied, mean, count, worst = np.empty(2), 0.0, 0, 0.0
    for n in range(primitive.ramp_steps + primitive.turn_steps + primitive.settle_steps):
        motion = _turning(primitive, n, q0[j], efforts[side])
        part = min(1.0, (n + 1) / max(primitive.ramp_steps, 1))
        wanted = efforts[other] + (primitive.torque - efforts[other]) * part
        limit = world.torque_limits[other]
        applied[other] = min(max(wanted, -limit), limit)
        applied[side] = pd_effort(primitive.gains, world.torque_limits[side], motion, q[j], v[j])
        mean += applied[side]
        _, residual = step(world, work, applied, q, v)
        worst = max(worst, residual)
        if (n + 1) % record.every == 0:
            record.q[count], record.v[count], record.wanted[count] = q, v, motion.angle
            record.efforts[count, side] = mean / record.every
            record.efforts[count, other] = applied[other]
            mean, count = 0.0, count + 1
        if left_the_hand(world, q) or work.stops_met.any():
            break
    record.last_q[:], record.last_v[:] = q, v
    record.stops_met[:] = work.stops_met
    return count, worst


@inlined
def _turning(primitive, n, first, feedforward):
    """The turning finger's setpoint in step n."""
    u = min(max((n - primitive.ramp_steps) / max(primitive.turn_steps, 1), 0.0), 1.0)
    position, speed = quintic(u)
    if primitive.turn_steps > 0:
        speed *= primitive.turn / (primitive.turn_steps * primitive.h)
    else:
        speed = 0.0
    return VelocitySetpoint(primitive.side, first + primitive.turn * position, speed, feedforward)
