"""Whole conversations of a simulated laser with the clients of the laser sheet (1.9), step by step with the bytes."""

import pytest

from laser_on_bench import LaserBench, wire
from pioneer_control import lms2xx
from pioneer_control.lms2xx import Mode
from pioneer_control.simulator.lms200 import FirmwareNumbers

A0 = "06 02 80 03 00 A0 00 10 16 0A"
POWER_ON = "02 80 17 00 90 4C 4D 53 32 30 30 3B 33 30 31 30 36 33 3B 56 30 32 2E 31 30 20 10 63 5E"
TYPE = "06 02 80 17 00 BA 4C 4D 53 32 30 30 3B 33 30 31 30 36 33 3B 56 30 32 2E 31 30 20 10 22 61"
F4 = ("06 02 80 24 00 F4 00 00 46 00 00 00 01 00 00 02 02 02 00 00 0A 0A 50 64 00 0A 0A 50 64 00 0A 0A 50 64"
      " 00 00 00 00 02 00 10 0A 2F")
B1 = ("06 02 80 9A 00 B1 56 30 32 2E 31 30 20 25 00x58 94 00x39 B4 00 32 00 02 00 00 00 00 %s 02 00 00 00 01 01"
      " 56 30 32 2E 31 30 20 00x22 10")
SPEED_9600, SPEED_38400 = "02 00 02 00 20 42 52 08", "02 00 02 00 20 40 50 08"
STREAM, STOP = "02 00 02 00 20 24 34 08", "02 00 02 00 20 25 35 08"
ASK_TYPE, ASK_STATUS, ASK_ERRORS = "02 00 01 00 3A 1E 12", "02 00 01 00 31 15 12", "02 00 01 00 32 16 12"
ASK_CONFIGURATION, INSTALL = "02 00 01 00 74 50 12", "02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5"


class Client:
    """A client's end of the line at some speed; None over TCP."""

    def __init__(self, baud, **options):
        self.bench = LaserBench(**options)
        self.laser, self.baud = self.bench.laser, baud
        self.wait(0.0)

    def wait(self, seconds):
        """Return the bytes that come at the client's speed. Other bytes are noise to it."""
        self.laser.run_to(self.laser.clock.now_us + round(seconds * 1e6))
        return b"".join(sent.data for sent in self.laser.take_sent_with_speeds() if self.baud in (None, sent.baud))

    def say(self, text, seconds):
        """Send bytes, and return what comes."""
        self.laser.receive(wire(text), self.baud)
        return self.wait(seconds)


def scans(data):
    """Return the scans in bytes that begin with a telegram. What is not complete at their end counts not."""
    decoder = lms2xx.TelegramDecoder(from_laser=True)
    found = decoder.feed(data)
    assert decoder.counts.discarded_bytes == 0
    return [lms2xx.decode(each).scan for each in found]


def stop(client, seconds=0.5):
    """Say stop as clients do, up to three times. Return whether A0 came at the end."""
    return any(client.say(STOP, seconds).endswith(wire(A0)) for _ in range(3))


# -- ARIA

def test_aria_over_tcp():
    client = Client(None, line_takes_time=False, numbers=FirmwareNumbers(boot=30.0))
    client.wait(31.0)
    assert client.say("02 00 01 00 10 34 12", 1.0) == wire("06 02 80 02 00 91 10 79 30")
    assert client.wait(65.0) == wire(POWER_ON)
    assert client.say("02 00 05 00 3B B4 00 00 00 5F 2D", 0.2) == wire("06 02 80 07 00 BB 01 B4 00 32 00 10 03 9D")
    assert client.say(INSTALL, 0.2) == wire(A0)
    written = client.say("02 00 21 00 77 00 00 46 00 00 05 01 00 00 02 02 00x21 5B 51", 0.2)
    assert written[:16] == wire("06 02 80 25 00 F7 01 00 00 46 00 00 05 01 00 00")
    stream = client.say(STREAM, 1.0)
    assert stream[:10] == wire(A0)
    found = scans(stream[10:])
    assert len(found) >= 34 and {len(each.values) for each in found} == {361}
    assert found[0].values[180] == 4000, "4 m ahead, no reflector"
    assert client.say(STOP, 1.0) == wire(A0)
    assert client.say(SPEED_9600, 1.0) == wire(A0)
    assert client.wait(2.0) == b""


def test_aria_sees_farther_than_8_m_in_its_mode():
    far = LaserBench().laser.device
    assert far.eeprom.configuration.measuring_mode == 0
    bench = LaserBench()
    bench.install().ask(wire("02 00 21 00 77 00 00 46 00 00 05 01 00 00 02 02 00x21 5B 51"))
    bench.mode(Mode.ON_REQUEST)
    assert bench.laser.device.eeprom.configuration.measuring_mode == 5
    assert bench.scan().unit == 1


