"""A graph of real node processes in a DDS domain of its own, and a client in it."""

import pytest

rclpy = pytest.importorskip('rclpy')

from conftest import fresh_domain
from ros_graph import Graph


@pytest.fixture
def domain(monkeypatch):
    """ROS_DOMAIN_ID of this test."""
    value = fresh_domain()
    monkeypatch.setenv('ROS_DOMAIN_ID', value)
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    return value


@pytest.fixture
def graph(domain, tmp_path):
    """An empty graph; `graph.start(nodes)`."""
    graph = Graph(tmp_path)
    yield graph
    graph.close()
