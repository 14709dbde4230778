"""What real clients of the camera send and expect, byte for byte as the camera sheet has it (part 1, 5 to 7 and 10)."""

import pytest
from robot_on_bench import Bench

from pioneer_control.errors import ParameterError
from pioneer_control.p2os import SerialAux
from pioneer_control.simulator.line.cameras import CameraPorts, fit_camera

FLUSH, WANT_6, WANT_8, WANT_4 = (bytes.fromhex(text) for text in (
    "FA FB 06 2B 3B 00 00 2B 3B", "FA FB 06 2B 3B 06 00 31 3B", "FA FB 06 2B 3B 08 00 33 3B",
    "FA FB 06 2B 3B 04 00 2F 3B"))
WANT_14, WANT_10 = (bytes.fromhex(text) for text in ("FA FB 06 2B 3B 0E 00 39 3B", "FA FB 06 2B 3B 0A 00 35 3B"))
POWER, HOST, INIT, PAN_SPEED, TILT_SPEED, RANGE, CENTRE, STOP, POSITION, ZOOM, ASK_ZOOM, LEFT, FLOORED, POWER_OFF = (
    bytes.fromhex(text) for text in (
        "FA FB 0C 2A 2B 07 FF 30 30 00 A0 31 EF 94 E9",
        "FA FB 0C 2A 2B 07 FF 30 30 00 90 30 EF 93 D9",
        "FA FB 0C 2A 2B 07 FF 30 30 00 58 30 EF 93 A1",
        "FA FB 0E 2A 2B 09 FF 30 30 00 50 33 32 30 EF C8 CB",
        "FA FB 0E 2A 2B 09 FF 30 30 00 51 32 36 35 EF CC D0",
        "FA FB 14 2A 2B 0F FF 30 30 00 64 31 37 45 46 35 38 33 30 45 EF 8F 92",
        "FA FB 13 2A 2B 0E FF 30 30 00 62 38 30 30 30 38 30 30 30 EF 3A 93",
        "FA FB 0C 2A 2B 07 FF 30 30 00 53 30 EF 93 9C",
        "FA FB 0B 2A 2B 06 FF 30 30 00 63 EF 61 52",
        "FA FB 0F 2A 2B 0A FF 30 30 00 B3 30 33 45 38 EF DB 97",
        "FA FB 0C 2A 2B 07 FF 30 30 00 B4 30 EF 93 FD",
        "FA FB 13 2A 2B 0E FF 30 30 00 62 37 45 37 30 38 30 42 32 EF 52 7C",
        "FA FB 13 2A 2B 0E FF 30 30 00 62 37 43 39 38 38 30 42 31 EF 54 77",
        "FA FB 0C 2A 2B 07 FF 30 30 00 A0 30 EF 93 E9"))
OK, BUSY, MODE = (bytes.fromhex(text) for text in ("FE3030 3030EF", "FE3030 3130EF", "FE3030 3930EF"))


class AuxBench(Bench):
    """A robot with a camera at AUX1, and the client of both. ``camera`` is the camera."""

    def __init__(self, **options):
        super().__init__()
        fit_camera(self.robot, CameraPorts("vcc4", **options))
        self.camera = self.robot.hardware.aux[0].joined
        self.open(motors=False)
        self.packets.clear()

    def say(self, *packets, wait=0.0):
        for packet in packets:
            self.robot.receive(packet)
        self.wait(wait, alive=True)

    def heard(self):
        """Return the bytes of each SERAUX since the last call."""
        found = [packet.data for packet in self.packets if isinstance(packet, SerialAux)]
        self.packets.clear()
        return found

    def asked(self, command, *wants, limit=1.0):
        """Request bytes, send a command, and request the rest if the answer is longer: as the vendor's client does.

        Return the whole answer.
        """
        self.say(FLUSH, WANT_6, command)
        answer = self._piece(limit)
        for want in wants if answer[-1] != 0xEF else ():
            self.say(want)
            answer += self._piece(limit)
        return answer

    def _piece(self, limit):
        for _ in range(round(limit / 0.1)):
            self.wait(0.1, alive=True)
            for data in self.heard():
                return data
        raise AssertionError("no answer")


