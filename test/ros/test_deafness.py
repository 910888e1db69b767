"""A node that hears nothing on a topic that never pauses says so, and listens anew."""

import pytest

from wholearm_ros.model.hand import JOINT_NAMES
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import write_joints
from wholearm_ros.ros.interface.messages import values_of
from wholearm_ros.ros.node.steady_subscription import PATIENCE, SteadySubscription

pytestmark = pytest.mark.timeout(280)


class Ear:
    """A subscription of the middleware that may go deaf."""

    def __init__(self, hear):
        self.hear, self.publishers = hear, 1

    def get_publisher_count(self):
        return self.publishers


@pytest.fixture
def steady():
    """(the subscription, the ears it has made, the ears it has given up, what it heard)."""
    made, gone, heard = [], [], []

    def subscribe(hear):
        made.append(Ear(hear))
        return made[-1]

    return (
        SteadySubscription('joint_states', heard.append, subscribe, gone.append),
        made,
        gone,
        heard,
    )


def test_renewals_of_what_stays_silent_become_rare_and_end_with_a_message(steady):
    subscription, made, gone, heard = steady
    told = {look: line for look in range(1, 200) if (line := subscription.look())}
    assert list(told) == [5, 10, 20, 40, 60, 120, 180]
    assert told[10] == 'joint_states: nothing heard for 10 s though 1 publish it; subscribed anew'
    assert len(made) == len(told) + 1 and gone == made[:-1]
    assert subscription.renewals == len(told)
    assert subscription.problem == 'joint_states: nothing heard for 199 s'
    made[-1].hear('something')
    assert heard == ['something']
    assert subscription.look() == 'joint_states: heard again' and not subscription.problem
    assert not any(subscription.look() for _ in range(PATIENCE - 1))
    assert subscription.look(), 'as patient as at first'


def test_nobody_who_publishes_is_no_silence_and_neither_is_a_message_now_and_then(steady):
    subscription, made, gone, _ = steady
    made[0].publishers = 0
    assert not any(subscription.look() for _ in range(10 * PATIENCE))
    made[0].publishers = 1
    for _ in range(10):
        for _ in range(PATIENCE - 1):
            assert not subscription.look()
        made[0].hear('something')
        assert not subscription.look()
    assert not gone and not subscription.problem


NODES = ('velocity_controller', 'torque_controller', 'mode_switcher', 'object_observer')


def test_a_publisher_that_is_matched_but_silent_is_told_and_heard_when_it_speaks(graph):
    """Each node that listens to joint states, by the same means; the log says so, too."""
    said = {}
    graph.node.create_subscription(
        channels.DIAGNOSTICS.type,
        channels.DIAGNOSTICS.name,
        lambda m: said.update({s.name.rpartition('/')[2]: s for s in m.status}),
        channels.DIAGNOSTICS.qos,
    )
    graph.start(NODES)
    talker = graph.talk(channels.JOINT_STATES, len(NODES))
    deaf = f'{channels.JOINT_STATES.name}: nothing heard for'

    def told(node):
        return node in said and deaf in said[node].message

    graph.wait(lambda: all(told(node) for node in NODES), 'each says so')
    stamp = iter(range(1, 10**6))

    def heard_again():
        talker.publish(
            write_joints(next(stamp) * 10**7, 'palm', JOINT_NAMES, [2.0, 1.0], [0.0] * 2, [0.0] * 2)
        )
        return not any(told(node) for node in NODES)

    graph.wait(heard_again, 'each hears the new subscription')
    for node in NODES:
        assert int(values_of(said[node])['renewed subscriptions']) >= 1
        log = graph.processes.log_of(node).read_text()
        assert 'subscribed anew' in log and 'heard again' in log
    graph.wait(lambda: heard_again() and int(values_of(said['torque_controller'])['states']), 'it')
