"""What the tests of every room share."""

import itertools
import os
import sys
from pathlib import Path

import pytest
from hypothesis import settings

sys.path.insert(
    0, str(Path(__file__).parent)
)  # problems.py and plain_geometry.py, importable from every room
settings.register_profile(
    'same', derandomize=True, deadline=None, database=None
)  # the same examples everywhere
settings.load_profile('same')

_domains = itertools.count(os.getpid() * 7)
# Tests that start nodes run one after another.
GRAPH = ('test/ros/', 'test/examples/test_examples.py', 'test/report/test_docs.py')


@pytest.hookimpl(optionalhook=True)  # of xdist
def pytest_xdist_make_scheduler(config, log):
    """Of the processes (`-n 2`) one starts nodes; every other file stays in one of them, for its fixtures."""
    from xdist.scheduler import LoadScopeScheduling

    class OneGraphAtATime(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            return 'graph' if nodeid.startswith(GRAPH) else nodeid.partition('::')[0]

    return OneGraphAtATime(config, log)


@pytest.fixture(scope='session')
def config() -> Path:
    """The directory of the shipped scenarios."""
    return Path(__file__).parents[1] / 'config'


def fresh_domain() -> str:
    """A ROS_DOMAIN_ID that no other test of this session uses (of 0 to 101, the first ten left to people)."""
    return str(10 + next(_domains) % 92)
