"""Whole-arm manipulation of a slippery polygon: planned, verified and executed on ROS 2."""
