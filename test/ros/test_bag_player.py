"""The bag player: what was recorded, byte for byte, from where, how fast and which topics it is told."""

import tempfile
import time
from pathlib import Path

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from wholearm_ros.bag.reader import Bag
from wholearm_ros.bag.types import jazzy_typestore
from wholearm_ros.errors import BagError
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.bag_types import type_name
from wholearm_ros.ros.interface.messages import NANOSECONDS, to_nanoseconds

pytestmark = pytest.mark.timeout(280)
BAG = Path(__file__).parents[2] / 'bags' / 'asymmetric_hexagon'
DEEP = QoSProfile(depth=5000, reliability=ReliabilityPolicy.RELIABLE)
DEEP_LATCHED = QoSProfile(
    depth=100, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)
START, RATE = 1.5, 4.0  # [s], factor


def test_offset_rate_topics_and_clock(graph):
    with Bag(BAG) as bag:
        recorded = [(c.topic, at, bytes(data)) for c, at, data in bag.raw()]
        begin = bag.start + round(START * NANOSECONDS)
    wanted = [
        data for topic, at, data in recorded if topic.endswith('/joint_states') and at >= begin
    ]
    latched = [data for topic, at, data in recorded if topic.endswith('/mode') and at < begin][-1]
    modes_after = [data for topic, at, data in recorded if topic.endswith('/mode') and at >= begin]
    span = (recorded[-1][1] - begin) / NANOSECONDS

    states, modes, others, clock = [], [], [], graph.listen(channels.CLOCK)
    for topic, found, qos in (
        (channels.JOINT_STATES, states, DEEP),
        (channels.MODE, modes, DEEP_LATCHED),
        (channels.OBJECT_POSE, others, channels.BEST_EFFORT),
    ):
        graph.node.create_subscription(topic.type, topic.name, found.append, qos, raw=True)
    began = time.monotonic()
    graph.processes.start(
        'bag_player',
        {
            'path': str(BAG),
            'topics': ['joint_states', 'mode'],
            'start': START,
            'rate': RATE,
            'clock': 50.0,
            'wait_for_subscribers': 30.0,
            'stay': True,
        },
    )
    graph.wait(
        lambda: len(states) == len(wanted) and len(modes) == 1 + len(modes_after), 'the whole of it'
    )
    assert time.monotonic() - began >= 0.9 * span / RATE, 'not faster than it was told'
    assert [bytes(s) for s in states] == wanted
    assert [bytes(m) for m in modes] == [latched, *modes_after], (
        'the newest latched message of before comes first'
    )
    assert not others, 'only the topics asked for'
    stamps = [to_nanoseconds(m.clock) for m in clock]
    assert stamps == sorted(stamps) and begin <= stamps[0] and stamps[-1] <= recorded[-1][1]
    assert len(stamps) > 10


def test_it_ends_by_itself_and_says_how_much_it_played(graph):
    graph.processes.start(
        'bag_player', {'path': str(BAG), 'topics': ['contact_plan'], 'rate': 1000.0}
    )
    process = graph.processes._running['bag_player']
    assert process.wait(timeout=60) == 0
    assert 'played 1 messages' in graph.processes.log_of('bag_player').read_text()


def test_a_bag_names_the_types_by_the_hashes_of_the_middleware(graph):
    node, store = graph.node, jazzy_typestore()
    for topic in channels.RECORDED:
        node.create_publisher(topic.type, f'hashed/{topic.name.strip("/")}', topic.qos)
        (told,) = node.get_publishers_info_by_topic(f'hashed/{topic.name.strip("/")}')
        assert str(told.topic_type_hash) == store.hash_rihs01(type_name(topic.type))


def test_a_bag_that_was_cut_off_opens_up_to_the_cut(tmp_path, monkeypatch):
    """What is lost is the record that was cut: of the recorder's, what came in between two of its checkpoints."""
    monkeypatch.setattr(tempfile, 'tempdir', str(tmp_path))
    with Bag(BAG) as whole:
        recorded = [(c.topic, at, bytes(data)) for c, at, data in whole.raw()]
    counts = []
    for share in (0.1, 0.3, 0.5, 0.7, 0.9, 0.999):
        cut = _cut_copy(tmp_path / str(share), lambda data: data[: int(share * len(data))])
        with Bag(cut) as bag:
            found = [(c.topic, at, bytes(data)) for c, at, data in bag.raw()]
            assert bag.cut == [f'{BAG.name}.mcap']
        assert found == recorded[: len(found)]
        counts.append(len(found))
    assert counts == sorted(counts) and 0 < counts[2] < counts[4] and counts[-1] == len(recorded)
    assert not list(tmp_path.glob('wholearm_bag_*')), 'the mended copy is gone'


def test_a_cut_off_bag_is_played_up_to_the_cut(graph, tmp_path):
    cut = _cut_copy(tmp_path, lambda data: data[: len(data) // 2])
    graph.processes.start('bag_player', {'path': str(cut), 'rate': 1000.0})
    assert graph.processes._running['bag_player'].wait(timeout=60) == 0
    said = graph.processes.log_of('bag_player').read_text()
    assert (
        'was cut off; played up to its last whole record' in said
        and 'played 0 messages' not in said
    )


def test_bytes_that_are_no_bag_are_refused_with_a_reason(tmp_path):
    with pytest.raises(BagError, match='cannot be read as a bag'):
        Bag(_cut_copy(tmp_path, lambda data: bytes(len(data)))).__enter__()


def _cut_copy(directory, cut):
    """The reference bag with `cut` done to the bytes of its messages."""
    copy = directory / 'bag'
    copy.mkdir(parents=True)
    for file in BAG.iterdir():
        (copy / file.name).write_bytes(
            cut(file.read_bytes()) if file.suffix == '.mcap' else file.read_bytes()
        )
    return copy
