#!/usr/bin/python3
"""Sends random bytes and random telegrams to the decoder of SICK lasers and to simulated lasers. Needs no ROS and no
clock.

    python3 bench/fuzz_lasers.py              # a million inputs each
    python3 bench/fuzz_lasers.py --inputs 20000 --seed 7 --only device

The decoder gets streams of noise, whole telegrams, telegrams with a wrong bit and pieces of them, in both directions.
Cut into any pieces, a stream must say the same; every byte must be accounted for; after a pause the next telegram must
be found, whatever came before; and what was decoded must be encoded into the same bytes.
The device gets requests with any parameters, nonsense with a true CRC, noise, bytes at a wrong speed, and a power
switch. Again and again the program checks that it stops a stream, answers, and sends no more bytes than its line
carries.
Exit status 1 when a check fails: the printed seed and number of the input reproduce it.
"""

import argparse
import os
import random
import sys
import time
from typing import Callable, Dict, List, NamedTuple

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src")
sys.path.insert(0, SOURCE)

from pioneer_control import lms2xx
from pioneer_control.lms2xx import Answer, Mode
from pioneer_control.simulator.lms200 import PERFECT, TYPICAL, FirmwareNumbers, LaserFirmware, Optics, standing
from pioneer_control.simulator.world import World

LOOK_EVERY = 500            # inputs between two checks of a device
LONGEST_ANSWER = 1.5        # s: so long a laser may take to answer, with all that still leaves at 9600 baud before it
REQUESTS = [lms2xx.encode(each) for each in (
    lms2xx.AskStatus(), lms2xx.AskErrors(), lms2xx.AskType(), lms2xx.AskScan(1), lms2xx.AskScan(8),
    lms2xx.AskValues(1, 9), lms2xx.AskMean(3), lms2xx.SetVariant(100, 25), lms2xx.SetVariant(180, 100),
    lms2xx.SetVariant(180, 0), lms2xx.KeepSpeed(0), lms2xx.KeepSpeed(1), lms2xx.AskConfiguration(),
    lms2xx.WriteConfiguration(lms2xx.FACTORY), lms2xx.WriteConfiguration(lms2xx.FACTORY.changed(measuring_mode=1)),
    lms2xx.ResetLaser(), lms2xx.SetMode(Mode.INSTALLATION, lms2xx.PASSWORD),
    lms2xx.SetMode(Mode.STREAM_OF_A_PART, b"\x01\0\x09\0"), *(lms2xx.SetMode(mode, b"") for mode in Mode))]
REPLIES = [lms2xx.encode(each) for each in (
    lms2xx.Resetting(), lms2xx.NotPossible(), lms2xx.PowerOn(b"LMS200;301063;V02.10 "), lms2xx.ModeSet(0),
    lms2xx.ErrorsReply(b"\x02\x12"), lms2xx.VariantSet(1, 180, 50), lms2xx.SpeedKept(1, 1),
    lms2xx.ConfigurationReply(lms2xx.FACTORY), lms2xx.ScanReply(lms2xx.RawScan((1000, 8191, 8190, 2500))),
    lms2xx.ScanReply(lms2xx.RawScan(tuple(range(1000, 1361)), indices=lms2xx.Indices(42, 7))))] + [b"\x06", b"\x15"]


class Wrong(Exception):
    """Something that must always hold does not hold."""


def must(holds: bool, what: str) -> None:
    """Raise Wrong unless the condition holds."""
    if not holds:
        raise Wrong(what)


class Tally(NamedTuple):
    """What a run did."""

    inputs: int
    seconds: float
    sent_bytes: int
    telegrams: int
    simulated: float


def noise(draw: random.Random, most: int) -> bytes:
    """Return any bytes, among them many that begin telegrams and answers."""
    return bytes(draw.choice((2, 0x80, 0, 6, 0x15, 0x20, draw.randrange(256))) for _ in range(draw.randrange(most)))


def with_true_crc(draw: random.Random, head: bytes, commands: List[int], rest: int) -> bytes:
    """Return a telegram of nonsense whose CRC is right."""
    body = bytes((draw.choice(commands),)) + bytes(draw.randrange(256) for _ in range(draw.randrange(rest)))
    whole = head + len(body).to_bytes(2, "little") + body
    return whole + lms2xx.crc(whole).to_bytes(2, "little")


def spoilt(draw: random.Random, data: bytes) -> bytes:
    """Return bytes with one wrong bit, without their end, or twice."""
    kind, at = draw.randrange(3), draw.randrange(len(data))
    if kind == 0:
        return data[:at] + bytes((data[at] ^ 1 << draw.randrange(8),)) + data[at + 1:]
    return data[:at] if kind == 1 else data + data


