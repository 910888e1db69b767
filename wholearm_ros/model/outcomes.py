"""Outcomes of a goal and of a probe, by the names that documents and topics give them.

Those of a planning call are in `plan.py`.
"""

# A goal on the ROS graph.
SUCCEEDED, CANCELED, ABORTED, REJECTED = 'succeeded', 'canceled', 'aborted', 'rejected'

# What a probe finds in the hand: an object that lies on an edge, nothing, or neither for sure.
LYING, NOTHING, UNKNOWN = 'lying', 'nothing', 'unknown'

# What is claimed of the goal: after a probe, or without one.
AT_GOAL, ELSEWHERE, LOST, UNVERIFIED = 'at_goal', 'elsewhere', 'lost', 'unverified'
PROBED = (AT_GOAL, ELSEWHERE, LOST, UNKNOWN)
CLAIMS = (*PROBED, UNVERIFIED)
