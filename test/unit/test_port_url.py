"""The URL of a robot's port: the key at its end is found, and shown to nobody."""

import pytest

from pioneer_control.port_url import is_web_socket, split_key, without_key


@pytest.mark.parametrize("url, shown, key", [
    ("ws://teacher:8080/robot/7#key=abc", "ws://teacher:8080/robot/7", "abc"),
    ("wss://teacher/robot/7?seat=3#key=abc", "wss://teacher/robot/7?seat=3", "abc"),
    ("ws://teacher/#key=a%20b+c%3D=%23", "ws://teacher/", "a b+c==#"),
    ("ws://teacher/#seat=3&key=abc&more", "ws://teacher/", "abc"),
    ("ws://teacher/#Key=abc", "ws://teacher/", "abc"),
    ("ws://teacher/#key=", "ws://teacher/", ""),
    ("ws://teacher/#kye=abc", "ws://teacher/", None),
    ("WS://teacher/#abc", "WS://teacher/", None),
    ("ws://teacher/robot/7", "ws://teacher/robot/7", None),
    # Mistyped, but still a key.
    ("http://teacher/robot/7#key=abc", "http://teacher/robot/7", "abc"),
    ("wss//teacher/robot/7#key=abc", "wss//teacher/robot/7", "abc"),
    ("teacher:8080#key=abc", "teacher:8080", "abc"),
    # Nothing of a key, and so as it was.
    ("/dev/ttyUSB0", "/dev/ttyUSB0", None), ("/dev/serial/by-id/usb#1", "/dev/serial/by-id/usb#1", None),
    ("socket://localhost:8101", "socket://localhost:8101", None), ("COM3", "COM3", None),
    ('<material color="#ff0000" keys="3"/>', '<material color="#ff0000" keys="3"/>', None), ("", "", None),
])
def test_a_key_is_taken_from_its_url(url, shown, key):
    assert split_key(url) == (shown, key)
    assert without_key(url) == shown


@pytest.mark.parametrize("url, so", [("ws://a", True), ("WSS://a", True), ("http://a", False), ("/dev/ws", False),
                                     ("socket://ws://", False)])
def test_a_web_socket_is_known_by_its_scheme(url, so):
    assert is_web_socket(url) is so
