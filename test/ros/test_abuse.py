"""Arbitrary well-typed messages, requests and damaged documents, at every subscriber and every service of every node:
all of them stay alive and still do their job after."""

import random

import pytest
from action_msgs.msg import GoalStatusArray
from arbitrary import messages
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rcl_interfaces.srv import ListParameters
from ros_graph import ALL, WAIT
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from wholearm_ros.nodes.bag_player import message_class
from wholearm_ros.ros.interface import channels

pytestmark = [pytest.mark.faults, pytest.mark.timeout(900)]
NODES = (*ALL, 'bag_recorder')
PLANNING = 'contact_state_planner/plan'  # its answers take seconds


@pytest.fixture
def running(graph, tmp_path):
    """The whole graph, a recorder too, with a plan; (graph, the plan's id)."""
    graph.start(
        NODES,
        hand_hardware={'motor_rate': 200.0},
        torque_controller={'motor_rate': 200.0},
        bag_recorder={'path': str(tmp_path / 'bag')},
    )
    graph.client.wait_for_graph(WAIT)
    return graph, graph.plan().id


def every(examples: int):
    """Hypothesis, bounded by the number of examples and by nothing that a loaded machine changes."""
    return settings(
        max_examples=examples, deadline=None, database=None, suppress_health_check=list(HealthCheck)
    )


def answers(graph, node: str):
    """Every node serves its parameters from the same queue as its messages: an answer says that it is through them."""
    graph.client.call(channels.Service(f'{node}/list_parameters', ListParameters), WAIT)


def still_does_its_job(graph, plan_id: str):
    for node in NODES:
        answers(graph, node)
    graph.client.latest.trajectory = None
    assert graph.client.call(channels.RESET, WAIT).success
    assert graph.plan().id == plan_id
    result = graph.execute(plan_id)
    assert result['outcome'] == 'succeeded', result


def publishers(graph) -> dict:
    """A publisher for every topic that a node of the graph listens to, by its name; one that is latched suits them all."""
    found = {}
    for node in NODES:
        for topic, (kind, *_) in graph.node.get_subscriber_names_and_types_by_node(
            node, '/wholearm'
        ):
            if topic not in found and topic != '/clock':
                found[topic] = graph.node.create_publisher(
                    message_class(kind), topic, channels.LATCHED
                )
                graph.wait(found[topic].get_subscription_count, f'subscribers of {topic}')
    return found


def test_every_subscriber_survives_everything_well_typed(running):
    graph, plan_id = running
    outlets = publishers(graph)
    assert len(outlets) >= 18, sorted(outlets)

    @every(100)
    @given(st.data())
    def throw(data):
        for topic, outlet in outlets.items():
            outlet.publish(data.draw(messages(outlet.msg_type), topic))
        graph.client.executor.spin_once(timeout_sec=0.0)
        graph.processes.check()

    throw()

    @every(100)
    @given(st.binary(max_size=80))
    def throw_bytes(noise):
        for outlet in outlets.values():
            if outlet.msg_type is JointState:
                outlet.publish(b'\0\1\0\0' + noise)

    throw_bytes()
    assert GoalStatusArray in {outlet.msg_type for outlet in outlets.values()}
    for outlet in outlets.values():
        graph.node.destroy_publisher(outlet)
    still_does_its_job(graph, plan_id)


def test_every_service_survives_every_request(running):
    graph, plan_id = running
    services = {}
    for node in NODES:
        for name, (kind, *_) in graph.node.get_service_names_and_types_by_node(node, '/wholearm'):
            services[name] = message_class(kind)
    assert len(services) >= 6 * len(NODES), sorted(services)
    for name, kind in services.items():
        client = graph.node.create_client(kind, name)
        graph.wait(client.service_is_ready, f'service {name}')

        @every(2 if PLANNING in name else 15)
        @given(messages(kind.Request))
        def call(request):
            future = client.call_async(request)
            graph.wait(future.done, f'answer of {name} to {request}')

        call()
        graph.node.destroy_client(client)
    still_does_its_job(graph, plan_id)


def damaged(text: str, rng: random.Random) -> str:
    """Cut off, a character changed, or a piece doubled."""
    at = rng.randrange(1, len(text))
    return rng.choice(
        [
            text[:at],
            text[:at] + rng.choice('{}[]",:0-e') + text[at + 1 :],
            text[:at] + text[at // 2 :],
        ]
    )


def test_damaged_documents_are_refused(running):
    graph, plan_id = running
    documents = {
        channels.CONTACT_PLAN: graph.client.latest.plan.to_json(),
        channels.MANIPULATION_TRAJECTORY: graph.client.latest.trajectory.to_json(),
    }
    rng = random.Random(1)
    for topic, document in documents.items():
        outlet = graph.talk(topic)
        for _ in range(20):
            outlet.publish(String(data=damaged(document, rng)))
            for node in ('trajectory_generator', 'mode_switcher'):
                answers(graph, node)
        graph.node.destroy_publisher(outlet)
    still_does_its_job(graph, plan_id)
