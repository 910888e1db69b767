"""Modes of a run and phases of a reorientation, by their names in documents and topics."""

from wholearm_ros.model.choices import Transition

QUASI_STATIC, CAGING = 'quasi_static', 'caging'
DWELL, DYNAMIC = Transition.dwell.value, Transition.dynamic.value
PLANNED_MODES = (QUASI_STATIC, DWELL, DYNAMIC, CAGING)  # of a trajectory's segments

PROBING = 'probing'  # the trajectory is done, the hand feels where the object lies
IDLE, DONE, STOPPED = 'idle', 'done', 'stopped'  # before a run, at its end, ended early
MODES = (*PLANNED_MODES, PROBING, DONE, STOPPED, IDLE)

PLANNING, EXECUTING, FEELING = 'planning', 'executing', 'feeling'  # phases of a reorientation
