"""Colours and names that every figure shares; told apart by people who do not see red and green
alike.
"""

from wholearm_ros.model.modes import (
    CAGING,
    DONE,
    DWELL,
    DYNAMIC,
    IDLE,
    MODES,
    PROBING,
    QUASI_STATIC,
    STOPPED,
)

MODE_COLOURS = {
    QUASI_STATIC: '#8cbfe6',
    DWELL: '#c9c9c9',
    DYNAMIC: '#f2a65a',
    CAGING: '#7cc6a4',
    PROBING: '#b59ad6',
    DONE: '#ececec',
    STOPPED: '#d9534f',
    IDLE: '#f6f6f6',
}
MODE_NAMES = {mode: mode.replace('_', '-') for mode in MODES}
PLANNED, EXECUTED = '#d62728', '#1b3a5c'
SIDE_COLOURS = ('#2f6fb3', '#b3622f')  # left, right finger
OBJECT, OBJECT_EDGE, PALM, INK = '#f4d58d', '#7a5c10', '#8a8a8a', '#1a1a1a'
