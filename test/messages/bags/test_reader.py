"""Bags read from front to back. Good bags must give what rosbag gives, and damaged bags all that can still be read."""

import bz2
import itertools
import random
import re
import struct
import tracemalloc

import genpy
import pytest
import rosbag
from std_msgs.msg import Header, String

import bag_factory as make
from pioneer_control.bags import reader as reading
from pioneer_control.bags import records as form
from pioneer_control.bags.reader import BagError, decode, message_class, read_bag

COMPRESSIONS = ["none", "bz2", "lz4"]
RECORD = 59  # bytes of one of the `texts`, whose text begins at 50
PADDING = range(200, 4110)  # of the file's first record: spaces that nobody reads


def texts(count):
    """Return (topic, message, seconds): texts on two topics, a second apart, all different."""
    return [("/even" if number % 2 == 0 else "/odd", String("text %04d" % number), 100.0 + number)
            for number in range(count)]


def small(path, compression="none", count=7, chunk=200):
    """Return the bytes of a bag with some texts in several chunks."""
    with rosbag.Bag(str(path), "w", compression=compression, chunk_threshold=chunk) as bag:
        for topic, message, seconds in texts(count):
            bag.write(topic, message, genpy.Time.from_sec(seconds))
    return path.read_bytes()


def only(*topics):
    """Return a function that says whether the topic of a connection is one of a few."""
    return lambda connection: connection.topic in topics


@pytest.fixture
def read(tmp_path):
    """Read bytes as a bag. Returns (topic, data, time) of each message, and the damage."""

    def read(content, **options):
        path = tmp_path / "read.bag"
        path.write_bytes(content)
        reader = read_bag(str(path), **options)
        return [(message.topic, message.data, message.time) for message in reader], reader.damage

    return read


def by_rosbag(path):
    """Return (topic, data, time) of each message, as rosbag reads them."""
    with rosbag.Bag(str(path)) as bag:
        return [(topic, raw[1], time.to_nsec()) for topic, raw, time in bag.read_messages(raw=True)]


def apart(messages):
    """Return the same messages with different times. rosbag does not say in which order it returns messages of one
    time.
    """
    return [(topic, message, seconds + 1e-6 * number) for number, (topic, message, seconds) in enumerate(messages)]


@pytest.mark.parametrize("definition, sound", [
    ("std_msgs/Empty[] many\n====\nMSG: std_msgs/Empty\n", False),
    ("B[2] b\n====\nMSG: x/B\n# nothing\nint8 ONE=1\n", False),
    ("float64[99999999] much", False), ("std_msgs/Empty one\n====\nMSG: std_msgs/Empty\n", True),
    ("B[] b\n====\nMSG: x/B\nint8 a\n", True),
    ("float64[36] covariance", True)])
def test_definitions_of_more_values_than_there_are_bytes(definition, sound):
    """Eight bytes of such a message would fill any memory."""
    connection = reading.BagConnection("/x", "x/Strange", "0" * 32, definition.replace("====", "=" * 80), False, "", {})
    if sound:
        assert message_class(connection)
    else:
        with pytest.raises(BagError, match="definition of x/Strange makes no sense"):
            message_class(connection)


