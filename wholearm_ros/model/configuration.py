"""The coordinates of a configuration q = (x, y, φ, θ_L, θ_R): the one place that knows their order.

x, y: centroid of the object [m]; φ: its rotation [rad]; θ_L, θ_R: joint angles of the fingers
[rad]. Velocities, loads, inertias and rows of Jacobians have the same order.
"""

X, Y, ROTATION, LEFT_JOINT, RIGHT_JOINT = range(5)
SIZE = 5
POSE = slice(X, LEFT_JOINT)
JOINTS = slice(LEFT_JOINT, SIZE)


def joint_index(side: int) -> int:
    """Index of the joint angle of a finger, LEFT or RIGHT."""
    return LEFT_JOINT + side
