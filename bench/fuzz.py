#!/usr/bin/python3
"""Searches for inputs that break the decoder or the session, guided by coverage. Needs no ROS and no clock.

    python3 bench/fuzz.py                               # a minute on both
    python3 bench/fuzz.py --seconds 300 --only session

An input is a string of bytes. The search begins with the golden packets of the protocol. It tries changed copies of its
inputs. When a copy makes the code go a new way (two lines run one after the other for the first time), the search keeps
the copy and changes it in turn. The decoder takes an input as bytes from the line. The session takes it as a script:
bytes from the line, what the user does, and how time passes.
Exit status 1 when the search finds something: it prints the bytes, and they belong into a test.
"""

import argparse
import functools
import math
import os
import random
import sys
import time
from typing import Any, Callable, Dict, List, NamedTuple, Set, Tuple

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src")
GOLDEN = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "test", "data", "p2os-golden.yaml")
sys.path.insert(0, SOURCE)

import yaml

from pioneer_control import p2os
from pioneer_control.client import phases
from pioneer_control.client.line import LONGEST_QUEUE, SetBaud
from pioneer_control.client.session import Session
from pioneer_control.client.settings import Settings
from pioneer_control.errors import EncodingError, LinkLostError, PioneerError
from pioneer_control.p2os.explain import explain
from pioneer_control.p2os.framing import HEADER
from pioneer_control.robots import find_model

phases.find_model = functools.lru_cache(None)(find_model)      # so that the file of models is read only once

LONGEST_INPUT = 600         # bytes
LARGEST_CORPUS = 4000       # inputs
LONGEST_FRAME = 258         # bytes that a decoder may hold back
TIMEOUT, REACTION = 0.6, 0.1
TRACED = tuple(os.path.join(os.path.realpath(SOURCE), "pioneer_control", name)
               for name in ("p2os" + os.sep, "client" + os.sep, "wire_fields.py"))


class Wrong(Exception):
    """Something that must hold does not."""


def must(holds: bool, what: str) -> None:
    """Raise Wrong unless it does."""
    if not holds:
        raise Wrong(what)


# What the search tries inputs on

def try_decoder(data: bytes) -> None:
    """Feed bytes from the line to the decoder; the first byte says in what pieces."""
    step = data[0] % 64 + 1 if data else 1
    decoder = p2os.FrameDecoder()
    frames: List[p2os.Frame] = []
    for at in range(1, len(data), step):
        frames += decoder.feed(data[at:at + step])
        must(len(decoder._held) < LONGEST_FRAME, "holds %d bytes" % len(decoder._held))
    must(frames == p2os.FrameDecoder().feed(data[1:]), "pieces say something else than the whole")
    frames += decoder.drop_partial()
    must(not decoder.waiting, "holds bytes of a frame that was given up")
    must(sum(len(frame.data) + 6 for frame in frames) + decoder.counts.discarded_bytes == len(data[1:]),
         "bytes are not accounted for")
    for frame in frames:
        p2os.decode_command(frame)
        for grip_state_first in (True, False):
            packet = p2os.decode_packet(frame, grip_state_first)
            try:
                again = p2os.encode_packet(packet, grip_state_first)
            except EncodingError:       # longer than a packet may be
                continue
            must(p2os.decode_packet(p2os.Frame(again[3], again[4:-2]), grip_state_first) == packet,
                 "another packet after a round trip")
    list(explain(data[1:]))


