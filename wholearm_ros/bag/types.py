"""Definitions and RIHS01 hashes of the messages in a bag."""

from rosbags.typesys import Stores, get_typestore


def jazzy_typestore():
    """Definitions and RIHS01 hashes of every message of Jazzy."""
    return get_typestore(Stores.ROS2_JAZZY)
