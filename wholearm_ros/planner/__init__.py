"""From a scenario to a plan and a trajectory that survive simulation: the one call that joins both phases."""