class Script:
    """A session, and what its user asked for."""

    def __init__(self) -> None:
        self.now = 0.0
        self.session = Session("fuzz", (9600, 38400), Settings(command_timeout=TIMEOUT), self.now)
        self.commanded_at = -math.inf
        self.motors_asked = False

    def tick(self, seconds: float) -> None:
        """Let time pass, and call tick() whenever the session wants it, as the I/O thread does."""
        end = self.now + seconds
        while self.now < end and not self.session.finished:
            self.now = min(end, self.session.wake_at)
            self.session.tick(self.now)
            must(self.session.wake_at > self.now, "a thread would spin")
            self.look()

    def hear(self, data: bytes) -> None:
        """Give the session bytes from the line."""
        self.session.receive(data, self.now)
        self.session.tick(self.now)
        self.look()

    def user(self, act: Callable[[], Any]) -> None:
        """Let the user act on a connected session, which may refuse it."""
        if self.session.connected:
            try:
                act()
            except PioneerError:
                pass
            self.look()

    def drive(self, linear: float, angular: float) -> None:
        """Command a velocity."""
        self.session.connected.drive.set_velocity(linear, angular, self.now)
        self.commanded_at = self.now

    def ask_for_motors(self, on: bool) -> None:
        """Ask for motors on or off."""
        self.motors_asked |= on
        self.session.connected.drive.request_motors(on, self.now, 2.0)

    def look(self) -> None:
        """Check what the session sends, and what it holds."""
        session = self.session
        for action in session.data_to_send():
            if isinstance(action, SetBaud):
                continue
            for frame in p2os.FrameDecoder().feed(action):
                command = p2os.decode_command(frame)
                if command.name in ("VEL", "RVEL", "VEL2") and command.value:
                    must(self.now <= self.commanded_at + TIMEOUT + REACTION,
                         "%s %s, which nobody wants any more" % (command.name, command.value))
                if command.name == "ENABLE" and command.value:
                    must(self.motors_asked, "motors switched on by itself")
        session.events()
        must(len(session._link.decoder._held) < LONGEST_FRAME, "holds %d bytes" % len(session._link.decoder._held))
        must(session.line.waiting <= LONGEST_QUEUE, "%d commands wait" % session.line.waiting)
        if session.finished:
            must(session.wake_at == math.inf, "wants to be woken after its end")
            must(isinstance(session.error, (PioneerError, type(None))), "ended by %r" % (session.error,))


def sip(**changes: Any) -> bytes:
    """A SIP of a p3dx-sh that stands still."""
    fields = dict(
        type_id=p2os.STOPPED, x_counts=0, y_counts=0, heading_units=0, left_velocity_units=0, right_velocity_units=0,
        battery_dv=128, left_stall_bits=p2os.StallBits(0), right_stall_bits=p2os.StallBits(0),
        control_units=0, flags=p2os.Flags(0), compass=0, sonar=())
    return p2os.encode_packet(p2os.Sip(**{**fields, **changes}))


MOTORS_ON_SIP = sip(flags=p2os.Flags.MOTORS_ENABLED)
HANDSHAKE = [p2os.encode_frame(0), p2os.encode_frame(1),
             p2os.encode_packet(p2os.SyncReply("fuzz", "Pioneer", "p3dx-sh")), sip()]


def to_ready(script: Script) -> None:
    """Bring the session to a connected robot in the fewest steps."""
    script.tick(0.31)
    for answer in HANDSHAKE:
        script.hear(answer)
        script.tick(0.11)
    while not script.session.connected:
        script.hear(HANDSHAKE[-1])
        script.tick(0.1)


def try_session(data: bytes) -> None:
    """Run a script: each step is a byte that names the step, and bytes with its details."""
    script = Script()
    at = 1
    if data and data[0] & 1:
        to_ready(script)
    while at < len(data) and not script.session.finished:
        step, more = data[at] % 16, data[at + 1] if at + 1 < len(data) else 0
        at += 2
        if step < 6:        # bytes
            script.hear(data[at:at + more])
            at += more
        elif step == 6:
            script.hear(PIECES[more % len(PIECES)])
        elif step == 7:
            script.tick(more / 100)
        elif step == 8:
            script.tick(more / 1000)
        elif step == 9:
            script.now += more / 50     # time passes without a call
        elif step == 10:
            script.user(lambda: script.drive((more - 128) / 64, 0.0))
        elif step == 11:
            script.user(lambda: script.drive(0.1, (more - 128) / 32))
        elif step == 12:
            script.user(lambda: script.ask_for_motors(bool(more & 1)))
        elif step == 13:
            packet = p2os.encode_command("TTY2", b"x" * (more % 196))
            script.user(lambda: script.session.connected.command(script.now, packet))
        elif step == 14:
            script.user(lambda: script.session.connected.drive.stop(script.now))
        elif more > 200:
            script.session.fail(LinkLostError("pulled"))
            script.look()
        elif more > 150:
            script.session.close(script.now)
            script.look()
    script.tick(1.0)
    if script.session.finished:
        script.session.receive(MOTORS_ON_SIP, script.now)
        script.session.tick(script.now + 3.0)
        must(not script.session.data_to_send(), "says something after its end")


