"""A session in lockstep: its marks, its time, and its end."""

from pioneer_control import p2os
from pioneer_control.client import PacketReceived, RobotState
from pioneer_control.client.session import Session
from pioneer_control.client.settings import Settings
from pioneer_control.p2os import encode_command

from fake_robot import OPEN, SIP_CYCLE, FakeRobot

OPENING = ["OPEN", "STOP", "VEL", "RVEL", "ENABLE", "SONAR", "CONFIG"]
LONGEST_HANDSHAKE = 3.0     # s


class PatientRobot(FakeRobot):
    """Sends a SIP only after a mark."""

    simulated = 0.0

    def open(self, now: float = 0.0) -> None:
        super().open(now)
        self._next_sip += SIP_CYCLE

    def go_on(self) -> bytes:
        """Let simulated time pass until the next SIP."""
        self.simulated += SIP_CYCLE
        return self.advance(self.simulated)


class Pair:
    """A session and a robot that waits for its marks. A turn takes 0.3 s of real time, times ``slowness``."""

    def __init__(self, slowness=1.0):
        self.robot, self.now, self.slowness, self.events = PatientRobot(), 1000.0, slowness, []
        self.session = Session("fake", (), Settings(), self.now, lockstep=True)
        self.act()

    @property
    def marked(self):
        """Whether the newest command is a mark. Before a session the same bytes are SYNC0."""
        return self.robot.phase == OPEN and self.robot.names()[-1] == "PULSE"

    def until_marked(self):
        """Wait until the session has sent its first mark."""
        while not self.marked:
            assert self.now < 1000.0 + LONGEST_HANDSHAKE
            self.now += 0.005
            self.hear(self.robot.advance(self.robot.simulated))
        return self

    def until_ready(self):
        self.until_marked().hear(self.robot.go_on())
        assert self.session.connected
        self.robot.heard.clear()
        return self

    def hear(self, data):
        if data:
            self.session.receive(data, self.now)
        self.session.tick(self.now)
        self.act()

    def act(self):
        for data in self.session.data_to_send():
            self.robot.receive(data, self.robot.simulated)
        self.events += self.session.events()

    def turn(self, *velocity):
        """Drive if there is a velocity, end the turn, and return what the robot heard. Then the next SIP comes."""
        self.now += 0.3 * self.slowness
        self.hear(b"")
        if velocity:
            self.session.connected.drive.set_velocity(*velocity, self.session.time(self.now))
        self.session.connected.end_turn()
        self.act()
        heard = self.take()
        self.hear(self.robot.go_on())
        return heard

    def take(self):
        names = self.robot.names()
        self.robot.heard.clear()
        return names

    @property
    def times(self):
        return [event.time for event in self.events if isinstance(event, RobotState)]


def test_opening_ends_with_one_mark_behind_all_its_commands():
    pair = Pair().until_marked()
    assert pair.robot.names()[-8:] == OPENING + ["PULSE"]
    pair.now += 0.25        # the robot is slow: the commands come again, but no second mark
    pair.hear(b"")
    assert pair.robot.names()[-4:] == ["PULSE", "OPEN", "ENABLE", "CONFIG"]


def test_the_time_of_the_session_is_that_of_its_sips():
    pair = Pair().until_ready()
    assert pair.times == [0.0] and pair.session.time(pair.now) == pair.session.time(pair.now + 100.0) == 0.0
    for _ in range(7):
        pair.turn()
    assert pair.times == [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]
    assert pair.session.time(pair.now + 100.0) == 0.7


def test_all_commands_of_a_turn_go_before_its_mark_and_there_is_one_mark():
    pair = Pair().until_ready()
    connected = pair.session.connected
    for speed in (0.1, 0.2, 0.3, 0.4):
        connected.drive.set_velocity(speed, 0.0, pair.session.time(pair.now))
        connected.command(pair.session.time(pair.now), encode_command("SAY", b"a"))
    connected.end_turn()
    connected.end_turn()
    pair.act()
    names = pair.take()
    assert names[-1] == "PULSE" and names.count("PULSE") == 1 and names.count("SAY") == 4
    assert pair.robot.set_point["VEL"] == 400
    assert pair.turn() == [], "the mark of this SIP was sent already"
    assert pair.turn() == ["PULSE"]


def test_the_dead_man_counts_sips_and_not_real_time():
    pair = Pair().until_ready()
    heard = [pair.turn(0.2, 0.0)]       # each turn takes 0.3 s of real time
    while "STOP" not in heard[-1]:
        heard.append(pair.turn())
    assert len(heard) == 1 + 6, "0.6 s are six cycles"


def test_the_same_is_sent_however_slow_the_computer_is():
    def sent(slowness):
        pair = Pair(slowness).until_ready()
        return [pair.turn(0.2, 0.01) if number % 9 < 3 else pair.turn() for number in range(40)]

    assert sent(1.0) == sent(0.01) == sent(40.0)
    assert any("ENCODER" in names for names in sent(1.0)), "the questions are among it"


def test_no_sign_of_life_is_taken_for_a_mark():
    pair = Pair().until_ready()
    for _ in range(40):     # a robot that does not wait
        pair.session.connected.drive.set_velocity(0.2, 0.0, pair.session.time(pair.now))
        pair.now += 5.0
        pair.hear(pair.robot.go_on())
    assert "PULSE" not in pair.take() and pair.session.connected


def test_other_packets_are_taken_with_the_next_sip():
    pair = Pair().until_ready()
    pair.robot.send(p2os.Gyro(()))
    pair.hear(pair.robot.advance(pair.robot.simulated))
    assert not any(isinstance(event, PacketReceived) for event in pair.events)
    pair.turn()
    assert [type(event) for event in pair.events[-2:]] == [PacketReceived, RobotState]


def test_a_restart_of_the_robot_ends_the_connection_at_once():
    pair = Pair().until_ready()
    pair.robot.send(p2os.Reset(0xFF, b""))
    pair.hear(pair.robot.advance(pair.robot.simulated))
    assert "restarted" in str(pair.session.error)


def test_the_connection_ends_in_the_turn_in_which_it_is_closed():
    pair = Pair().until_ready()
    pair.turn(0.2, 0.0)
    pair.take()
    pair.session.close(pair.now)
    pair.act()
    assert pair.session.finished and pair.session.error is None
    assert pair.take() == ["STOP", "VEL", "RVEL", "ENABLE", "CLOSE"]


def test_another_session_sends_no_mark():
    robot = FakeRobot()
    session, now = Session("fake", (), Settings(), 0.0), 0.0
    while session.connected is None:
        assert now < LONGEST_HANDSHAKE
        now += 0.005
        session.receive(robot.advance(now), now)
        session.tick(now)
        for data in session.data_to_send():
            robot.receive(data, now)
    session.connected.end_turn()
    assert session.data_to_send() == [] and session.time(now) == now
    assert "PULSE" not in robot.names()[1:], "the first one is SYNC0"
