"""Every packet of the camera sheet is encoded and decoded byte by byte, also inside the robot's protocol."""

import pathlib

import pytest
import yaml

from pioneer_control import vcc4
from pioneer_control.errors import EncodingError
from pioneer_control.p2os import FrameDecoder, SerialAux, decode_command, decode_packet, encode_command, encode_packet
from pioneer_control.ptz import AUX_PORTS

FILE = pathlib.Path(__file__).parents[2] / "data" / "vcc4-golden.yaml"
DATA = yaml.safe_load(FILE.read_text())


def each(section):
    return pytest.mark.parametrize("example", DATA[section], ids=lambda example: str(example["says"]))


def only(frames):
    frame, = frames
    return frame


@each("commands")
def test_a_command_both_ways(example):
    data = bytes.fromhex(example["camera"])
    assert vcc4.encode_camera_command(example["command"], *example["values"]) == data
    order = vcc4.decode_camera_command(only(vcc4.CameraDecoder(vcc4.COMMAND_BEGIN).feed(data)))
    assert (order.camera, order.command.name, list(order.values)) == (0, example["command"], example["values"])
    assert order.is_legal


@each("commands")
def test_a_command_inside_the_robots_protocol(example):
    packet, data = bytes.fromhex(example["p2os"]), bytes.fromhex(example["camera"])
    assert encode_command(AUX_PORTS[1].send, data) == packet
    assert decode_command(only(FrameDecoder().feed(packet))).value == data


@each("answers")
def test_an_answer_both_ways(example):
    data, values = bytes.fromhex(example["camera"]), example["values"]
    answer = vcc4.decode_answer(only(vcc4.CameraDecoder(vcc4.ANSWER_BEGIN).feed(data)))
    assert answer.error == example["error"]
    if example["error"]:
        assert vcc4.encode_error(vcc4.AnswerKind(answer.kind)) == data
    else:
        assert vcc4.encode_answer(example["to"], *values) == data
        assert list(vcc4.answer_values(example["to"], answer)) == values


@each("answers")
def test_an_answer_inside_the_robots_protocol(example):
    packets = [bytes.fromhex(packet) for packet in example["p2os"]]
    pieces = [decode_packet(only(FrameDecoder().feed(packet)), True) for packet in packets]
    assert b"".join(piece.data for piece in pieces) == bytes.fromhex(example["camera"])
    assert [encode_packet(SerialAux(1, piece.data), True) for piece in pieces] == packets


@each("ports")
def test_what_is_around_it_on_each_port(example):
    packet, port = bytes.fromhex(example["p2os"]), AUX_PORTS[example["port"]]
    frame = only(FrameDecoder().feed(packet))
    if "heard" in example:
        assert decode_packet(frame, True) == SerialAux(example["port"], bytes.fromhex(example["heard"]))
        assert encode_packet(SerialAux(example["port"], bytes.fromhex(example["heard"])), True) == packet
    elif "send" in example:
        assert encode_command(port.send, bytes.fromhex(example["send"])) == packet
    else:
        name = port.baud if "baud" in example else port.want
        assert encode_command(name, example.get("want", example.get("baud"))) == packet
        assert decode_command(frame).name == name


@pytest.mark.parametrize("degrees, count, field", DATA["angles"])
def test_angles(degrees, count, field):
    assert vcc4.count_of(degrees) == count
    assert vcc4.encode_camera_command("GO_TO", 0, count if abs(count) <= 800 else 0)[9:13].decode() in (field, "8000")
    assert vcc4.encode_camera_command("GO_TO", count, 0)[5:9].decode() == field
    assert vcc4.degrees_of(count) == pytest.approx(degrees, abs=0.06)


def test_the_limits_of_the_mechanics_and_the_ratio():
    for name, digits in (("ASK_PAN_LEAST", b"7C87"), ("ASK_PAN_MOST", b"8379"), ("ASK_TILT_LEAST", b"7EF5"),
                         ("ASK_TILT_MOST", b"8320")):
        value, = vcc4.answer_values(name, vcc4.CameraAnswer(0, digits))
        model = vcc4.CAMERA_MODELS["vcc4"]
        assert value in model.pan_mechanics + model.tilt_mechanics
    assert vcc4.answer_values("ASK_PAN_COUNT", vcc4.CameraAnswer(0, b"2BF2")) == (11250,)


