"""Bags of rosbag2, read, written and repaired without ROS."""
