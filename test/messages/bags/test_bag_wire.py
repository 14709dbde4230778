"""From a bag to the text form of a line, and the messages about bags in which something is missing."""

import genpy
import genpy.dynamic
import pytest
from bag_factory import driven, message_class, write_bag

from pioneer_control.bags import wire
from pioneer_control.bags.wire import main
from pioneer_control.p2os.recording import entries, explain_record

SYNC0, SYNC1 = bytes.fromhex("FAFB03000000"), bytes.fromhex("FAFB03010001")
BEGIN = 1795285845


def piece(seq, after, to_robot, data):
    """Return a message of the topic `wire`. Its stamp is ``after`` s later than BEGIN."""
    message = message_class("Wire")(to_robot=to_robot, data=data)
    message.header.seq, message.header.stamp = seq, genpy.Time.from_sec(BEGIN + after)
    return message


PIECES = [piece(1, 0.0, True, SYNC0), piece(2, 0.0125, False, SYNC0[:2]), piece(3, 0.013, False, SYNC0[2:] + b"\x55"),
          piece(4, 0.5, True, SYNC1)]


def wire_bag(path, pieces, topic="/pioneer/wire"):
    """Write a bag with these messages of `wire` and those that every bag has. Returns its path."""
    return write_bag(path, sorted([*driven(seconds=1),
                                   *((topic, each, 1000.0 + each.header.stamp.to_sec() - BEGIN) for each in pieces)],
                                  key=lambda message: message[2]))


def text_of(path):
    return path.read_text().splitlines()


def notes(path):
    return [entry.note for entry in entries(text_of(path)) if entry.note]


def test_every_byte_with_its_time_in_its_order(tmp_path, capsys):
    assert main([wire_bag(tmp_path / "run.bag", PIECES)]) == 0
    path = tmp_path / "run.wire"
    assert capsys.readouterr().out == "%s\n" % path
    assert [(round(entry.time, 6), entry.robot, entry.to_robot, entry.data)
            for entry in entries(text_of(path)) if entry.data] == [
        (0.0, 1, True, SYNC0), (0.0125, 1, False, SYNC0[:2]), (0.013, 1, False, SYNC0[2:] + b"\x55"),
                (0.5, 1, True, SYNC1)]
    assert notes(path) == ["begins at 1795285845.000000, 2026-11-21 18:30:45 UTC", "robot 1 is /pioneer/wire"]
    assert len(list(explain_record(entries(text_of(path))))) == 2 + 4


def test_several_robots_have_their_numbers(tmp_path):
    both = [("/one/wire", PIECES[0], 1.0), ("/two/wire", PIECES[0], 1.1), ("/one/wire", PIECES[1], 1.2)]
    assert main([write_bag(tmp_path / "run.bag", both), "-o", str(tmp_path / "both")]) == 0
    assert [entry.robot for entry in entries(text_of(tmp_path / "both")) if entry.data] == [1, 2, 1]
    assert notes(tmp_path / "both")[1:] == ["robot 1 is /one/wire", "robot 2 is /two/wire"]


@pytest.mark.parametrize("pieces, said", [
    (PIECES[:1] + PIECES[3:], ["robot 1: 2 pieces are missing: the recorder was too slow"]),
    (PIECES[:2] + [piece(3, 0.2, False, b"")] + PIECES[3:],
     ["robot 1: pieces are missing: ROS was too slow for the driver"]),
    (PIECES[:2] + [piece(1, 0.2, True, SYNC0)], ["robot 1: its driver begins anew"]),
    (PIECES, []),
])
def test_what_is_missing_is_noted(tmp_path, pieces, said):
    assert main([wire_bag(tmp_path / "run.bag", pieces)]) == 0
    assert notes(tmp_path / "run.wire")[2:] == said


def test_a_bag_without_a_line_says_how_to_record_one(tmp_path, capsys):
    assert main([write_bag(tmp_path / "run.bag", driven(seconds=1))]) == 2
    error = capsys.readouterr().err
    assert "publish_wire:=true" in error and "also:=wire" in error and not (tmp_path / "run.wire").exists()


def test_what_is_no_bag_and_what_must_not_be_overwritten(tmp_path, capsys):
    bag = wire_bag(tmp_path / "run.bag", PIECES)
    before = (tmp_path / "run.bag").read_bytes()
    assert main([str(tmp_path / "nothing.bag")]) == 2 and "no such file" in capsys.readouterr().err
    assert main([bag, "-o", bag]) == 2 and "is the bag itself" in capsys.readouterr().err
    assert main([bag, "-o", str(tmp_path / "no" / "where")]) == 2 and "No such file" in capsys.readouterr().err
    assert (tmp_path / "run.bag").read_bytes() == before


def test_a_bag_that_was_cut_off_gives_what_it_has(tmp_path, capsys):
    bag = wire_bag(tmp_path / "run.bag", PIECES)
    whole = (tmp_path / "run.bag").read_bytes()
    (tmp_path / "run.bag").write_bytes(whole[:whole.index(SYNC1)])
    assert main([bag]) == 0
    assert capsys.readouterr().err.startswith("wire: ")
    assert [entry.data for entry in entries(text_of(tmp_path / "run.wire"))
            if entry.data] == [each.data for each in PIECES[:3]]


def test_a_type_of_that_name_with_other_fields_is_no_line(tmp_path, capsys):
    strange = genpy.dynamic.generate_dynamic("pioneer_control/Wire", "int32 foo\n")["pioneer_control/Wire"]()
    assert main([write_bag(tmp_path / "run.bag", [("/pioneer/wire", strange, 1000.0)])]) == 2
    assert "no bytes of a robot's line" in capsys.readouterr().err and not (tmp_path / "run.wire").exists()


def test_a_damaged_message_is_missing_and_the_rest_is_there(tmp_path):
    path = wire_bag(tmp_path / "run.bag", PIECES)
    with open(path, "r+b") as file:
        content = file.read()
        file.seek(content.index(SYNC0) - 9)     # the length of its frame's name
        file.write(b"\xff\xff\xff\x7f")
    assert main([path]) == 0
    assert [entry.data for entry in entries(text_of(tmp_path / "run.wire"))
            if entry.data] == [SYNC0[:2], SYNC0[2:] + b"\x55", SYNC1]


def test_what_cannot_be_written_to_its_end_is_not_half_there(tmp_path, monkeypatch, capsys):
    def fill(entry):
        if entry.data == SYNC1:
            raise OSError(28, "No space left on device")
        return "x"

    monkeypatch.setattr(wire, "written", fill)
    assert main([wire_bag(tmp_path / "run.bag", PIECES)]) == 2
    assert "No space left on device" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["run.bag"]
