"""A record that is played as a robot: when it waits for the client, when it does not, and its messages about a client
that behaves differently.
"""

import pytest

from pioneer_control import p2os
from pioneer_control.errors import UsageError
from pioneer_control.p2os import encode_command, encode_frame, encode_packet
from pioneer_control.p2os.recording import Entry, written
from pioneer_control.simulator.__main__ import main
from pioneer_control.simulator.firmware import FirmwareState
from pioneer_control.simulator.played import PlayedRobot
from pioneer_control.simulator.line import LineSimulation

SYNC = [encode_frame(number) for number in range(3)]
OPEN, CLOSE, PULSE = (encode_command(name) for name in ("OPEN", "CLOSE", "PULSE"))
REPLY = encode_packet(p2os.SyncReply("then", "Pioneer", "p3dx-sh"))


def sip(x):
    """Return a SIP at x units."""
    return encode_packet(p2os.Sip(
        type_id=p2os.STOPPED, x_counts=x, y_counts=0, heading_units=0, left_velocity_units=0, right_velocity_units=0,
        battery_dv=128, left_stall_bits=p2os.StallBits(0), right_stall_bits=p2os.StallBits(0),
        control_units=0, flags=p2os.Flags(0), compass=0, sonar=(),
        grip_state=p2os.GripState(0), analog_port=0, analog=0, digital_in=p2os.DigitalIn(255), digital_out=0))


def session(begin, number, *commands, robot=1):
    """Connect, three SIPs, the commands after the first SIP, CLOSE, and a last SIP that was on its way."""
    pieces = [
        (0.0, True, CLOSE),
        (0.01, True, SYNC[0]),
        (0.02, False, SYNC[0]),
        (0.03, True, SYNC[1]),
        (0.04, False, SYNC[1]),
        (0.05, True, SYNC[2]),
        (0.06, False, REPLY),
        (0.1, True, OPEN),
        (0.2, False, sip(number)),
        *((0.25, True, command) for command in commands),
        (0.3, False, sip(number + 1)),
        (0.4, False, sip(number + 2)),
        (0.45, True, PULSE),
        (0.5, True, CLOSE),
        (0.51, False, sip(number + 3)),
    ]
    return [Entry(begin + time, robot, to_robot, data) for time, to_robot, data in pieces]


TWO = session(5.0, 10) + session(7.0, 20)


class Played:
    """A played robot and its client."""

    def __init__(self, record, robot=1):
        self.said = []
        self.robot = PlayedRobot(record, robot, lambda time, sentence: self.said.append((round(time, 3), sentence)))

    def tell(self, *packets):
        """Send bytes to it, and return what it answers at once."""
        self.robot.receive(b"".join(packets))
        return self.robot.take_sent()

    def connect(self):
        """Connect up to OPEN, each command as late as in the record."""
        assert self.tell(SYNC[0]) == b"" and self.robot.advance(0.1) == SYNC[0]
        assert self.tell(SYNC[1]) == b"" and self.robot.advance(0.1) == SYNC[1]
        assert self.tell(SYNC[2]) == b"" and self.robot.advance(0.1) == REPLY
        return self.tell(OPEN)


def test_it_waits_for_each_step_of_the_connection_and_then_keeps_the_pace_of_the_record():
    played = Played(TWO)
    assert played.robot.advance(60.0) == b""        # nobody connects
    assert played.tell(CLOSE, CLOSE) == b"" and played.robot.session is FirmwareState.WAITING
    played.connect()
    assert played.robot.session is FirmwareState.OPEN
    assert [played.robot.advance(step) for step in (0.099, 0.001, 0.2)] == [b"", sip(10), sip(11) + sip(12)]


def test_a_client_that_is_faster_than_the_record_is_answered_at_once():
    played = Played(TWO)
    assert played.tell(SYNC[0]) == b""
    assert played.tell(SYNC[1]) == SYNC[0]
    assert played.tell(SYNC[2], OPEN) == SYNC[1] + REPLY


