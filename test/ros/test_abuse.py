"""Arbitrary well-typed messages and damaged documents: every node stays alive and still does its job after."""
import math
import random

import pytest
from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from wholearm_ros.model.hand import JOINT_NAMES
from wholearm_ros.ros import channels

pytestmark = [pytest.mark.faults, pytest.mark.timeout(280)]
ALL = ('hand_hardware', 'mode_switcher', 'velocity_controller', 'torque_controller', 'trajectory_generator',
       'contact_state_planner')

numbers = st.one_of(st.floats(), st.sampled_from([0.0, 1e308, -1e308, math.inf, -math.inf, math.nan]))
columns = st.lists(numbers, max_size=3)
names = st.lists(st.one_of(st.sampled_from(JOINT_NAMES), st.text(max_size=8).filter(lambda t: '\0' not in t and
                                                                                    t.isprintable())), max_size=3)
texts = st.text(max_size=200).filter(lambda t: '\0' not in t and t.isprintable())


@st.composite
def joint_states(draw):
    message = JointState(name=draw(names), position=draw(columns), velocity=draw(columns), effort=draw(columns))
    message.header.stamp.sec = draw(st.integers(-2 ** 31, 2 ** 31 - 1))
    message.header.stamp.nanosec = draw(st.integers(0, 2 ** 32 - 1))
    return message


@st.composite
def goals(draw):
    message = GoalInfo()
    message.goal_id.uuid = list(draw(st.binary(min_size=16, max_size=16)))
    return message


@st.composite
def statuses(draw):
    return GoalStatusArray(status_list=[GoalStatus(goal_info=draw(goals()), status=draw(st.integers(-128, 127)))
                                        for _ in range(draw(st.integers(0, 3)))])


def damaged(text: str, rng: random.Random) -> str:
    """Cut off, a character changed, or a piece doubled."""
    at = rng.randrange(1, len(text))
    return rng.choice([text[:at], text[:at] + rng.choice('{}[]",:0-e') + text[at + 1:], text[:at] + text[at // 2:]])


def test_nodes_survive_everything_well_typed(graph):
    graph.start(ALL, hand_hardware={'motor_rate': 200.0}, torque_controller={'motor_rate': 200.0})
    graph.client.wait_for_graph(120.0)
    plan = graph.plan()
    documents = {channels.CONTACT_PLAN: graph.client.heard.plan.to_json(),
                 channels.MANIPULATION_TRAJECTORY: graph.client.heard.trajectory.to_json()}
    jointed = [graph.talk(t) for t in (channels.JOINT_STATES, channels.JOINT_COMMANDS, channels.VELOCITY_SETPOINT,
                                       channels.TORQUE_SETPOINT)]
    goal_topics = [graph.talk(channels.GOAL), graph.talk(channels.CANCEL)]
    texted = {t: graph.talk(t) for t in (*documents, channels.MODE)}
    status = graph.talk(channels.GOAL_STATUS)

    @settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
    @given(joint_states(), goals(), statuses(), texts)
    def throw(joint_state, goal, state, text):
        for publisher in jointed:
            publisher.publish(joint_state)
        for publisher in goal_topics:
            publisher.publish(goal)
        for publisher in texted.values():
            publisher.publish(String(data=text))
        status.publish(state)
        graph.client.executor.spin_once(timeout_sec=0.0)
        graph.processes.check()
    throw()

    rng = random.Random(1)
    for _ in range(60):
        for topic, document in documents.items():
            texted[topic].publish(String(data=damaged(document, rng)))
        graph.client.executor.spin_once(timeout_sec=0.02)
        graph.processes.check()

    # A lie about joint_states with a stamp far ahead may have stopped the switcher's clock; the reset starts over.
    for publisher in (*jointed, *goal_topics, *texted.values(), status):
        graph.node.destroy_publisher(publisher)
    graph.client.heard.trajectory = None
    assert graph.client.call(channels.RESET, 60.0).success
    assert graph.plan().id == plan.id
    result = graph.execute(plan.id)
    assert result['outcome'] == 'succeeded', result
