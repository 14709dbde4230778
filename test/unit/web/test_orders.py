"""Messages of the page: every legal one becomes its order, and whatever else anybody sends is an error that names it.
"""

import json
import math
import pathlib
import re

import pytest
from hypothesis import given
from hypothesis import strategies as some

from pioneer_control.errors import UsageError
from pioneer_control.web import orders
from pioneer_control.web.orders import ORDERS, first_words, order_of, read_message

PROTOCOL = (pathlib.Path(__file__).resolve().parents[3] / "docs" / "page-protocol.md").read_text(encoding="utf-8")
LEGAL = [
    ('{"do": "drawn", "stamp": 123}', orders.DrawnOrder(123)),
    ('{"do": "drawn", "stamp": 4294967295}', orders.DrawnOrder(2 ** 32 - 1)),
    ('{"do": "ping", "at": 1.5}', orders.PingOrder(1.5)),
    ('{"do": "ping", "at": -3}', orders.PingOrder(-3)),
    ('{"do": "drive", "robot": 7, "forward": 0.5, "turn": -1.0, "stamp": 123}', orders.DriveOrder(7, 0.5, -1.0, 123)),
    ('{"do": "drive", "robot": 0, "forward": 0, "turn": 1, "stamp": 0}', orders.DriveOrder(0, 0, 1, 0)),
    ('{"do": "stop", "robot": 7}', orders.StopOrder(7)),
    ('{"do": "stop", "robot": "all"}', orders.StopOrder("all")),
    ('{"do": "unlock", "robot": 65535}', orders.UnlockOrder(65535)),
    ('{"do": "unlock", "robot": "all"}', orders.UnlockOrder("all")),
    ('{"do": "motors", "robot": 7, "on": true}', orders.MotorsOrder(7, True)),
    ('{"robot": 7, "on": false, "do": "motors"}', orders.MotorsOrder(7, False)),
    *(('{"do": "gripper", "robot": 7, "command": "%s"}' % command, orders.GripperOrder(7, command))
      for command in ("open", "close", "up", "down", "stop", "deploy", "store")),
    ('{"do": "limit", "robot": 7, "linear": 0.3}', orders.LimitOrder(7, 0.3)),
    ('{"do": "take", "robot": 7}', orders.TakeOrder(7)),
    ('{"do": "release", "robot": 7}', orders.ReleaseOrder(7)),
    ('{"do": "go", "robot": 7, "x": 3.0, "y": -1.5, "heading": 0.1}', orders.GoOrder(7, 3.0, -1.5, 0.1)),
    ('{"do": "here", "robot": 7, "x": 3, "y": 1.5, "heading": -3.1}', orders.HereOrder(7, 3, 1.5, -3.1)),
    ('{"do": "cancel", "robot": 7}', orders.CancelOrder(7)),
    ('{"do": "save_place", "robot": 7, "name": "my kitchen"}', orders.SavePlaceOrder(7, "my kitchen")),
    ('{"do": "forget_place", "robot": 7, "name": "K"}', orders.ForgetPlaceOrder(7, "K")),
    ('{"do": "name", "name": "Ada"}', orders.NameOrder("Ada")),
    ('{"do": "name", "name": "\\u00c5sa \\u674e"}', orders.NameOrder("Åsa 李")),
    ('{"do": "say", "text": "come here"}', orders.SayOrder("come here")),
    ('{"do": "join", "name": "Ada"}', orders.JoinOrder("Ada")),
    ('{"do": "free", "robot": 7}', orders.FreeOrder(7)),
    ('{"do": "pause", "on": true}', orders.PauseOrder(True)),
    ('{"do": "speed", "speed": 0.5}', orders.SpeedOrder(0.5)),
    ('{"do": "reset", "robot": 7}', orders.ResetOrder(7)),
    ('{"do": "reset", "robot": "all"}', orders.ResetOrder("all")),
    ('{"do": "fault", "robot": 7, "words": "loss 0.2"}', orders.FaultOrder(7, "loss 0.2")),
    ('{"do": "clear_faults"}', orders.ClearFaultsOrder()),
    ('{"do": "task", "name": "square"}', orders.TaskOrder("square")),
    ('{"do": "task", "name": ""}', orders.TaskOrder("")),
    ('{"do": "begin_task"}', orders.BeginTaskOrder()),
    ('{"do": "end_task"}', orders.EndTaskOrder()),
]
ON_MAP = [*((name, value) for name in ("x", "y") for value in (10000.1, -1e308, 10 ** 400, "1", True, None, [1])),
          *(("heading", value) for value in (7.1, -7.1, "0", None, False)), ("robot", "all"), ("robot", -1)]
