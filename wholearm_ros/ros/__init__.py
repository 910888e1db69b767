"""The ROS edge: channels (names and QoS), parameters, messages, what all nodes share."""
