"""The hand's stand-ins, what may be perturbed in them, the closed loop without ROS, and the suite."""