WRONG_FIELDS = {
    "go": ON_MAP,
    "here": ON_MAP,
    "cancel": [("robot", "all"), ("robot", -1)],
    "save_place": [("name", value) for value in ("", " ", "x" * 41, "a\nb", 1, None, "\u202e")] + [("robot", "all")],
    "forget_place": [("name", value) for value in ("", "x" * 41, 1, None)] + [("robot", "all")],
    "drawn": [("stamp", value) for value in (-1, 2 ** 32, 1.0, True, "1", None, [], {})],
    "ping": [("at", value) for value in (1e16, "1", None, True)],
    "drive": [
        *((name, value) for name in ("forward", "turn")
          for value in (1.0001, -2, 1e308, 10 ** 400, "1", True, None, [1])),
        *(("robot", value) for value in (-1, 65536, 1.0, True, "all", "1", None, [7])), ("stamp", -1), ("stamp", 0.5)],
    "stop": [("robot", value) for value in (-1, "ALL", "7", True, None, 7.0, ["all"])],
    "unlock": [("robot", value) for value in (-1, "every", False)],
    "motors": [("on", value) for value in (1, 0, "true", None)] + [("robot", -1)],
    "gripper": [("command", value) for value in ("OPEN", "", "explode", 1, None, ["open"])] + [("robot", "all")],
    "limit": [("linear", value) for value in (0, -0.1, 101, True, "0.2", None)],
    "take": [("robot", "all"), ("robot", -1)],
    "release": [("robot", "all"), ("robot", -1)],
    "name": [("name", value) for value in (
        "", " ", "x" * 25, "a\nb", "a\u202eb", "\u3164 \ufe0f", 1, None, ["Ada"], "\0")],
    "say": [("text", value) for value in ("", "x" * 501, "a\tb", 1)],
    "join": [("name", value) for value in ("", " ", "x" * 25, "a\nb", 1, None, "\u202e")],
    "free": [("robot", value) for value in ("all", -1, True)],
    "pause": [("on", value) for value in (1, "true", None)],
    "speed": [("speed", value) for value in (0, 0.19, 4.1, 1e308, "1", True)],
    "reset": [("robot", value) for value in (-1, "ALL", None)],
    "fault": [("words", value) for value in ("", "x" * 101, "a\nb", 1)] + [("robot", -1), ("robot", "every")],
    "clear_faults": [],
    "task": [("name", value) for value in ("x" * 25, "a\nb", 1, None, ["square"], "\u202e", True)],
    "begin_task": [],
    "end_task": [],
}


@pytest.mark.parametrize("text, order", LEGAL)
def test_legal_messages(text, order):
    made = order_of(read_message(text))
    assert made == order and type(made) is type(order)


def example(name):
    """Return a legal message of this kind, as a dictionary."""
    return next(json.loads(text) for text, _ in LEGAL if json.loads(text)["do"] == name)


def test_every_message_has_examples_and_wrong_fields():
    assert {json.loads(text)["do"] for text, _ in LEGAL} == set(ORDERS) == set(WRONG_FIELDS)


def test_every_message_of_the_document_is_known():
    part = PROTOCOL[PROTOCOL.index("## From the page"):PROTOCOL.index("## A recording")]
    told = re.findall(r"^\| `(\{.*?\})`", part, re.MULTILINE)
    assert {json.loads(text)["do"] for text in told} == set(ORDERS)
    for text in told:
        order_of(read_message(text.replace('"..."', '"text"')))


@pytest.mark.parametrize("name, field, value", [
    (name, field, value) for name, wrong in WRONG_FIELDS.items() for field, value in wrong])
