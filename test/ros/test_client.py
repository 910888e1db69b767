"""A client comes and goes, in a process that lives on."""

import os
from pathlib import Path

from wholearm_ros.launcher.client import Client


def test_a_closed_client_leaves_no_participant_behind():
    """Its ports in shared memory go with it, and the next one finds them free."""

    def ports():
        return {path.name for path in Path('/dev/shm').glob('fastrtps_port*') if _mapped(path)}

    before, opened = ports(), []
    for _ in range(2):
        client = Client()
        opened.append(ports())
        client.close()
        assert ports() == before
    assert opened[0] == opened[1] > before


def _mapped(path):
    """Whether this process has `path` open."""
    return str(path) in Path(f'/proc/{os.getpid()}/maps').read_text()
