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
GRAPH = 'graph'  # tests that start nodes run one after another


@pytest.hookimpl(tryfirst=True)  # before xdist looks at the groups
def pytest_collection_modifyitems(items):
    """Of two processes (`-n 2 --dist loadgroup`) one starts nodes, and a file stays in one of them."""
    for item in items:
        group = (
            GRAPH if item.get_closest_marker(GRAPH) or '/test/ros/' in str(item.path) else item.path
        )
        item.add_marker(pytest.mark.xdist_group(str(group)))


@pytest.fixture(scope='session')
def config() -> Path:
    """The directory of the shipped scenarios."""
    return Path(__file__).parents[1] / 'config'


def fresh_domain() -> str:
    """A ROS_DOMAIN_ID that no other test of this session uses (of 0 to 101, the first ten left to people)."""
    return str(10 + next(_domains) % 92)