# -- the decoder

def any_stream(draw: random.Random, from_laser: bool) -> bytes:
    """Return a stream of a laser, or to one."""
    good, head = (REPLIES, b"\x02\x80") if from_laser else (REQUESTS, b"\x02\0")
    first = 128 if from_laser else 0
    pieces = []
    for _ in range(draw.randrange(4)):
        kind = draw.randrange(4)
        if kind == 0:
            pieces.append(noise(draw, 40))
        elif kind == 1:
            pieces.append(draw.choice(good))
        elif kind == 2:
            pieces.append(spoilt(draw, draw.choice(good)))
        else:
            pieces.append(with_true_crc(draw, head, [first + draw.randrange(128)], 40) if draw.random() < 0.9 else
                          with_true_crc(draw, head, [first + 0x30], 800))
    return b"".join(pieces)


def try_stream(draw: random.Random, stream: bytes, from_laser: bool) -> int:
    """Check a decoder with one stream. Return the number of telegrams in it."""
    whole, pieces = lms2xx.TelegramDecoder(from_laser), lms2xx.TelegramDecoder(from_laser)
    found, parts, at = whole.feed(stream), [], 0
    while at < len(stream):
        step = 1 + draw.randrange(16) if draw.random() < 0.5 else 1 + draw.randrange(400)
        parts += pieces.feed(stream[at:at + step])
        must(pieces.held_bytes < lms2xx.LONGEST, "holds %d bytes" % pieces.held_bytes)
        at += step
    must(found == parts and whole.counts == pieces.counts, "pieces say something else than the whole")
    found += whole.drop_partial()
    must(not whole.waiting, "holds bytes of a telegram that was given up")
    telegrams = [each for each in found if isinstance(each, lms2xx.Telegram)]
    counts = whole.counts
    must(sum(each.length for each in telegrams) + counts.answers + counts.discarded_bytes == len(stream),
         "bytes are not accounted for")
    for telegram in telegrams:
        message = lms2xx.decode(telegram)
        if type(message) in lms2xx.MESSAGES.values():
            again = lms2xx.encode(message, telegram.status or 0, telegram.address)
            [read] = [each for each in lms2xx.TelegramDecoder(from_laser).feed(again)]
            must(lms2xx.decode(read) == message, "another message after a round trip")
    following = draw.choice([each for each in (REPLIES if from_laser else REQUESTS) if len(each) > 1])
    must([each for each in whole.feed(following)] == lms2xx.TelegramDecoder(from_laser).feed(following),
         "the telegram after the pause was not found")
    return len(telegrams)


def throw_at_decoder(number: int, seed: int) -> Tally:
    """Try many streams."""
    draw, begin, sent, telegrams = random.Random(seed), time.monotonic(), 0, 0
    for count in range(number):
        from_laser = bool(draw.randrange(2))
        stream = any_stream(draw, from_laser)
        try:
            telegrams += try_stream(draw, stream, from_laser)
        except Exception as error:      # any error is a finding
            raise Wrong("seed %d, number %d: %s: %s: %s" % (
                seed, count, type(error).__name__, error, stream.hex(" "))) from error
        sent += len(stream)
    return Tally(number, time.monotonic() - begin, sent, telegrams, 0.0)


# -- the simulated laser

def any_request(draw: random.Random) -> bytes:
    """Return something that a client, or noise, may send to a laser."""
    kind = draw.randrange(10)
    if kind < 5:
        return draw.choice(REQUESTS)
    if kind < 7:
        return spoilt(draw, draw.choice(REQUESTS))
    if kind < 9:
        known = [0x20, 0x20, 0x30, 0x36, 0x37, 0x3B, 0x66, 0x77, draw.randrange(128)]
        head = bytes((2, draw.choice((0, 0, 0, 1, draw.randrange(128)))))
        if draw.random() < 0.3:     # a request of the table, with any parameters behind its own
            body = draw.choice(REQUESTS)[4:-2] + noise(draw, 12)
            whole = head + len(body).to_bytes(2, "little") + body
            return whole + lms2xx.crc(whole).to_bytes(2, "little")
        return with_true_crc(draw, head, known, 60)
    return noise(draw, 40)


