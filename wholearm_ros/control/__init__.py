"""Pure controllers and the mode switch: (state, setpoint, dt) → effort. Nodes and the closed loop
without ROS run the same code.
"""
