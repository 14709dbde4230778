"""Fuzz of the camera's protocol: a million inputs to its two decoders, and a million to the simulated camera.

    PYTHONPATH=src python3 bench/fuzz_camera.py [--inputs 1000000] [--seed 1]

An input is a random command or answer, often damaged, or noise, in pieces. Nothing may raise, and after each input a
good command must still be found. bench/fuzz_camera.md has what came out. The unit tests do a small share of it.
"""

import argparse
import random
import time
from collections import Counter

from pioneer_control import vcc4
from pioneer_control.simulator.hardware.camera import CAMERA_COMMANDS, CameraNumbers, SimulatedCamera

NAMES = sorted(vcc4.CAMERA_COMMANDS)
STEP_US = 20000
SPECIAL = (0xFF, 0xFE, 0xFA, 0xEF, 0x00, 0x30, 0x38, 0x46)


def any_command(rng):
    row = CAMERA_COMMANDS[rng.choice(NAMES)]
    return vcc4.encode_camera_command(row.name, *(rng.randint(value.low, value.high) for value in row.values))


def any_answer(rng):
    if rng.random() < 0.3:
        return vcc4.encode_error(rng.choice([kind for kind in vcc4.AnswerKind if kind]))
    return vcc4.encode_answer("ASK_POSITION", rng.randint(-1511, 1511), rng.randint(-800, 800))


def any_byte(rng):
    return rng.choice(SPECIAL) if rng.random() < 0.5 else rng.randrange(256)


def damaged(rng, data):
    """Return bytes with none to three changes: a byte changed, lost or added; or noise instead."""
    if rng.random() < 0.1:
        return bytes(any_byte(rng) for _ in range(rng.randrange(40)))
    data = bytearray(data)
    for _ in range(rng.randrange(4)):
        at = rng.randrange(len(data) + 1)
        data[at:at + rng.randrange(2)] = bytes(any_byte(rng) for _ in range(rng.randrange(3)))
    return bytes(data)


def fuzz_decoders(rng, inputs):
    counts = Counter()
    decoders = {begin: vcc4.CameraDecoder(begin) for begin in (vcc4.COMMAND_BEGIN, vcc4.ANSWER_BEGIN)}
    goods = {vcc4.COMMAND_BEGIN: vcc4.encode_camera_command("STOP"), vcc4.ANSWER_BEGIN: vcc4.encode_answer("STOP")}
    for number in range(inputs):
        begin = rng.choice(list(decoders))
        data = damaged(rng, any_command(rng) if begin == vcc4.COMMAND_BEGIN else any_answer(rng))
        for frame in decoders[begin].feed(data):
            counts["frames"] += 1
            order, answer = vcc4.decode_camera_command(frame), vcc4.decode_answer(frame)
            counts["legal commands"] += order is not None and order.is_legal
            counts["answers"] += answer is not None
            for name in NAMES if answer is not None and number % 50 == 0 else ():
                vcc4.answer_values(name, answer)
        if number % 10 == 0:
            assert decoders[begin].feed(goods[begin])[-1] == goods[begin], data
        assert len(decoders[begin].held) < vcc4.LONGEST_FRAME
    return counts


def fuzz_camera(rng, inputs):
    counts, heard = Counter(), []
    camera = SimulatedCamera("vcc50i", numbers=CameraNumbers(starts_ready=True), put=heard.append)
    decoder, now_us = vcc4.CameraDecoder(vcc4.ANSWER_BEGIN), 0
    for number in range(inputs):
        data = damaged(rng, any_command(rng)) if rng.random() < 0.6 else any_command(rng)
        at = rng.randrange(len(data) + 1)
        camera.device(data[:at])
        camera.device(data[at:])
        now_us += rng.choice((0, STEP_US, STEP_US, 50 * STEP_US))
        camera.step(now_us)
        if number % 1000 == 0:
            camera.restart()
            camera.fail(busy=rng.random() < 0.1, cut_us=rng.choice((0, 0, 30000)), noise=rng.choice((b"", b"\x00\xfe")))
        for frame in decoder.feed(b"".join(heard)):
            answer = vcc4.decode_answer(frame)
            counts["answers"] += 1
            counts["accepted"] += answer is not None and answer.kind == vcc4.AnswerKind.ACCEPTED
        heard.clear()
        for axis in (camera.pan, camera.tilt, camera.zoom):
            assert abs(axis.position) <= vcc4.ZOOM_MOST
    return counts


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=1000000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    for fuzz in (fuzz_decoders, fuzz_camera):
        begun = time.monotonic()
        counts = fuzz(random.Random(options.seed), options.inputs)
        print("%s: %d inputs, nothing raised; %s; %.0f s" % (
            fuzz.__name__, options.inputs, ", ".join("%s %d" % pair for pair in sorted(counts.items())),
            time.monotonic() - begun))


if __name__ == "__main__":
    main()
