"""Definitions and RIHS01 hashes of the messages in a bag."""

from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore


def jazzy_typestore() -> Typestore:
    """Definitions and RIHS01 hashes of every message of Jazzy."""
    return get_typestore(Stores.ROS2_JAZZY)
