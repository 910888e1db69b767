"""What /diagnostics says of drives behind a command watchdog."""

from typing import Any

from wholearm_ros.control.command_watchdog import (
    HOLD,
    HOLDING,
    WAITING_FOR_RESET,
    CommandWatchdog,
)
from wholearm_ros.ros.node.node import ERROR, OK, WARN, Health


def drives_health(guard: CommandWatchdog, values: dict[str, Any]) -> Health:
    """Of its state: an error where the drives wait for a reset, a warning where they hold."""
    if guard.state in WAITING_FOR_RESET:
        return ERROR, WAITING_FOR_RESET[guard.state], values
    if guard.state == HOLD:
        return WARN, HOLDING, values
    return OK, guard.state, values