PIECES = ([bytes.fromhex(example["bytes"]) for example in yaml.safe_load(open(GOLDEN))["examples"]] +
          HANDSHAKE + [MOTORS_ON_SIP])
TARGETS: Dict[str, Callable[[bytes], None]] = {"decoder": try_decoder, "session": try_session}


# What code an input reaches

class Arcs:
    """Which line of the traced rooms ran after which."""

    def __init__(self) -> None:
        self.seen: Set[Tuple[Any, int, int]] = set()
        self._new: Set[Tuple[Any, int, int]] = set()
        self._traced: Dict[Any, bool] = {}

    def run(self, target: Callable[[bytes], None], data: bytes) -> int:
        """Run the target on an input. Returns how many arcs were new; errors of the target pass through."""
        self._new, before = set(), sys.gettrace()
        sys.settrace(self._enter)
        try:
            target(data)
        finally:
            sys.settrace(before)
            self._new -= self.seen
            self.seen |= self._new
        return len(self._new)

    def _enter(self, frame: Any, event: str, argument: Any) -> Any:
        code = frame.f_code
        traced = self._traced.get(code)
        if traced is None:
            traced = self._traced[code] = os.path.realpath(code.co_filename).startswith(TRACED)
        if not traced:
            return None
        before, add = frame.f_lineno, self._new.add

        def follow(frame: Any, event: str, argument: Any) -> Any:
            nonlocal before
            if event == "line":
                add((code, before, frame.f_lineno))
                before = frame.f_lineno
            return follow

        return follow


# How inputs are changed

INTERESTING = (0x00, 0x01, 0x02, 0x03, 0x1B, 0x20, 0x2B, 0x32, 0x33, 0x3B, 0x7F, 0x80, 0xF8, 0xFA, 0xFB, 0xFE, 0xFF)


def repaired(data: bytes) -> bytes:
    """Correct the checksum of everything that looks like a frame. Otherwise the decoder refuses nearly all of it."""
    made, at = bytearray(data), data.find(HEADER)
    while 0 <= at < len(made) - 2:
        end = at + 3 + made[at + 2]
        if made[at + 2] >= 3 and end <= len(made):
            made[end - 2:end] = p2os.checksum(bytes(made[at + 3:end - 2])).to_bytes(2, "big")
        else:
            end = at + 2
        at = made.find(HEADER, end)
    return bytes(made)


def changed(data: bytes, corpus: List[bytes], chance: random.Random) -> bytes:
    """A copy of an input with a few random changes."""
    for _ in range(1 << chance.randrange(4)):
        at, kind = chance.randrange(len(data) + 1), chance.randrange(9)
        size = 1 << chance.randrange(6)
        if kind == 0 and at < len(data):
            data = data[:at] + bytes([data[at] ^ 1 << chance.randrange(8)]) + data[at + 1:]
        elif kind == 1:
            data = data[:at] + bytes([chance.choice(INTERESTING)]) + data[at + 1:]
        elif kind == 2:
            data = data[:at] + bytes(chance.randrange(256) for _ in range(min(size, 8))) + data[at:]
        elif kind == 3:
            data = data[:at] + data[at + size:]
        elif kind == 4:
            data = data[:at] + data[at:at + size] + data[at:]
        elif kind == 5:
            other = chance.choice(corpus)
            data = data[:at] + other[chance.randrange(len(other) + 1):]
        elif kind == 6:
            data = data[:at] + chance.choice(PIECES) + data[at:]
        elif kind == 7:
            data = data[:at] + bytes([6 + chance.randrange(10), chance.randrange(256)]) + data[at:]
        else:
            data = repaired(data)
    return data[:LONGEST_INPUT]