class TestGoodBags:
    @pytest.mark.parametrize("compression", COMPRESSIONS)
    @pytest.mark.parametrize("chunk", [1, 5000, 1 << 20])
    def test_the_same_as_rosbag(self, tmp_path, read, compression, chunk):
        path = tmp_path / "run.bag"
        with rosbag.Bag(str(path), "w", compression=compression, chunk_threshold=chunk) as bag:
            for topic, message, seconds in apart(make.eventful()):
                bag.write(topic, message, genpy.Time.from_sec(seconds))
        messages, damage = read(path.read_bytes())
        assert messages == by_rosbag(path) and len(messages) > 1000 and damage == ""

    @pytest.mark.parametrize("compression", COMPRESSIONS)
    def test_the_same_in_whatever_order_it_was_recorded(self, tmp_path, read, compression):
        path, messages = tmp_path / "run.bag", texts(300)
        random.Random(1).shuffle(messages)
        with rosbag.Bag(str(path), "w", compression=compression, chunk_threshold=500) as bag:
            for topic, message, seconds in messages:
                bag.write(topic, message, genpy.Time.from_sec(seconds))
        # rosbag mixes its own lists up there
        assert read(path.read_bytes()) == (sorted(by_rosbag(path), key=lambda message: message[2]), "")

    def test_messages_of_one_time_come_as_they_were_recorded(self, tmp_path, read):
        path = make.write_bag(tmp_path / "run.bag",
                              [("/%s" % (number % 3), String(str(number)), 5.0) for number in range(20)])
        messages, _ = read(open(path, "rb").read())
        assert [data[4:] for _, data, _ in messages] == [str(number).encode() for number in range(20)]

    def test_decoded_they_are_what_was_recorded(self, tmp_path):
        path = make.write_bag(tmp_path / "run.bag", make.driven(seconds=1))
        with rosbag.Bag(path) as bag:
            recorded = sorted((topic, str(message)) for topic, message, _ in bag.read_messages())
        assert sorted((entry.topic, str(decode(entry.connection, entry.data))) for entry in read_bag(path)) == recorded

    def test_a_connection_says_who_sent_what(self, tmp_path):
        path = make.write_bag(tmp_path / "run.bag", make.driven(seconds=1), latched=["/pioneer/world"])
        known = {connection.topic: connection for connection in read_bag(path).connections}
        world = known["/pioneer/world"]
        assert (world.type, world.md5sum, world.latching) == ("std_msgs/String", String._md5sum, True)
        assert not known["/pioneer/pose"].latching and known["/pioneer/pose"].definition.startswith("# This represents")

    @pytest.mark.parametrize("package", ["p2os_driver", "p2os_msgs", "pioneer_control"])
    def test_types_that_are_not_installed(self, tmp_path, package):
        reader = read_bag(make.write_bag(tmp_path / "run.bag", [("/sonar", make.sonar([1.0, 2.0], package), 1.0)]))
        assert [list(decode(entry.connection, entry.data).ranges) for entry in reader] == [[1.0, 2.0]]

    def test_a_message_of_no_sense(self, tmp_path):
        reader = read_bag(make.write_bag(tmp_path / "run.bag", [("/sonar", make.sonar([1.0, 2.0]), 1.0)]))
        message = next(iter(reader))
        with pytest.raises(BagError, match="a message on /sonar is damaged"):
            decode(message.connection, message.data[:-3])

    def test_a_definition_of_no_sense(self, tmp_path):
        reader = read_bag(make.write_bag(tmp_path / "run.bag", [("/text", String("x"), 1.0)]))
        with pytest.raises(BagError, match="definition of other/String makes no sense"):
            message_class(reader.connections[0]._replace(type="other/String", definition="strin data"))

    def test_without_messages(self, tmp_path, read):
        assert read(open(make.write_bag(tmp_path / "run.bag", []), "rb").read()) == ([], "")

    def test_a_chunk_without_messages(self, tmp_path, read):
        content = small(tmp_path / "run.bag", count=4)
        fields = b"".join(struct.pack("<I", len(field)) + field
                          for field in (b"op=\x05", b"compression=none", b"size=\0\0\0\0"))
        empty = struct.pack("<I", len(fields)) + fields + bytes(4)
        first = content.index(b"\x04\0\0\0op=\x05") - 4
        messages, damage = read(content[:first] + empty + content[first:])
        assert [data[4:] for _, data, _ in messages] == [("text %04d" % number).encode() for number in range(4)]
        assert "index" in damage  # whose places are wrong now


class TestChoosing:
    @pytest.mark.parametrize("compression", COMPRESSIONS)
    def test_topics(self, tmp_path, read, compression):
        content = small(tmp_path / "run.bag", compression)
        messages, damage = read(content, is_wanted=only("/odd"))
        assert messages == [entry for entry in read(content)[0] if entry[0] == "/odd"] and damage == ""

    def test_chunks_without_them_are_not_even_read(self, tmp_path, read, monkeypatch):
        path = tmp_path / "run.bag"
        messages = [("/image", String("x" * 5000), float(number)) for number in range(100)]
        messages.insert(50, ("/text", String("here"), 49.5))
        with rosbag.Bag(str(path), "w", compression="bz2", chunk_threshold=5000) as bag:
            for topic, message, seconds in messages:
                bag.write(topic, message, genpy.Time.from_sec(seconds))
        opened = []
        monkeypatch.setattr(reading, "decompressed", lambda *chunk: opened.append(chunk) or form.decompressed(*chunk))
        reader = read_bag(str(path), only("/text"))
        assert [message.time for message in reader] == [49_500_000_000] and len(opened) < 3
        assert (reader.begin, reader.end) == (0, 99_000_000_000)  # of all

    def test_what_is_there_is_known_before_it_is_read(self, tmp_path):
        small(tmp_path / "run.bag")
        reader = read_bag(str(tmp_path / "run.bag"), only())
        assert sorted(connection.topic for connection in reader.connections) == ["/even", "/odd"]

    def test_long_messages_that_nobody_wants_are_not_read(self, tmp_path, monkeypatch):
        path = make.unclosed(tmp_path / "run.bag.active",
                             [("/image", String("x" * 10_000_000), 1.0), ("/text", String("here"), 2.0)], chunk=1 << 30)
        got = []
        pread = reading.os.pread
        monkeypatch.setattr(reading.os, "pread", lambda *where: got.append(pread(*where)) or got[-1])
        assert len(list(read_bag(path, only("/text")))) == 1 and sum(map(len, got)) < 1_000_000


