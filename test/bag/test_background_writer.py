"""The thread that writes a bag: nothing waits for it, nothing is lost, and the bag is whole at each checkpoint."""

import threading
import time

import pytest
from rosbags.highlevel import AnyReader

from wholearm_ros.bag import background_writer
from wholearm_ros.bag.background_writer import BackgroundWriter
from wholearm_ros.bag.reader import Bag
from wholearm_ros.bag.types import jazzy_typestore
from wholearm_ros.errors import BagError

DATA = jazzy_typestore().serialize_cdr(
    jazzy_typestore().types['std_msgs/msg/Float64'](data=1.0), 'std_msgs/msg/Float64'
)


def opened(path, storage):
    writer = BackgroundWriter(path, storage)
    store = jazzy_typestore()
    return writer, writer.add_connection('/value', 'std_msgs/msg/Float64', typestore=store)


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_every_message_is_in_the_bag_in_its_order(tmp_path, storage):
    writer, connection = opened(tmp_path / 'bag', storage)
    for k in range(5000):
        writer.put(connection, k, DATA)
        if k % 500 == 0:
            writer.checkpoint()
    writer.close()
    assert writer.recorded == 5000 and not writer.lost and not writer.problem
    with AnyReader([tmp_path / 'bag']) as bag:
        assert [when for _, when, _ in bag.messages()] == list(range(5000))


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_what_was_put_before_a_checkpoint_can_be_read_while_recording_goes_on(tmp_path, storage):
    writer, connection = opened(tmp_path / 'bag', storage)
    for k in range(100):
        writer.put(connection, k, DATA)
    writer.checkpoint()
    while writer.recorded < 100:
        time.sleep(0.01)
    with Bag(tmp_path / 'bag') as bag:
        assert len(bag.messages('value')) == 100
    writer.close()


def test_putting_does_not_wait_for_the_disk(tmp_path, monkeypatch):
    """A checkpoint that never ends holds up no message: more than the limit are counted as lost."""
    monkeypatch.setattr(background_writer, 'WAITING', 1000)
    writer, connection = opened(tmp_path / 'bag', 'mcap')
    release = threading.Event()
    writer._bag.checkpoint = release.wait
    writer.checkpoint()
    for k in range(1010):
        writer.put(connection, k, DATA)
    assert writer.lost == 10
    release.set()
    writer.close()
    assert writer.recorded == 1000


def test_a_bag_that_exists_or_cannot_be_made_is_refused(tmp_path):
    with pytest.raises(BagError, match='exists'):
        BackgroundWriter(tmp_path, 'mcap')
    (tmp_path / 'file').write_text('')
    with pytest.raises(BagError, match='cannot be written'):
        BackgroundWriter(tmp_path / 'file' / 'bag', 'mcap')


def test_every_channel_bears_the_hash_of_its_type_as_rosbag2_writes_it(tmp_path):
    """In the data and in the index behind them, so that a bag without metadata.yaml tells it, too."""
    writer, connection = opened(tmp_path / 'bag', 'mcap')
    writer.put(connection, 1, DATA)
    writer.close()
    key, value = b'topic_type_hash', jazzy_typestore().hash_rihs01('std_msgs/msg/Float64').encode()
    told = b''.join(len(text).to_bytes(4, 'little') + text for text in (key, value))
    (file,) = (tmp_path / 'bag').glob('*.mcap')
    assert value.startswith(b'RIHS01_') and len(value) == 71
    assert file.read_bytes().count(told) == 2
    (tmp_path / 'bag' / 'metadata.yaml').unlink()
    with AnyReader([file]) as bag:
        (one,) = bag.connections
        assert one.ext.offered_qos_profiles == connection.ext.offered_qos_profiles
        assert [data for _, _, data in bag.messages()] == [DATA]