def test_what_is_out_of_order_is_not_answered_and_a_sync0_again_begins_again():
    played = Played(TWO)
    assert played.tell(SYNC[1], SYNC[2]) == b"" and played.robot.advance(1.0) == b""
    assert played.tell(SYNC[0]) == b"" and played.robot.advance(0.1) == SYNC[0]
    assert played.tell(SYNC[2]) == b"" and played.robot.advance(1.0) == b""
    assert played.tell(SYNC[1]) == b"" and played.robot.advance(0.1) == SYNC[1]
    assert played.tell(SYNC[1]) == b""
    assert played.robot.session is FirmwareState.WAITING, "it is no OPEN, though it has the same number"
    played = Played(TWO)
    played.connect()
    played.tell(CLOSE)
    assert played.tell(SYNC[0]) == b"" and played.robot.advance(0.1) == SYNC[0]
    played.connect()
    assert played.robot.advance(0.1) == sip(20), "it is this connection that begins again, and no earlier one"


def test_a_client_that_sent_open_twice():
    record = sorted(session(5.0, 10) + [Entry(5.15, 1, True, OPEN)])
    played = Played(record)
    played.connect()
    for packet in (OPEN, PULSE, CLOSE):
        played.tell(packet)
    assert played.said == []


def test_who_takes_an_answer_that_the_client_of_then_did_not_is_connected():
    """The recorded client missed the late answer to SYNC2 (made to a CLOSE, which is the same packet) and began again.
    The new client takes this answer.
    """
    attempt = session(1.0, 0)[1:6] + [Entry(1.3, 1, True, CLOSE), Entry(1.31, 1, False, REPLY)]
    played = Played(attempt + session(5.0, 10))
    assert played.connect() == b"" and played.robot.session is FirmwareState.OPEN
    assert played.robot.advance(0.1) == sip(10)


def test_a_client_that_ends_its_session_early_goes_on_with_the_next_connection():
    played = Played(TWO)
    played.connect()
    assert played.robot.advance(0.1) == sip(10)
    assert played.tell(CLOSE) == b"" and played.robot.closed_sessions == 1
    assert played.robot.advance(5.0) == sip(13)     # it was on its way then, too
    played.connect()
    assert played.robot.advance(0.1) == sip(20) and not played.robot.over
    assert played.tell(CLOSE) == b"" and played.robot.advance(1.0) == sip(23) and played.robot.over
    assert played.tell(*SYNC) == b"" and played.robot.advance(1.0) == b""
    over = [sentence for _, sentence in played.said if "over" in sentence]
    assert over == ["the record is over: the robot says nothing more"]


def test_it_is_not_over_before_the_last_was_said():
    played = Played(session(5.0, 10))
    played.connect()
    played.robot.advance(0.405)
    assert not played.robot.over and played.said == []
    assert played.robot.advance(0.01) == sip(13) and played.robot.over


def test_what_came_after_the_end_comes_as_long_after_it():
    played = Played(TWO)
    played.connect()
    played.tell(CLOSE)
    assert (played.robot.advance(0.009), played.robot.advance(0.002)) == (b"", sip(13))


def test_a_client_that_gives_up_within_the_handshake_goes_on_with_the_next_connection():
    played = Played(TWO)
    assert played.tell(SYNC[0]) == b"" and played.robot.advance(0.1) == SYNC[0]
    played.robot.close_session()
    played.connect()
    assert played.robot.advance(0.1) == sip(20)


def test_a_client_of_then_that_ended_no_session():
    played = Played(session(5.0, 10)[:11] + session(7.0, 20)[1:])
    played.connect()
    assert played.robot.advance(0.3) == sip(10) + sip(11) + sip(12)
    played.tell(CLOSE)
    played.connect()
    assert played.robot.advance(0.1) == sip(20) and played.said == [], "what it said later is no part of that session"


def test_a_client_that_connects_while_the_record_is_elsewhere_skips_what_is_between():
    """It lost the link earlier than the recorded client, and its CLOSE reached nobody."""
    played = Played(TWO)
    played.connect()
    played.robot.close_session()
    played.connect()
    assert played.robot.advance(0.1) == sip(20)


def test_a_robot_that_was_left_open_streams_to_whoever_comes():
    left_open = [Entry(1.0, 1, False, sip(1)), Entry(1.1, 1, False, sip(2)), Entry(1.2, 1, True, CLOSE)]
    played = Played([*left_open, *session(2.0, 10)])
    assert played.robot.session is FirmwareState.OPEN
    assert played.robot.advance(0.05) == sip(1), "its time begins with the record"
    assert played.robot.advance(5.0) == sip(2)      # to nobody
    played.robot.close_session()        # as a server does when a client comes
    assert played.robot.session is FirmwareState.OPEN and played.robot.advance(0.05) == sip(1)
    assert played.tell(CLOSE) == b"" and played.robot.advance(3.0) == b""
    played.connect()


