"""From a scenario to a certified plan and its trajectory: the call that joins both phases."""
