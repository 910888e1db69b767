"""The ROS edge: channels (names and QoS), parameters, messages, node bases, bags and the launcher."""