def test_a_wrong_value_is_named(name, field, value):
    message = dict(example(name), **{field: value})
    with pytest.raises(UsageError, match="^%s: %s is .*; legal: " % (name, field)) as caught:
        order_of(message)
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize("name", ORDERS)
def test_no_field_may_be_missing_or_too_many(name):
    for field in set(example(name)) - {"do"}:
        message = example(name)
        del message[field]
        with pytest.raises(UsageError, match="lacks the field %s" % field):
            order_of(message)
    with pytest.raises(UsageError, match='has no field "more"'):
        order_of(dict(example(name), more=1))


@pytest.mark.parametrize("do", [None, 1, "", "Drive", "__init__", ["drive"], {"do": "drive"}, True])
def test_an_unknown_message_is_an_error(do):
    with pytest.raises(UsageError, match="^do is .*; legal: drawn, ping"):
        order_of({"do": do})


@pytest.mark.parametrize("text", [
    "", " ", "{", "drive", "[1]", "1", "null", '"x"', "true", b'{"do": "stop"}', "\ud800",
    '{"do": "ping", "at": NaN}', '{"do": "ping", "at": Infinity}', '{"do": "ping", "at": -Infinity}',
    '{"do": "ping", "at": 1e999}', '{"do": "ping", "at": %s}' % ("9" * 4010),
    '{"do": "stop", "robot": 1, "robot": 2}', '{"do": "stop", "do": "unlock", "robot": 1}',
    '{"do": "stop", "robot": {"a": 1, "a": 2}}',
    "[" * 4000, '{"a":' * 800, '{"a":' * 600 + "1" + "}" * 600 + "x",
    '{"do": "say", "text": "%s"}' % ("x" * 4096), '{"do": "say", "text": "%s"}' % ("å" * 2040),
])
def test_what_is_no_message_is_an_error(text):
    with pytest.raises(UsageError):
        order_of(read_message(text))


def test_a_value_nested_deeply_is_named_too():
    depth = 900
    with pytest.raises(UsageError):
        order_of(read_message('{"do": "stop", "robot": %s1%s}' % ("[" * depth, "]" * depth)))


def test_4096_bytes_are_read_and_4097_are_not():
    text = '{"do": "say", "text": "%s"}'
    assert read_message(text % ("x" * (4096 - len(text) + 2)))["do"] == "say"
    with pytest.raises(UsageError, match="4096"):
        read_message(text % ("x" * (4097 - len(text) + 2)))


JSON = some.recursive(
    some.none() | some.booleans() | some.floats() | some.integers() | some.text(max_size=20),
    lambda inner: some.lists(inner, max_size=4) | some.dictionaries(some.text(max_size=8), inner, max_size=4),
    max_leaves=12)


@given(some.sampled_from(sorted(ORDERS)), some.dictionaries(
    some.sampled_from(["robot", "stamp", "forward", "turn", "on", "command", "linear", "name", "text", "at"]), JSON))
def test_any_values_give_an_order_or_an_error(name, values):
    try:
        order = order_of(read_message(json.dumps(dict(values, do=name))))
    except UsageError:
        return
    for value in order:
        assert type(value) in (int, float, str, bool)
        assert not isinstance(value, (int, float)) or math.isfinite(value)
    assert getattr(order, "robot", 0) == "all" or getattr(order, "robot", 0) >= 0


@given(some.text(max_size=300))
def test_any_text_is_a_message_or_an_error(text):
    try:
        order_of(read_message(text))
    except UsageError:
        pass


def test_first_words():
    words = {"key": "k", "visitor": "abcdefgh12345678"}
    assert first_words(words) == ("k", "abcdefgh12345678")
    for wrong in (dict(words, key=1), dict(words, visitor="short"), dict(words, visitor="x" * 65), dict(words, more=1),
                  dict(words, visitor="abcdefgh 1234567"), dict(words, visitor="äbcdefgh12345678"), {"key": "k"},
                  {"visitor": "abcdefgh12345678"}, dict(words, visitor=None), {}):
        with pytest.raises(UsageError):
            first_words(wrong)


def test_an_error_of_the_first_words_never_has_the_key():
    for wrong in ({"key": "SECRET"}, {"key": "SECRET", "visitor": "?"}, {"key": ["SECRET"], "visitor": "a" * 16},
                  {"key": "SECRET", "visitor": "a" * 16, "more": 1}):
        with pytest.raises(UsageError) as caught:
            first_words(wrong)
        assert "SECRET" not in str(caught.value)
