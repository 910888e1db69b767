"""The stand-ins of the hand, the closed loop without ROS, and the judged outcome."""
