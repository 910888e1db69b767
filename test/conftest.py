"""What the tests of every room share."""
import itertools
import os
from pathlib import Path

import pytest

_domains = itertools.count(os.getpid() * 7)


@pytest.fixture(scope='session')
def config() -> Path:
    """The directory of the shipped scenarios."""
    return Path(__file__).parents[1] / 'config'


def fresh_domain() -> str:
    """A ROS_DOMAIN_ID that no other test of this session uses (of 0 to 101, the first ten left to people)."""
    return str(10 + next(_domains) % 92)
