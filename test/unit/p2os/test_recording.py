"""Records of a line are written and explained."""

import pytest

from pioneer_control import p2os
from pioneer_control.errors import UsageError
from pioneer_control.p2os.__main__ import main
from pioneer_control.p2os.recording import TITLE, Entry, entries, explain_record, read_record, written

VEL = bytes.fromhex("FAFB060B1BC800D31B")
SIP = bytes.fromhex("FAFB2833D204C8FF0002BE00D20080000200020700000203DC05049808210500F00080000020000000260D")


def record(*made):
    """Return the lines of a record."""
    return [TITLE, ""] + [written(entry) for entry in made]


def told(lines, **options):
    return list(explain_record(entries(lines), **options))


def test_what_is_written_is_read():
    made = [Entry(0.5, 1, True, VEL), Entry(1.25, 12, False, SIP), Entry(2.0, 0, False, b"", "fault begins: loss 0.1")]
    assert list(entries(record(*made))) == made
    assert written(made[0]) == "0.500000 1 > FA FB 06 0B 1B C8 00 D3 1B"


def test_each_packet_is_a_line():
    lines = told(record(Entry(0.5, 1, True, VEL), Entry(0.6, 2, False, SIP)))
    assert lines[0] == "    0.500000  robot 1 <- VEL -200"
    assert lines[1].startswith("    0.600000  robot 2 -> Sip: ") and "x_counts 1234" in lines[1]


def test_or_byte_by_byte():
    lines = told(record(Entry(0.5, 1, True, VEL)), long=True)
    assert lines[:2] == ["    0.500000  robot 1 <-", "FA FB 06 0B 1B C8 00 D3 1B"]
    assert "checksum D3 1B is right" in lines[2]


@pytest.mark.parametrize("size", [1, 2, 3, 8])
def test_a_packet_in_pieces_has_the_time_of_its_last(size):
    pieces = [Entry(1.0 + at * 0.001, 1, True, VEL[at:at + size]) for at in range(0, len(VEL), size)]
    other = [Entry(1.0005, 2, True, VEL)]
    lines = told(record(*(pieces[:1] + other + pieces[1:])))
    assert lines == ["    1.000500  robot 2 <- VEL -200", "    %f  robot 1 <- VEL -200" % pieces[-1].time]


def test_what_never_becomes_whole_is_shown_as_it_is():
    made = [
        Entry(1.0, 1, True, VEL[:4]),
        Entry(1.05, 1, False, b"\x01"),
        Entry(1.2, 1, True, VEL),
        Entry(1.3, 1, True, b"\xFA"),
    ]
    lines = told(record(*made))
    assert lines[0].endswith("robot 1 -> 01  (noise: no header FA FB)")
    assert lines[1].startswith("    1.000000  robot 1 <- FA FB 06 0B  (cut off")
    assert lines[2].endswith("VEL -200") and lines[3].endswith("<- FA  (noise: no header FA FB)") and len(lines) == 4


def test_a_wrong_checksum_and_packets_that_make_no_sense():
    made = (Entry(1.0, 1, True, VEL[:-1] + b"\0"), Entry(1.1, 1, False, p2os.encode_frame(0x77)),
            Entry(1.2, 1, True, p2os.encode_frame(200)))
    lines = told(record(*made))
    assert "(wrong checksum: D3 00)" in lines[0] and "what its data mean is not known" in lines[1]
    assert "command 200, which no Pioneer knows" in lines[2]


def test_the_steps_of_a_connection_have_their_names():
    frames = [p2os.encode_frame(number) for number in range(3)]
    ways = [(True, 0), (True, 2), (True, 0), (False, 0), (True, 1), (False, 1), (True, 2), (False, 2), (True, 1),
            (True, 0), (True, 2), (True, 0), (True, 1)]
    made = [Entry(float(at), 1, to_robot, frames[number]) for at, (to_robot, number) in enumerate(ways)]
    made.insert(0, Entry(-1.0, 1, True, VEL))
    made.insert(10, Entry(8.5, 1, False, SIP))
    names = [line.split("<- ")[1] for line in told(record(*made)) if "<-" in line]
    assert names == ["VEL -200", "PULSE", "CLOSE", "SYNC0", "SYNC1", "SYNC2", "OPEN", "PULSE", "CLOSE", "SYNC0", "OPEN"]