class Subject:
    """A laser that gets the random input, and what it sends."""

    def __init__(self, seed: int):
        walls = [(-4, -4, 4, -4), (4, -4, 4, 4), (4, 4, -4, 4), (-4, 4, -4, -4)]
        world = World("room", walls=walls, posts=[(1.0, 1.0, 0.1)])
        numbers = FirmwareNumbers(boot=0.02, missed=0.1 if seed % 2 else 0.0)
        self.laser = LaserFirmware(Optics(world, TYPICAL if seed % 4 > 1 else PERFECT, seed), standing((0.0, 0.0, 0.5)),
                                   numbers, seed=seed)
        self.decoder = lms2xx.TelegramDecoder(from_laser=True)
        self.needed_us = self.sent_bytes = 0

    def wait(self, seconds: float) -> List[object]:
        """Let time pass. Returns telegrams and answers of the laser, decoded."""
        found = []
        self.laser.run_to(self.laser.clock.after(seconds))
        for sent in self.laser.take_sent_with_speeds():
            self.needed_us += len(sent.data) * 10000000 / sent.baud
            self.sent_bytes += len(sent.data)
            found += [lms2xx.decode(each) if isinstance(each, lms2xx.Telegram) else each
                      for each in self.decoder.feed(sent.data)]
        must(self.needed_us <= self.laser.clock.now_us + 1100, "sent more than its line carries")
        return found

    def look(self) -> None:
        """Check that the laser stops what it streams, and answers."""
        device = self.laser.device
        if device.operation is None:
            self.laser.power_on()
        self.wait(2.0 + LONGEST_ANSWER)     # it becomes ready, and answers what waits
        for _ in range(30):                 # some lasers miss requests while they stream
            self.laser.receive(lms2xx.encode(lms2xx.SetMode(Mode.ON_REQUEST, b"")))
            if device.operation is not None and lms2xx.ModeSet(0) in self.wait(LONGEST_ANSWER):
                break
        self.wait(LONGEST_ANSWER)
        self.decoder.drop_partial()         # a request stops a telegram at any byte
        discarded = self.decoder.counts.discarded_bytes
        self.laser.receive(lms2xx.encode(lms2xx.AskErrors()))
        must(self.wait(LONGEST_ANSWER) == [Answer.ACK, lms2xx.ErrorsReply(b"")], "no answer")
        must(self.decoder.counts.discarded_bytes == discarded, "said something that is no telegram")
        must(device.baud in lms2xx.SPEEDS and device.operation is not None, "is in no state of a laser")
        configuration = device.eeprom.configuration
        must(configuration.measuring_mode in lms2xx.MEASURING_MODES and configuration.unit in list(lms2xx.Unit),
             "has a configuration with which it cannot measure")


def throw_at_device(number: int, seed: int, look_every: int = LOOK_EVERY) -> Tally:
    """Send many inputs to four lasers in turn, with pauses between them."""
    draw, begin, telegrams = random.Random(seed), time.monotonic(), 0
    subjects = [Subject(4 * seed + which) for which in range(4)]
    for count in range(number):
        subject = subjects[count // look_every % len(subjects)]
        try:
            data = any_request(draw)
            speeds = (None, None, None, subject.laser.baud, subject.laser.baud, draw.choice(sorted(lms2xx.SPEEDS)))
            cut = draw.randrange(len(data) + 1)
            baud = draw.choice(speeds)
            subject.laser.receive(data[:cut], baud)
            if draw.random() < 0.1:
                telegrams += len(subject.wait(draw.choice((0.0, 0.001, 0.01, 0.2))))
            subject.laser.receive(data[cut:], baud)
            if draw.random() < 0.5:
                telegrams += len(subject.wait(draw.choice((0.001, 0.003, 0.01, 0.03))))
            if draw.random() < 0.002:
                subject.laser.power_off()
                subject.wait(draw.choice((0.0, 1.0)))
                subject.laser.power_on()
            if count % look_every == look_every - 1:
                subject.look()
        except Exception as error:      # any error is a finding
            raise Wrong("seed %d, number %d: %s: %s" % (seed, count, type(error).__name__, error)) from error
    return Tally(number, time.monotonic() - begin, sum(subject.sent_bytes for subject in subjects), telegrams,
                 sum(subject.laser.clock.seconds for subject in subjects))


TARGETS: Dict[str, Callable[[int, int], Tally]] = {"decoder": throw_at_decoder, "device": throw_at_device}


def main() -> int:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=1000000, help="inputs for each (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=sorted(TARGETS))
    options = parser.parse_args()
    for name, throw in TARGETS.items():
        if options.only in (None, name):
            try:
                tally = throw(options.inputs, options.seed)
            except Wrong as wrong:
                print("%s: FOUND %s" % (name, wrong))
                return 1
            print("%s: %d inputs in %.0f s (%.0f per s), %.0f s simulated, %d bytes, %d telegrams and answers" % (
                name, tally.inputs, tally.seconds, tally.inputs / tally.seconds, tally.simulated, tally.sent_bytes,
                tally.telegrams), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