class Finding(NamedTuple):
    """An input that broke something, and what it broke."""

    what: str
    data: bytes


def what_breaks(target: Callable[[bytes], None], data: bytes) -> str:
    """The error that an input causes, and where; empty if it causes none."""
    try:
        target(data)
    except Exception as error:      # any error is a finding
        trace = error.__traceback__
        while trace.tb_next is not None:
            trace = trace.tb_next
        code = trace.tb_frame.f_code
        file_name = os.path.basename(code.co_filename)
        return "%s in %s, line %d: %s" % (type(error).__name__, file_name, trace.tb_lineno, error)
    return ""


def shortened(target: Callable[[bytes], None], finding: Finding) -> Finding:
    """Shorten the input of a finding as far as it still causes the same error."""
    place = finding.what.partition(":")[0]
    data, size = finding.data, len(finding.data) // 2
    while size:
        at = 0
        while at < len(data):
            less = data[:at] + data[at + size:]
            if what_breaks(target, less).startswith(place):
                data = less
            else:
                at += size
        size //= 2
    return Finding(what_breaks(target, data), data)


def search(name: str, seconds: float, seed: int, say: Callable[[str], None] = print) -> List[Finding]:
    """Search for so many seconds. Returns one finding for each place of an error."""
    target, chance, arcs = TARGETS[name], random.Random(seed), Arcs()
    corpus = [b"\x00" + piece for piece in PIECES]
    corpus += [b"\x01\x06" + bytes([number]) + b"\x07\x0a" for number in range(len(PIECES))]
    corpus += [b"\x01\x0c\x01\x06" + bytes([len(PIECES) - 1]) + b"\x0a\xa0\x07\x50", b"\x00"]
    findings: Dict[str, Finding] = {}
    start = told = time.monotonic()
    tried, now, seeds = 0, start, len(corpus)
    while tried < seeds or now - start < seconds:
        if tried < seeds:
            data = corpus[tried]
        else:
            data = changed(chance.choice(corpus[-200:] if chance.random() < 0.5 else corpus), corpus, chance)
        tried += 1
        try:
            if arcs.run(target, data) and len(corpus) < LARGEST_CORPUS:
                corpus.append(data)
        except Exception:           # any error is a finding
            what = what_breaks(target, data)
            if what.partition(":")[0] not in findings:
                finding = shortened(target, Finding(what, data))
                findings[what.partition(":")[0]] = finding
                say("%s: FOUND %s\n    bytes.fromhex(%r)" % (name, finding.what, finding.data.hex()))
        now = time.monotonic()
        if now - told >= 10.0:
            told = now
            figures = name, now - start, tried, tried / (now - start), len(arcs.seen), len(corpus)
            say("%s: %4.0f s, %8d inputs, %5.0f per s, %5d arcs, %4d kept" % figures)
    say("%s: %d inputs in %.0f s (%.0f per s), %d arcs, %d kept, %d findings" % (
        name, tried, now - start, tried / max(now - start, 1e-9), len(arcs.seen), len(corpus), len(findings)))
    return list(findings.values())


def main() -> int:
    """Search as the command line asks."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0,
                        help="of searching, shared by the targets (default: %(default)s)")
    parser.add_argument("--only", choices=sorted(TARGETS), help="search in this one only")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    names = [options.only] if options.only else sorted(TARGETS)
    findings = [finding for name in names for finding in search(name, options.seconds / len(names), options.seed)]
    return int(bool(findings))


if __name__ == "__main__":
    sys.exit(main())