def test_the_vendors_client_starts_the_camera_and_uses_it():
    """It resends a step at once when it hears busy, and stops a camera that turns before a new target."""
    bench = AuxBench()
    assert bench.asked(POWER) == MODE       # then it goes on with the control
    for step in (HOST, POWER, INIT, PAN_SPEED, TILT_SPEED, RANGE, CENTRE):
        times = 1
        while bench.asked(step) == BUSY:
            times += 1
        assert times < 32       # ten a second, while it initialises
    assert bench.asked(LEFT) == OK
    assert bench.asked(LEFT) == BUSY and bench.asked(STOP) == OK and bench.asked(LEFT) == OK
    bench.wait(1.0, alive=True)
    assert bench.asked(POSITION, WANT_8) == bytes.fromhex("FE 30 30 30 30 37 45 37 30 38 30 42 32 EF")
    assert bench.asked(ZOOM) == OK
    bench.wait(2.0, alive=True)
    assert bench.asked(ASK_ZOOM, WANT_4) == bytes.fromhex("FE 30 30 30 30 30 33 45 38 EF")


def test_p2os_sends_one_way_with_a_flush_before_each_command():
    bench = AuxBench(cabling="one_way")
    for step in (POWER, HOST, INIT, RANGE, RANGE, RANGE, CENTRE):
        bench.say(FLUSH, step, wait=0.3)
    bench.wait(2.0, alive=True)
    bench.say(FLUSH, FLOORED, wait=0.3)
    bench.say(FLUSH, ZOOM, wait=2.0)
    assert (bench.camera.pan.position, bench.camera.tilt.position, bench.camera.zoom.position) == (-872, 177, 1000)
    assert bench.heard() == []
    bench.say(FLUSH, CENTRE, wait=0.3)
    bench.say(FLUSH, FLOORED, wait=3.0)     # it never stops the camera: this command is lost
    assert bench.camera.pan.position == 0
    bench.say(FLUSH, POWER_OFF, wait=0.3)
    assert not bench.camera.is_on


def test_old_player_asks_for_whole_answers_and_hangs_on_an_error():
    bench = AuxBench()
    for step in (HOST, POWER, INIT):
        bench.say(FLUSH, step, WANT_6, wait=0.5)
        assert bench.heard() == [OK]
    bench.wait(3.0, alive=True)
    bench.say(FLUSH, LEFT, WANT_6, wait=1.0)
    assert bench.heard() == [OK]
    bench.say(FLUSH, POSITION, WANT_14, wait=0.5)
    assert bench.heard() == [bytes.fromhex("FE 30 30 30 30 37 45 37 30 38 30 42 32 EF")]
    bench.say(FLUSH, ASK_ZOOM, WANT_10, wait=0.5)
    assert bench.heard() == [bytes.fromhex("FE 30 30 30 30 30 30 30 30 EF")]
    bench.camera.switch(False)
    bench.say(FLUSH, POSITION, WANT_14, wait=2.0)
    assert bench.heard() == []      # an error has six bytes, and fourteen were requested
    bench.say(FLUSH, HOST, WANT_6, wait=0.5)
    assert bench.heard() == [OK]


@pytest.mark.parametrize("port, send, want", [(2, 66, 67), (3, 60, 61)])
def test_cameras_at_other_ports_and_none_at_the_first(port, send, want):
    bench = AuxBench(aux=1)
    fit_camera(bench.robot, CameraPorts("vcc50i", aux=port))
    bench.send({66: "TTY3", 60: "TTY4"}[send], bytes.fromhex("FF 30 30 00 90 30 EF"))
    bench.send({67: "GETAUX2", 61: "GETAUX3"}[want], 6)
    bench.wait(0.5)
    assert [packet for packet in bench.packets if isinstance(packet, SerialAux)] == [SerialAux(port, OK)]


@pytest.mark.parametrize("model, port, said", [
    ("p2at8", 3, "clients of a p2at8, whose firmware is AROS, reach the auxiliary ports 1 and 2; or give it a line"),
    ("pion1m", 1, "clients of a pion1m, whose firmware is PSOS, reach no auxiliary port; or give it a line"),
])
def test_a_camera_that_no_client_can_reach_is_refused(model, port, said):
    with pytest.raises(ParameterError, match="a camera at AUX%d .*: %s" % (port, said)):
        fit_camera(Bench(model).robot, CameraPorts("vcc4", aux=port))
    fit_camera(Bench("p2at8").robot, CameraPorts("vcc4", aux=2))


def test_close_ends_neither_the_cameras_motion_nor_its_power():
    bench = AuxBench()
    for step in (HOST, INIT):
        bench.say(step, wait=0.3)
    bench.wait(3.0, alive=True)
    bench.say(LEFT)
    bench.send("CLOSE").wait(1.0)
    assert bench.camera.pan.position == -400 and bench.camera.is_on


def test_the_robot_says_nothing_of_its_camera():
    with_camera, without = AuxBench(), Bench().open(motors=False)
    for bench in (with_camera, without):
        bench.send("CONFIG").wait(1.0)
    assert with_camera.raw == without.raw
