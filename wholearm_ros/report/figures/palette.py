"""Colours and names that every figure shares; told apart by people who do not see red and green
alike.
"""

MODE_COLOURS = {
    'quasi_static': '#8cbfe6',
    'dwell': '#c9c9c9',
    'dynamic': '#f2a65a',
    'caging': '#7cc6a4',
    'probing': '#b59ad6',
    'done': '#ececec',
    'stopped': '#d9534f',
    'idle': '#f6f6f6',
}
MODE_NAMES = {
    'quasi_static': 'quasi-static',
    'dwell': 'dwell',
    'dynamic': 'dynamic',
    'caging': 'caging',
    'probing': 'probing',
    'done': 'done',
    'stopped': 'stopped',
    'idle': 'idle',
}
PLANNED, EXECUTED = '#d62728', '#1b3a5c'
SIDE_COLOURS = ('#2f6fb3', '#b3622f')  # left, right finger
OBJECT, OBJECT_EDGE, PALM, INK = '#f4d58d', '#7a5c10', '#8a8a8a', '#1a1a1a'
