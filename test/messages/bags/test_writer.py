"""The output of our bag writer, read by rosbag and by our reader."""

import subprocess

import pytest
import rosbag

from old_messages import old_message, serialized
from pioneer_control.bags.reader import read_bag
from pioneer_control.bags.writer import CHUNK_SIZE, BagWriter

SONAR = old_message("SonarArray", "p2os_msgs")
MOTORS = old_message("MotorState", "pioneer_control")


def header(message, caller, latching="0"):
    """Return the fields of a connection as a recorder has them."""
    return dict(topic="/topic", type=message._type, md5sum=message._md5sum, message_definition=message._full_text,
                callerid=caller, latching=latching)


@pytest.fixture(params=["none", "bz2", "lz4"])
def bag(request, tmp_path):
    """A bag of 30000 messages, of two publishers and two types on one topic, and what was written.

    Returns:
        Its path, its compression, and (type, caller, latching, bytes, ns) of each message.
    """
    path = str(tmp_path / "x.bag")
    writer = BagWriter(path, request.param)
    connections = [writer.connect("/topic", header(message, caller, latching))
                   for message, caller, latching in ((SONAR, "/one", "0"), (SONAR, "/two", "1"), (MOTORS, "/two", "0"))]
    data = [serialized(SONAR), serialized(SONAR), serialized(MOTORS)]
    for count in range(10000):
        for number, connection in enumerate(connections):
            writer.write(connection, data[number], 5 + 10 ** 6 * (3 * count + number))
    writer.close()
    named = [("p2os_msgs/SonarArray", "/one", "0"), ("p2os_msgs/SonarArray", "/two", "1"),
             ("pioneer_control/MotorState", "/two", "0")]
    return path, request.param, [(*named[count % 3], data[count % 3], 5 + 10 ** 6 * count) for count in range(30000)]


def test_rosbag_reads_it(bag):
    path, compression, written = bag
    with rosbag.Bag(path) as read:
        assert read.get_compression_info().compression == compression
        assert len(read._chunks) > 2 and len(list(read._get_connections())) == 3
        assert [(raw[0], fields["callerid"].decode(), fields["latching"].decode(), raw[1], time.to_nsec())
                for _, raw, time, fields in read.read_messages(raw=True, return_connection_header=True)] == written
        assert read.get_message_count("/topic") == 30000


def test_our_reader_reads_it(bag):
    path, compression, written = bag
    reader = read_bag(path)
    assert [(connection.type, connection.caller, connection.header["latching"], data, time)
            for _, connection, data, time in reader] == written
    assert (reader.damage, reader.compression) == ("", compression)


def test_the_commands_of_rosbag_read_it(bag):
    said = subprocess.run(["rosbag", "info", "--yaml", bag[0]], check=True, stdout=subprocess.PIPE, text=True).stdout
    assert "messages: 30000" in said and "duration: 29.999" in said


def test_memory_is_that_of_a_chunk(tmp_path):
    """The writer keeps no message after it is written."""
    writer = BagWriter(str(tmp_path / "x.bag"))
    connection = writer.connect("/topic", header(SONAR, "/one"))
    for count in range(3 * CHUNK_SIZE // 100):
        writer.write(connection, bytes(100), count)
        assert len(writer._chunk) <= CHUNK_SIZE + 200 and sum(map(len, writer._index.values())) < CHUNK_SIZE / 100
    writer.close()


def test_one_that_is_not_closed_does_not_look_whole(tmp_path):
    writer = BagWriter(str(tmp_path / "x.bag"))
    writer.write(writer.connect("/topic", header(SONAR, "/one")), serialized(SONAR), 1)
    writer._file.close()
    with pytest.raises(rosbag.ROSBagUnindexedException):
        rosbag.Bag(str(tmp_path / "x.bag"))


def test_without_messages(tmp_path):
    BagWriter(str(tmp_path / "x.bag")).close()
    with rosbag.Bag(str(tmp_path / "x.bag")) as read:
        assert list(read.read_messages()) == []
