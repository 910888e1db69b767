"""A client comes and goes, in a process that lives on."""

import os

from ros_graph import udp_sockets

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