@pytest.mark.parametrize("sent, said", [
    ([PULSE], []),
    ([encode_command("VEL", 200), PULSE], [
        (5.1, "here the client sends VEL 200, and that of the record did not"),
        (5.1, "in this connection the client sent, against that of the record: VEL +1")]),
    ([], [(5.1, "in this connection the client sent, against that of the record: PULSE -1")]),
    ([PULSE, encode_command("ENABLE", 1), PULSE], [
        (5.1, "here the client sends ENABLE 1, and that of the record did not"),
        (5.1, "in this connection the client sent, against that of the record: ENABLE +1, PULSE +1")]),
])
def test_what_the_client_does_otherwise_is_said_once_in_each_connection(sent, said):
    played = Played(TWO)
    played.connect()
    for packet in [*sent, CLOSE]:
        played.tell(packet)
    assert played.said == said
    played.robot.close_session()        # as a server does when the line ends, too
    assert played.said == said


def test_a_line_speed_that_the_client_asks_for():
    played = Played(session(0.0, 10, encode_command("HOSTBAUD", 4)))
    played.connect()
    assert played.robot.baud == 9600 and played.tell(encode_command("HOSTBAUD", 4)) == b""
    assert played.robot.baud == 115200
    for code in (5, 255):               # which there is none
        played.tell(encode_frame(p2os.COMMANDS["HOSTBAUD"].number, bytes([0x3B, code, 0])))
        assert played.robot.baud == 115200
    played.tell(CLOSE)
    assert played.robot.baud == 9600


def test_a_robot_among_several():
    both = sorted(session(0.0, 10) + session(0.01, 20, robot=2))
    played = Played(both, 2)
    played.connect()
    assert played.robot.advance(0.1) == sip(20)
    with pytest.raises(UsageError, match="nothing that a robot 3 said"):
        Played(both, 3)


def test_a_record_in_which_time_jumps_back_is_played_in_its_order():
    record = session(5.0, 10)
    played = Played([*record[:10], record[10]._replace(time=0.0), *record[11:]])
    lines = LineSimulation(played.robot)
    for packet in [*SYNC, OPEN]:
        lines.send(0, packet)
        lines.advance(0.1)
    assert b"".join(arrival.data for arrival in lines.advance(1.0)).endswith(sip(11) + sip(12) + sip(13))
    played = Played([*record[:7], record[7]._replace(time=0.0), *record[8:]])
    played.connect()
    assert played.robot.advance(0.15) == sip(10), "it does not wait for as long as the clock was set back"


@pytest.mark.parametrize("record, message", [
    ([], "nothing that a robot 1 said"), ([Entry(0.0, 0, False, b"", "a note")], "nothing that a robot 1 said"),
    (TWO[8:14], "no connection begins in the record of robot 1"), (TWO[:6], "no connection begins"),
    ([*TWO[1:4], Entry(6.0, 1, False, sip(1))], "no connection begins")])
def test_a_record_to_which_no_client_could_connect(record, message):
    with pytest.raises(UsageError, match=message):
        PlayedRobot(record)


@pytest.mark.parametrize("arguments, text, message", [
    (["--play", "--laser", "line"], "\n".join(map(written, TWO)), "a laser over the robot's line is for simulated"),
    (["--play"], "what?", "line 1 of the record: 'what?' is not"),
    (["--play"], "\n".join(map(written, TWO[8:14])), "no connection begins"),
    (["--play", "--robot", "2"], "\n".join(map(written, TWO)), "nothing that a robot 2 said"),
    (["--play", "--fault", "power from 3"], "\n".join(map(written, TWO)),
     "a played robot only says what the record has"),
    (["--client"], "1.0 2 > FA", "the record has a robot 2: let there be as many simulated ones"),
    (["--client"], "what?", "line 1 of the record"),
    (["--client"], None, "No such file or directory")])
def test_what_makes_no_sense_is_told(tmp_path, capsys, arguments, text, message):
    path = tmp_path / "a.wire"
    if text is not None:
        path.write_text(text)
    assert main([arguments[0], str(path), *arguments[1:], "--tcp", "0"]) == 2
    assert message in capsys.readouterr().err
