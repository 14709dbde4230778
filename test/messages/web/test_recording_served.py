"""``python3 -m pioneer_control.web RUN.bag`` serves the run to a viewer; what cannot be shown is an error."""

import json
import re
import subprocess
import sys
import zlib

import pytest
import websocket
from bag_factory import driven, write_bag

from pioneer_control.web.columns import read_columns

LIMIT = 60.0    # s


def start(*arguments):
    return subprocess.Popen([sys.executable, "-m", "pioneer_control.web", "--port", "0", *map(str, arguments)],
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True)


def messages_of(address, until):
    """Return the messages of the server until this condition holds for them."""
    base, key = address.split("#")
    viewer = websocket.create_connection(base.replace("http", "ws") + "page", timeout=LIMIT)
    viewer.send(json.dumps({"key": key, "visitor": "v" * 16}))
    found = []
    while not until(found):
        found.append(viewer.recv())
    viewer.close()
    return found


@pytest.mark.parametrize("robots", [["pioneer"], ["a", "b"]])
def test_a_viewer_gets_the_whole_run(tmp_path, robots):
    entries = sorted((entry for name in robots for entry in driven(name=name)), key=lambda entry: entry[2])
    with start(write_bag(tmp_path / "run.bag", entries)) as process:
        try:
            address = re.search(r"http://\S+", process.stdout.readline()).group()
            found = messages_of(address, lambda found: sum(isinstance(each, bytes) for each in found) > len(robots))
        finally:
            process.terminate()
            assert process.wait(LIMIT) == 0
    assert json.loads(found[0])["hello"]["kind"] == "recording"
    whole, *columns = [each for each in found if isinstance(each, bytes)]
    assert whole[:1] == b"\x03"
    value = json.loads(zlib.decompress(whole[1:]))
    assert value["name"] == "run" and value["duration"] == pytest.approx(10.0, abs=0.01)
    for entry, message in zip(value["columns"], columns):
        read = read_columns(message, entry["rows"], entry["sonar"])
        assert read.robot == entry["robot"] and len(read.frames) == 101


@pytest.mark.parametrize("contents, words", [(b"no bag at all", "is not a bag"), (b"", "is empty")])
def test_what_is_no_bag_is_an_error_for_people(tmp_path, contents, words):
    path = tmp_path / "run.bag"
    path.write_bytes(contents)
    with start(path) as process:
        _, error = process.communicate(timeout=LIMIT)
    assert process.returncode == 2 and words in error and "Traceback" not in error
