"""A client comes and goes, in a process that lives on."""

import os
import time

from ros_graph import udp_sockets
from std_msgs.msg import String

from wholearm_ros.launcher.client import Client


def test_a_closed_client_leaves_no_participant_behind(domain):
    """Its ports go with it, and the next one finds them free."""

    def ports():
        first = 7400 + 250 * int(domain)
        return {port for _, port in udp_sockets(os.getpid()) if first <= port < first + 250}

    before, opened = ports(), []
    for _ in range(2):
        client = Client()
        opened.append(ports())
        client.close()
        assert ports() == before
    assert opened[0] == opened[1] > before


def test_one_spin_takes_everything_that_has_come(domain):
    """Else a client that does other work between two spins falls behind what is said to it."""
    heard, client = [], Client()
    topics = [client.node.create_publisher(String, f'topic_{k}', 10) for k in range(10)]
    for topic in topics:
        client.node.create_subscription(String, topic.topic_name, heard.append, 10)
    client.wait(lambda: all(t.get_subscription_count() for t in topics), 30.0, 'subscriptions')
    for topic in topics:
        topic.publish(String(data='something'))
    time.sleep(0.5)  # for them to arrive; nothing is heard before it is spun
    assert not heard
    client.spin(0.1)
    assert len(heard) == len(topics)
    client.close()