class TestParts:
    def test_one_after_the_other(self, tmp_path):
        paths = [make.write_bag(tmp_path / ("run_%s.bag" % part), texts(30)[10 * part:10 * part + 10])
                 for part in range(3)]
        reader = read_bag(paths)
        assert [message.time // 10**9 for message in reader] == list(range(100, 130)) and reader.damage == ""

    def test_one_that_is_empty_loses_no_other(self, tmp_path):
        paths = [make.write_bag(tmp_path / "run_0.bag", texts(5)), str(tmp_path / "run_1.bag.active")]
        open(paths[1], "w").close()
        make.cut(paths[0], 0.9)
        reader = read_bag(paths)
        assert len(list(reader)) == 5 and re.match("run_0.bag: it is cut off|run_0.bag: its index is", reader.damage)
        assert "run_1.bag.active is empty (0 bytes)" in reader.damage

    def test_what_is_in_them_is_known_before_when_all_were_closed(self, tmp_path):
        closed = make.write_bag(tmp_path / "run_0.bag", texts(5))
        unclosed = make.unclosed(tmp_path / "run_1.bag.active", texts(5))
        assert read_bag([closed, closed]).indexed
        assert not read_bag([closed, unclosed]).indexed
        assert not read_bag([unclosed, closed]).indexed

    def test_one_that_is_not_there_is_a_mistake(self, tmp_path):
        with pytest.raises(BagError, match="missing.bag: no such file"):
            read_bag([make.write_bag(tmp_path / "run_0.bag", texts(5)), str(tmp_path / "missing.bag")])

    def test_progress(self, tmp_path):
        paths = [make.write_bag(tmp_path / ("run_%s.bag" % part), texts(10)) for part in range(2)]
        told = []
        list(read_bag(paths, progress=lambda done, whole: told.append((done, whole))))
        sizes = [len(open(path, "rb").read()) for path in paths]
        assert told[-1] == (sum(sizes), sum(sizes)) and (sizes[0], sum(sizes)) in told
        assert told == sorted(set(told)) and {whole for _, whole in told} == {sum(sizes)}


class TestCut:
    @pytest.mark.parametrize("compression", COMPRESSIONS)
    @pytest.mark.parametrize("closed", [True, False])
    def test_at_every_byte(self, tmp_path, read, compression, closed):
        """The reader never raises and never returns a wrong message. A longer piece never gives fewer messages. Without
        compression, it returns all whole messages.
        """
        if closed:
            content = small(tmp_path / "run.bag", compression)
        else:
            content = open(make.unclosed(tmp_path / "run.bag", texts(7), compression, chunk=200), "rb").read()
        whole, _ = read(content)
        ends = [content.index(data) + len(data) for _, data, _ in whole] if compression == "none" else []
        before = 0
        for length in itertools.chain(range(13, PADDING.start), range(PADDING.stop, len(content))):
            messages, damage = read(content[:length])
            assert messages == whole[:len(messages)] and len(messages) >= before, length
            assert compression != "none" or len(messages) == sum(end <= length for end in ends), length
            assert damage, length
            before = len(messages)
        assert before in (len(whole), len(whole) - 1) and len(whole) > 3

    @pytest.mark.parametrize("length", range(1, 13))
    def test_in_its_first_bytes(self, tmp_path, read, length):
        with pytest.raises(BagError, match="is not a bag, or nothing is left of it"):
            read(small(tmp_path / "run.bag")[:length])

    def test_what_is_said(self, tmp_path, read):
        content = small(tmp_path / "run.bag", count=100)
        _, damage = read(content[:len(content) // 2])
        pattern = r"it is cut off after (.*) s, at (.*) % of its length: the rest is missing."
        seconds, share = re.fullmatch(pattern, damage).groups()
        assert 20 < float(seconds) < 60 and 50 < float(share) < 70  # of what comes before the index

    @pytest.mark.parametrize("compression", COMPRESSIONS)
    def test_what_is_said_of_a_killed_recorder(self, tmp_path, compression):
        reader = read_bag(make.unclosed(tmp_path / "run.bag.active", texts(50), compression, chunk=300))
        count = len(list(reader))
        assert count == 50 if compression == "none" else count > 40
        assert "it was not closed and ends after %s.0 s" % (
            count - 1) in reader.damage or "ends within a message" in reader.damage


class TestDamage:
    @pytest.mark.parametrize("compression", COMPRESSIONS)
    def test_bytes_flipped(self, tmp_path, read, compression):
        """The reader never raises. When a message is missing, the reader says so. Without compression, at most two
        messages differ or are missing, unless the flipped bit is in the description of a topic.
        """
        content = small(tmp_path / "run.bag", compression)
        whole, _ = read(content)
        connections = [found.start() for found in re.finditer(rb"\x04\0\0\0op=\x07", content)]
        step = 1 if compression == "none" else 3  # most bytes of a compressed chunk are like each other
        for position in itertools.chain(range(PADDING.start), range(PADDING.stop, len(content), step)):
            flipped = bytearray(content)
            flipped[position] ^= 1 << position % 8
            messages, damage = read(bytes(flipped))
            lost = len([message for message in whole if message not in messages])
            in_connection = any(start - 4 <= position < start + 160 for start in connections)
            assert len(messages) == len(whole) or damage, position
            assert lost <= (2 if compression == "none" else 8) or in_connection and damage, position

    @pytest.mark.parametrize("compression", COMPRESSIONS)
    def test_random_damage(self, tmp_path, read, compression):
        """The reader never raises, and returns no message twice."""
        chance = random.Random(5)
        content = small(tmp_path / "run.bag", compression, count=40)
        for _ in range(100):
            damaged = bytearray(content)
            for _ in range(chance.randrange(1, 6)):
                begin = chance.randrange(13, len(content))
                length = chance.randrange(1, 400)
                action = chance.randrange(3)
                if action == 0:
                    damaged[begin:begin + length] = bytes(chance.randrange(256) for _ in range(length))
                elif action == 1:
                    del damaged[begin:begin + length]
                else:
                    damaged[begin:begin] = bytes(length)
            messages, damage = read(bytes(damaged))
            assert len(set(messages)) == len(messages) and (len(messages) == 40 or damage)

    def test_what_is_said(self, tmp_path, read):
        content = small(tmp_path / "run.bag", count=100)
        position = content.index(b"text 0050") - 50
        messages, damage = read(content[:position] + bytes(RECORD) + content[position + RECORD:])
        assert len(messages) == 99
        assert re.search(r"it is damaged at \d+ % of the file, after 49.0 s: \d+ bytes there are no messages", damage)
        assert "1 message that it lists could not be read" in damage

    def test_many_places_are_not_all_told(self, tmp_path, read):
        content = bytearray(small(tmp_path / "run.bag", count=100))
        for number in range(10, 30, 2):
            position = content.index(b"text %04d" % number) - 50
            content[position:position + RECORD] = bytes(RECORD)
        messages, damage = read(bytes(content))
        assert len(messages) == 90 and damage.count("it is damaged at") == 3 and "7 more places" in damage

    def test_messages_that_nothing_describes(self, tmp_path, read):
        content = open(make.unclosed(tmp_path / "run.bag", texts(12), chunk=1 << 20), "rb").read()
        messages, damage = read(content.replace(b"topic=/odd", b"tipoc=/odd"))
        assert {topic for topic, _, _ in messages} == {"/even"}
        assert "6 messages cannot be understood: the description of the topic is lost" in damage

    def test_connections_in_the_index_alone(self, tmp_path, read):
        content = small(tmp_path / "run.bag")
        first = content.index(b"topic=/odd")
        assert len(read(content[:first] + b"t?pic" + content[first + 5:])[0]) == 7

    @pytest.mark.parametrize("compression", COMPRESSIONS)
    def test_an_index_that_is_elsewhere_still_describes(self, tmp_path, read, compression):
        """The chunk with the connections is lost, and missing bytes have moved the index."""
        content = small(tmp_path / "run.bag", compression, count=40)
        first = content.index(b"\x04\0\0\0op=\x05") + 40
        messages, damage = read(content[:first] + content[first + 100:])
        assert 30 < len(messages) <= 40 and "its index is damaged" in damage

    def test_connections_in_the_chunks_alone(self, tmp_path, read):
        content = small(tmp_path / "run.bag")
        last = [found.start() for found in re.finditer(b"topic=/odd", content)][2]  # each stands in header and data
        messages, damage = read(content[:last] + b"t?pic" + content[last + 5:])
        assert len(messages) == 7 and "index" in damage

    def test_a_topic_with_two_descriptions(self, tmp_path, read):
        content = small(tmp_path / "run.bag")
        assert "it describes /odd in two ways" in read(content.replace(b"topic=/odd", b"topic=/old", 1))[1]

    def test_a_time_of_no_sense_changes_no_other(self, tmp_path, read):
        content = small(tmp_path / "run.bag", count=100)
        position = content.index(b"text 0050") - 16  # of its time
        path = make.write_bag(tmp_path / "read.bag", [])
        open(path, "wb").write(content[:position] + b"\xff\xff\xff\xff" + content[position + 4:])
        reader = read_bag(path)
        assert len(list(reader)) == 100 and (reader.begin, reader.end) == (100 * 10**9, 199 * 10**9)

    def test_an_index_that_knows_no_times(self, tmp_path):
        content = small(tmp_path / "run.bag", count=20)
        path = tmp_path / "read.bag"
        path.write_bytes(re.sub(rb"((?:start|end)_time=)........", rb"\g<1>" + bytes(8), content, flags=re.DOTALL))
        reader = read_bag(str(path))
        assert len(list(reader)) == 20 and reader.begin == 100 * 10**9

    def test_a_piece_of_a_compressed_chunk_is_no_record(self, tmp_path, read):
        """lz4 does not change bytes that do not repeat. So a compressed chunk may contain something that looks like the
        header of a record, but other bytes follow it.
        """
        content = small(tmp_path / "run.bag", "lz4", count=40)
        whole, _ = read(content)
        header = content.index(b"compression=lz4")
        messages, damage = read(content[:header] + b"C" + content[header + 1:])
        assert set(messages) < set(whole) and damage

    def test_a_chunk_that_grows_without_end(self, tmp_path, read, monkeypatch):
        monkeypatch.setattr(form, "LARGEST_CHUNK", 10_000)
        path = tmp_path / "run.bag"
        with rosbag.Bag(str(path), "w", compression="bz2") as bag:
            bag.write("/text", String("small"), genpy.Time(1))
            bag.write("/text", String("x" * 3_000_000), genpy.Time(2))
        messages, damage = read(path.read_bytes())
        assert len(messages) <= 2 and len(messages) + (damage != "") >= 2

    def test_a_few_bytes_that_become_very_many_at_once(self, monkeypatch):
        """3 kB of bz2 can be 4 GB, all of them in one piece that is read."""
        monkeypatch.setattr(form, "LARGEST_CHUNK", 10_000)
        data = bz2.compress(bytes(50_000_000))
        chunk = form.BagRecord(0, form.CHUNK, {b"compression": b"bz2"}, 0, 0, 0, len(data))
        tracemalloc.start()
        found = form.decompressed(form.source_of_bytes(data), chunk)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert len(found) == 10_000 and most < 10_000_000

    def test_bytes_that_the_disk_has_lost(self, tmp_path, monkeypatch):
        messages = [("/text", String("x" * 1000), float(number)) for number in range(1000)]
        path, pread = make.write_bag(tmp_path / "run.bag", messages), reading.os.pread

        def failing(file, length, position):
            if position < 300_000 < position + length:
                raise OSError(5, "Input/output error")
            return pread(file, length, position)

        monkeypatch.setattr(reading.os, "pread", failing)
        reader = read_bag(path)
        assert 800 < len(list(reader)) < 1000 and "it is damaged at" in reader.damage

    def test_a_file_that_is_cut_off_while_it_is_read(self, tmp_path):
        path = make.unclosed(tmp_path / "run.bag.active",
                             [("/text", String("x" * 1000), float(number)) for number in range(1000)])
        reader = read_bag(path)
        messages = iter(reader)
        next(messages)
        make.cut(path, 500_000)
        assert 300 < len(list(messages)) < 600 and "it was not closed" in reader.damage


class TestIndex:
    """Errors in an index, or in the lists behind the chunks, lose no message, and are reported."""

    @pytest.fixture
    def content(self, tmp_path):
        return small(tmp_path / "run.bag")

    @staticmethod
    def records(content, op):
        """Return the records of a kind, except those in chunks."""
        found = form.records(form.source_of_bytes(content), PADDING.stop + 7)
        return [record for record in found if record.op == op]

    @staticmethod
    def changed(content, position, with_):
        return content[:position] + with_ + content[position + len(with_):]

    def index(self, content):
        return self.records(content, form.CONNECTION)[0].position

    def test_a_connection_that_describes_nothing(self, read, content):
        messages, damage = read(self.changed(content, content.index(b"type=", self.index(content)), b"tipe="))
        assert len(messages) == 7 and "its index is damaged" in damage

    @pytest.mark.parametrize("field", [b"conn_count=", b"chunk_count="])
    def test_a_record_of_it_that_is_missing(self, read, content, field):
        position = content.index(field) + len(field)
        messages, damage = read(self.changed(content, position, bytes([content[position] + 1])))
        assert len(messages) == 7 and "its index is damaged" in damage

    def test_an_index_that_begins_too_early(self, read, content):
        first = self.records(content, form.CHUNK)[0].position
        messages, damage = read(self.changed(content, content.index(b"index_pos=") + 10, struct.pack("<Q", first)))
        assert len(messages) == 7 and "its index is damaged" in damage

    def test_a_bag_that_ends_where_it_begins(self, read, content):
        messages, damage = read(content[:self.index(content)])
        assert len(messages) == 7 and "all messages before it are there" in damage

    def test_bytes_that_are_damaged_in_it_are_no_place_without_messages(self, read, content):
        messages, damage = read(self.changed(content, self.records(content, form.CHUNK_INFO)[1].position, bytes(20)))
        assert len(messages) == 7 and "its index is damaged" in damage and "there are no messages" not in damage

    def test_a_chunk_of_which_it_names_another_connection_is_not_passed_over(self, read, content):
        info = self.records(content, form.CHUNK_INFO)[1]
        messages, _ = read(self.changed(content, info.begin, struct.pack("<I", 0)), is_wanted=only("/odd"))
        assert content[info.begin] == 1 and [time // 10**9 for _, _, time in messages] == [101, 103, 105]

    def test_a_chunk_whose_list_is_lost_is_not_passed_over(self, read, content):
        entry = self.records(content, form.INDEX)[1]
        messages, damage = read(self.changed(content, entry.position, bytes(entry.end - entry.position)))
        assert len(messages) == 7 and damage

    def test_messages_of_a_connection_that_it_does_not_know_are_counted(self, read, content):
        odd, position = self.records(content, form.CONNECTION)[1], content.index(b"conn_count=") + 11
        content = self.changed(content[:odd.position] + content[odd.end:], position, bytes([1]))
        content = content.replace(b"topic=/odd", b"tipoc=/odd")
        messages, damage = read(content)
        assert len(messages) == 4 and "3 messages cannot be understood" in damage

    def test_a_chunk_and_its_list_that_are_damaged_are_one_place(self, tmp_path, read):
        content = small(tmp_path / "run.bag", "bz2")
        chunk, entry = self.records(content, form.CHUNK)[1], self.records(content, form.INDEX)[1]
        _, damage = read(self.changed(content, chunk.begin + 20, bytes(entry.end - chunk.begin - 20)))
        assert entry.position == chunk.end and damage.count("it is damaged at") == 1

    def test_a_message_that_is_lost_with_its_list_is_counted(self, read, content):
        begin, entry = content.index(b"text 0001") - 50, self.records(content, form.INDEX)[1]
        messages, damage = read(self.changed(content, begin, bytes(entry.end - begin)))
        assert len(messages) == 6 and "1 message that it lists could not be read" in damage

    def test_one_that_is_lost_of_a_bag_without_index_too(self, tmp_path, read):
        content = open(make.unclosed(tmp_path / "run.bag", texts(12), chunk=200), "rb").read()
        messages, damage = read(self.changed(content, content.index(b"text 0005") - 50, bytes(RECORD)))
        assert len(messages) == 11 and "1 message that it lists could not be read" in damage

    def test_without_index_a_message_that_came_a_little_late_is_put_in_order(self, tmp_path):
        late = [("/text", String("x" * 300), seconds) for seconds in (1.0, 1.75, 2.0, 1.5, 5.0)]
        reader = read_bag(make.unclosed(tmp_path / "run.bag", late, chunk=200))
        assert [message.time / 1e9 for message in reader] == [1.0, 1.5, 1.75, 2.0, 5.0]

    def test_of_chunks_that_are_passed_over_begin_and_end_count(self, tmp_path):
        path, messages = tmp_path / "run.bag", [("/image", String("x" * 50), float(number)) for number in range(100)]
        messages.insert(50, ("/text", String("here"), 49.5))
        with rosbag.Bag(str(path), "w", chunk_threshold=1000) as bag:
            for topic, message, seconds in messages:
                bag.write(topic, message, genpy.Time.from_sec(seconds))
        reader = read_bag(str(path), only("/text"))
        assert len(list(reader)) == 1 and (reader.begin, reader.end) == (0, 99 * 10**9)


class TestNoBags:
    @pytest.mark.parametrize("content, words", [
        (b"", "is empty .0 bytes.: its recorder wrote nothing, or the disk was full"),
        (b"hello", "is not a bag"),
        (bytes(100_000), "is not a bag"),
        (b"#ROSBAG V1.2\n", "old format 1.2; only 2.0 is read.*rosbag filter"),
    ])
    def test_what_is_said(self, read, content, words):
        with pytest.raises(BagError, match=words):
            read(content)

    def test_a_folder(self, tmp_path):
        with pytest.raises(BagError, match="cannot be read: Is a directory"):
            read_bag(str(tmp_path))

    def test_encrypted(self, tmp_path, read):
        content = small(tmp_path / "run.bag")
        length, = struct.unpack_from("<I", content, 13)
        field = b"encryptor=rosbag/AesCbcEncryptor"[:31]
        header = content[17:17 + length] + struct.pack("<I", len(field)) + field
        with pytest.raises(BagError, match="encrypted"):
            read(form.MAGIC + struct.pack("<I", len(header)) + header + bytes(4) + content[4117:])

    def test_no_part(self):
        with pytest.raises(BagError, match="no bag is named"):
            read_bag([])


class TestMemory:
    def test_what_waits_to_be_put_in_order_is_bounded(self, tmp_path, monkeypatch):
        """A bag has no index, and all its messages are within one second. The reader must return them in order, but may
        not hold all of them at once.
        """
        monkeypatch.setattr(reading, "HELD", 100_000)
        path = make.unclosed(tmp_path / "run.bag.active",
                             [("/text", String("x" * 1000), 1.0 + 1e-6 * number) for number in range(1000)],
                             chunk=1 << 30)
        longest = 0
        add = reading._Queue.add

        def watched(queue, *entry):
            nonlocal longest
            add(queue, *entry)
            longest = max(longest, len(queue._waiting))

        monkeypatch.setattr(reading._Queue, "add", watched)
        times = [message.time for message in read_bag(path)]
        assert len(times) == 1000 and times == sorted(times) and longest < 110

    @pytest.mark.parametrize("closed", [True, False])
    def test_time_that_stands(self, tmp_path, monkeypatch, closed):
        """Simulated time stands still, so all messages have the same time. The reader keeps the order of the file, but
        may not hold all messages at once.
        """
        monkeypatch.setattr(reading, "HELD", 100_000)
        messages = [("/text", String("%04d" % number * 250), 5.0) for number in range(1000)]
        write = make.write_bag if closed else make.unclosed
        path = write(tmp_path / "run.bag", messages)
        order = [message.data for message in read_bag(path)]
        assert len(order) == 1000 and order == sorted(order)

    def test_headers_are_no_bags(self, tmp_path):
        """A message that contains the header of a bag is an ordinary message."""
        inner = small(tmp_path / "inner.bag").decode("latin-1")
        path = make.write_bag(tmp_path / "run.bag", [("/text", String(inner), 1.0), ("/header", Header(), 2.0)])
        assert [message.topic for message in read_bag(path)] == ["/text", "/header"]
