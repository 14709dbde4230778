"""Programs as students run them on their laptops: Robot on a WebSocket of a site, and raw connections."""

import websocket

from pioneer_control.client import Robot

from real_time import LIMIT, until


def key_of(viewer, robot=1):
    """Return the key that a page was told for a robot."""
    def found():
        keys = [each["key"] for each in viewer.of("program") if each["robot"] == robot]
        return keys and keys[-1]
    return until(found, "the key of robot %d" % robot)


def url_of(site, robot=1):
    return "%srobot/%s" % (site.base.replace("http", "ws"), robot)


def program(site, viewer, robot=1, **options):
    """Return a Robot for a program of the person at a page."""
    return Robot(url_of(site, robot), key=key_of(viewer, robot), **options)


def raw(site, robot="1", **options):
    """Return a WebSocket at the address of a robot, before its first words."""
    return websocket.create_connection(url_of(site, robot), timeout=LIMIT, suppress_origin="origin" not in options,
                                       **options)


def close_of(connection):
    """Wait until the server closes a connection. Returns code and reason."""
    code, data = connection.recv_data()
    assert code == websocket.ABNF.OPCODE_CLOSE, data
    connection.shutdown()
    return int.from_bytes(data[:2], "big"), data[2:].decode()
