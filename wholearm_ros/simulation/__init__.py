"""The simulated hands, the closed loop without ROS, and the judged outcome."""
