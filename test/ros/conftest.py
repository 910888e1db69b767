"""A graph of real node processes in a DDS domain of its own, and a client in it."""

import itertools
import os
from pathlib import Path

import pytest

rclpy = pytest.importorskip('rclpy')

from ros_graph import Graph

_domains = itertools.count(os.getpid() * 7)


@pytest.fixture(scope='session')
def config() -> Path:
    """The directory of the shipped scenarios."""
    return Path(__file__).parents[2] / 'config'


@pytest.fixture
def domain(monkeypatch):
    """ROS_DOMAIN_ID of this test, of 0 to 101, the first ten left to people."""
    value = str(10 + next(_domains) % 92)
    monkeypatch.setenv('ROS_DOMAIN_ID', value)
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    return value


@pytest.fixture
def graph(domain, tmp_path):
    """An empty graph; `graph.start(nodes)`."""
    graph = Graph(tmp_path)
    yield graph
    graph.close()