@pytest.mark.parametrize("before, name", [
    ([], "SYNC0"), ([Entry(0.0, 1, True, p2os.encode_frame(0))], "SYNC0"), ([Entry(0.0, 2, False, SIP)], "SYNC0"),
    ([Entry(0.0, 1, False, SIP)], "PULSE"), ([Entry(0.0, 1, True, VEL)], "PULSE"),
], ids=["nothing", "a SYNC0 without an answer", "another robot's SIP", "its SIP", "a command to it"])
def test_the_first_packet_of_a_record_is_a_sync_unless_a_session_shows(before, name):
    *_, last = told(record(*before, Entry(1.0, 1, True, p2os.encode_frame(0))))
    assert last.endswith("<- " + name)


@pytest.mark.parametrize("answered", [[], [0], [0, 1]])
def test_a_connection_may_begin_anew_until_it_is_made(answered):
    close, *frames = p2os.encode_frame(2), *(p2os.encode_frame(number) for number in range(3))
    made = [Entry(0.0, 1, True, close)]
    for number in answered:
        made += [Entry(1.0, 1, True, frames[number]), Entry(1.0, 1, False, frames[number])]
    *_, last = told(record(*made, Entry(2.0, 1, True, frames[0])))
    assert last.endswith("<- SYNC0")


def test_a_step_of_a_connection_with_a_wrong_checksum_is_none():
    broken = p2os.encode_frame(1)[:-1] + b"\xFF"
    answered = [Entry(0.0, 1, True, p2os.encode_frame(2)), Entry(1.0, 1, True, p2os.encode_frame(0)),
                Entry(2.0, 1, False, p2os.encode_frame(0))]
    lines = told(record(*answered, Entry(3.0, 1, True, broken), Entry(4.0, 1, True, p2os.encode_frame(1))))
    assert "wrong checksum" in lines[3] and lines[4].endswith("<- SYNC1")


def test_a_record_may_count_from_1970():
    late = Entry(1.8e9, 1, True, VEL)
    assert list(entries(record(late))) == [late]


def test_notes_stand_between():
    assert told(record(Entry(1.5, 0, False, b"", "fault begins: cable"))) == ["    1.500000  fault begins: cable"]


@pytest.mark.parametrize("line", [
    "x 1 > FA", "1.0 1 = FA", "1.0 1 > F G", "1.0 1 >", "1.0 a > FA", "nan 1 > FA", "inf 1 > FA",
    "1e308 1 > FA", "1.0 0 > FA", "1.0 -1 > FA"])
def test_a_line_that_says_nothing_is_named(line):
    with pytest.raises(UsageError, match="line 3 of the record: '%s'" % line.strip()):
        told(record() + [line])


def test_the_command_line(tmp_path, capsys):
    path = tmp_path / "wire.txt"
    path.write_text("\n".join(record(Entry(0.5, 1, True, VEL))))
    assert main(["--record", str(path)]) == 0 and capsys.readouterr().out == "    0.500000  robot 1 <- VEL -200\n"
    assert main(["--record", str(path), "--long"]) == 0 and "mm/s" in capsys.readouterr().out
    path.write_text("what?")
    bag = tmp_path / "run.bag"
    bag.write_bytes(b"#ROSBAG V2.0\nE\x8c\x00")
    for wrong, message in ((path, "line 1 of the record"), (tmp_path / "nothing", "No such file"),
                           (bag, "pioneer_control.bags.wire")):
        with pytest.raises(SystemExit):
            main(["--record", str(wrong)])
        assert message in capsys.readouterr().err
        with pytest.raises(UsageError, match=message):
            read_record(str(wrong))