def test_aria_on_a_serial_port_changes_the_speed_first():
    client = Client(9600)
    client.laser.receive(wire(SPEED_38400), 9600)
    client.wait(0.02)
    client.baud = 38400     # ARIA does not read the answer, and it comes at the old speed
    client.wait(0.3)
    assert client.say("02 00 05 00 3B B4 00 64 00 97 49", 0.2) == wire("06 02 80 07 00 BB 01 B4 00 64 00 10 5B 30")
    assert client.say(INSTALL, 0.2) == wire(A0)
    assert client.say("02 00 21 00 77 00 00 46 00 00 05 01 00 00 02 02 00x21 5B 51", 0.2)[5:7] == wire("F7 01")
    stream = client.say(STREAM, 1.0)
    assert stream[:10] == wire(A0) and 8 <= len(scans(stream[10:])) <= 10
    assert stop(client)
    assert client.say(SPEED_9600, 0.5) == wire(A0)
    client.baud = 9600
    assert client.say(STOP, 0.5) == wire(A0)


# -- sicktoolbox

def test_sicktoolbox_at_a_laser_that_was_just_switched_on():
    client = Client(9600)
    assert client.say(SPEED_38400, 0.25) == wire(A0)
    client.baud = 38400
    assert client.say(STOP, 0.25) == wire(A0)
    assert client.say(ASK_TYPE, 0.25) == wire(TYPE)
    status = client.say(ASK_STATUS, 0.25)
    assert status[:-2] == wire(B1 % "19 80")
    assert client.say(ASK_CONFIGURATION, 0.25) == wire(F4)
    assert client.say("02 00 05 00 3B B4 00 32 00 3B 1F", 0.25) == wire("06 02 80 07 00 BB 01 B4 00 32 00 10 03 9D")
    stream = client.say("02 00 02 00 20 2A 3A 08", 2.0)
    assert stream[:10] == wire(A0)
    found = scans(stream[10:])
    assert {(each.partial, each.quarter, len(each.values)) for each in found} <= {(True, 0, 181), (True, 2, 180)}
    assert len(found) >= 15
    assert stop(client)
    assert client.say(SPEED_9600, 0.5) == wire(A0)
    client.baud = 9600
    assert client.say(STOP, 0.5) == wire(A0)


def test_sicktoolbox_finds_a_laser_that_was_left_at_another_speed():
    client = Client(9600)
    assert client.say(SPEED_38400, 0.5) == wire(A0)
    client.laser.receive(wire(STOP), 38400)
    client.wait(1.0)
    assert client.say(SPEED_38400, 2.0) == b"", "9600 is not its speed any more"
    for baud in (19200, 38400):
        client.baud = baud
        answer = client.say(ASK_ERRORS, 1.0)
        assert answer == (wire("06 02 80 02 00 B2 10 3F 13") if baud == 38400 else b"")


# -- Player

def test_player_hunts_for_the_speed_and_streams():
    client = Client(9600, numbers=FirmwareNumbers(boot=32.0))
    assert client.say(STOP, 1.0) == b"", "power has just come"
    client.wait(35.0)
    assert client.say(STOP, 1.0) == wire(A0)
    client.wait(1.0)
    assert client.say(SPEED_38400, 1.0) == wire(A0)
    client.baud = 38400
    assert client.say(ASK_TYPE, 1.0) == wire(TYPE)
    assert client.say(INSTALL, 3.0) == wire(A0)
    assert client.say(ASK_STATUS, 1.0)[:14] == wire("06 02 80 9A 00 B1 56 30 32 2E 31 30 20 00"), "installation mode"
    assert client.say("02 00 05 00 3B B4 00 32 00 3B 1F", 1.0) == wire("06 02 80 07 00 BB 01 B4 00 32 00 10 03 9D")
    assert client.say(ASK_CONFIGURATION, 1.0) == wire(F4)
    assert client.say("02 00 08 00 77 00 00 46 00 00 01 01 A2 4E", 8.0)[:14] == wire(
        "06 02 80 25 00 F7 01 00 00 46 00 00 01 01")
    assert client.laser.device.eeprom.writes == 1
    stream = client.say("02 00 06 00 20 27 1B 00 2B 01 FF FE", 2.0)
    assert stream[:10] == wire(A0)
    found = lms2xx.TelegramDecoder(from_laser=True).feed(stream[10:])
    parts = [lms2xx.decode(each) for each in found]
    assert len(parts) >= 8
    assert {(each.first, each.last, len(each.scan.values)) for each in parts} == {(27, 299, 273)}


def test_player_finds_the_laser_that_it_left_streaming():
    client = Client(9600)
    client.say(SPEED_38400, 0.5)
    client.baud = 38400
    client.say(STREAM, 3.0)         # and it goes away
    client.baud = 9600
    assert [client.say(STOP, 1.0) for _ in range(3)] == [b""] * 3
    client.baud = 38400
    assert stop(client, 1.0)
    assert client.wait(1.0) == b""


@pytest.mark.parametrize("left_at", sorted(lms2xx.SPEEDS))
def test_the_sheets_advice_finds_every_laser(left_at):
    """Per speed stop up to three times; a stream counts, too."""
    client = Client(9600)
    client.say(wire_of_speed(left_at), 0.5)
    client.baud = left_at
    client.say(STREAM, 1.0)
    for baud in (9600, 38400, 19200, 500000):
        client.baud = baud
        if stop(client, 1.0):
            break
    assert baud == left_at


def wire_of_speed(baud):
    """Return the request for a speed, as text."""
    return lms2xx.encode(lms2xx.SetMode(lms2xx.SPEEDS[baud].mode, b"")).hex(" ")