LENGTHS = {     # of the answers, with begin and end: sheet 4
    "POWER": 6, "CONTROL": 6, "INITIALISE": 6, "HOME": 6, "PAN_SPEED": 6, "TILT_SPEED": 6, "ASK_PAN_SPEED": 9,
    "ASK_TILT_SPEED_MOST": 9, "STOP": 6, "RUN_BOTH": 6, "GO_TO": 6, "ASK_POSITION": 14, "TILT_RANGE": 6,
    "ASK_TILT_RANGE": 14, "ASK_PAN_LEAST": 10, "ASK_PAN_COUNT": 10, "ZOOM_TO": 6, "ASK_ZOOM": 10, "ASK_ZOOM_MOST": 10,
    "ASK_ZOOM_SPEED": 7, "ZOOM_RUN": 6, "COARSE_ZOOM": 6, "ASK_COARSE_ZOOM": 8, "FOCUS": 6, "ELECTRONIC_ZOOM": 6,
    "INFRARED_FILTER": 6, "INFRARED_LAMP": 6, "FRONT_LAMP": 6, "ASK_STATUS": 9, "ASK_LONG_STATUS": 11,
    "ASK_PRODUCT": 11, "ASK_VERSION": 11,
}


@pytest.mark.parametrize("name", LENGTHS)
def test_how_long_answers_are(name):
    assert vcc4.SHORTEST_ANSWER + vcc4.CAMERA_COMMANDS[name].answer_width == LENGTHS[name]


@pytest.mark.parametrize("name, values", [
    ("GO_TO", (1512, 0)), ("GO_TO", (0, -801)), ("GO_TO", (0,)), ("GO_TO", (0.5, 0)), ("GO_TO", (True, 0)),
    ("ZOOM_TO", (1961,)), ("ZOOM_TO", (-1,)), ("PAN_SPEED", (7,)), ("TILT_SPEED", (623,)), ("POWER", (2,)),
    ("JUMP", ()), ("STOP", (0,)),
])
def test_what_is_not_legal_is_not_encoded(name, values):
    with pytest.raises(EncodingError):
        vcc4.encode_camera_command(name, *values)
    with pytest.raises(EncodingError):
        vcc4.encode_camera_command("STOP", camera=16)


@pytest.mark.parametrize("text", [
    "FF 30 30 00 62 38 30 30 30 EF",                    # a value is missing
    "FF 30 30 00 62 37 63 39 39 38 30 30 30 EF",        # lower case
    "FF 30 30 00 63 30 EF",                             # a digit too many
    "FF 30 30 00 B4 EF",                                # a digit is missing
    "FF 30 30 00 53 39 EF",                             # no such way
    "FF 30 30 01 62 38 30 30 30 38 30 30 30 EF",        # another high byte
    "FF 30 30 00 99 EF",                                # no such command
])
def test_digits_that_make_no_command_are_none(text):
    assert not vcc4.decode_camera_command(bytes.fromhex(text)).is_legal


def test_a_value_out_of_range_is_read_and_not_legal():
    order = vcc4.decode_camera_command(bytes.fromhex("FF 30 30 00 B3 46 46 46 46 EF"))
    assert order.command.name == "ZOOM_TO" and order.values == (0xFFFF,) and not order.is_legal


def test_letters_of_product_and_version():
    assert vcc4.encode_answer("ASK_PRODUCT", "C50i ") == bytes.fromhex("FE 30 30 30 30 43 35 30 69 20 EF")
    assert vcc4.answer_values("ASK_VERSION", vcc4.CameraAnswer(0, b"V1-01")) == ("V1-01",)
    assert vcc4.answer_values("ASK_VERSION", vcc4.CameraAnswer(0, b"V1\x00\x0101")) is None
    with pytest.raises(EncodingError):
        vcc4.encode_answer("ASK_PRODUCT", "too long")
    with pytest.raises(EncodingError):
        vcc4.encode_answer("ASK_POSITION", 1)
