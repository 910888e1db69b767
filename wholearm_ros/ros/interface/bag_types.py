"""What a bag says of a topic of the graph: the name of its type and its quality of service."""

from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)

_NEVER = QosTime(9223372036, 854775807)  # as rosbag2 writes "for ever"


def type_name(message_type: type) -> str:
    """'std_msgs/msg/String' of the class."""
    package, kind, *_ = message_type.__module__.split('.')
    return f'{package}/{kind}/{message_type.__name__}'


def offered(qos: QoSProfile) -> Qos:
    """As rosbag2 writes it, so that it plays latched topics back as latched."""
    return Qos(
        history=QosHistory.KEEP_LAST
        if qos.history != HistoryPolicy.KEEP_ALL
        else QosHistory.KEEP_ALL,
        depth=qos.depth,
        reliability=(
            QosReliability.RELIABLE
            if qos.reliability == ReliabilityPolicy.RELIABLE
            else QosReliability.BEST_EFFORT
        ),
        durability=(
            QosDurability.TRANSIENT_LOCAL
            if qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
            else QosDurability.VOLATILE
        ),
        deadline=_NEVER,
        lifespan=_NEVER,
        liveliness=QosLiveliness.AUTOMATIC
        if qos.liveliness != LivelinessPolicy.MANUAL_BY_TOPIC
        else QosLiveliness.MANUAL_BY_TOPIC,
        liveliness_lease_duration=_NEVER,
        avoid_ros_namespace_conventions=False,
    )
