"""The observer on the graph: it tells where the object is, and nobody who decides hears the truth."""

import numpy as np
import pytest
from ros_graph import ALL

from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.messages import to_nanoseconds, values_of

pytestmark = pytest.mark.timeout(280)


def rotation(pose) -> float:
    """[rad] of a geometry_msgs/Pose whose rotation is about z."""
    return 2.0 * np.arctan2(pose.orientation.z, pose.orientation.w)


def test_the_estimate_follows_the_truth_which_only_evaluation_hears(graph):
    """In lockstep; the client that judges the run is the only subscriber of the true pose."""
    graph.start(
        (*ALL, 'object_observer'),
        object_observer={'estimate_rate': 100.0},
        hand_hardware={'backend': 'planar'},
    )
    estimates, states = graph.listen(channels.OBJECT_ESTIMATE), graph.listen(channels.CONTACT_STATE)
    plan = graph.plan()
    assert graph.execute(plan.id)['outcome'] in ('succeeded', 'aborted')
    listeners = graph.node.get_subscriptions_info_by_topic('/wholearm/object_pose')
    assert {info.node_name for info in listeners} == {graph.node.get_name()}
    truth = graph.client.latest.poses
    off = []
    for message in estimates:
        true = truth.get(to_nanoseconds(message.header.stamp))
        if true is not None:
            turn = rotation(message.pose.pose) - true[2]
            off.append(abs((turn + np.pi) % (2.0 * np.pi) - np.pi))
    assert len(off) > 20 and np.mean(np.array(off) < 0.15) > 0.8
    assert all(m.pose.covariance[35] > 0.0 for m in estimates)
    told = [values_of(m) for m in states]
    assert any('best residual rad' in t and 'next' in t for t in told)
    assert any(m.message.startswith('on edge') for m in states)
    assert any(m.message.startswith('quasi_static') for m in states)
