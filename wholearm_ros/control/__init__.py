"""Pure controllers and the mode switch: (state, setpoint, dt) → effort. The same code runs in the nodes and without ROS."""
