"""``draw_run --html RUN.bag`` writes one file with the page and the run inside."""

import json
import pathlib
import re
import subprocess
import sys

import pytest
from bag_factory import driven, write_bag

from pioneer_control.web.columns import read_columns
from pioneer_control.web.frames import COLUMNS
from pioneer_control.web.one_file import main

NODE = pathlib.Path(__file__).resolve().parents[3] / "nodes" / "draw_run"


def inside(path):
    return json.loads(re.search(r'id="recording">(.*?)</script>', path.read_text(), re.DOTALL).group(1))


@pytest.mark.parametrize("command", [[str(NODE)], ["-m", "pioneer_control.web.one_file"]])
def test_the_node_writes_it_beside_the_bag(tmp_path, command):
    bag = write_bag(tmp_path / "run.bag", driven())
    done = subprocess.run([sys.executable, *command, "--html", bag], stdout=subprocess.PIPE, universal_newlines=True)
    assert done.returncode == 0 and done.stdout == "%s/run.html\n" % tmp_path
    value = inside(tmp_path / "run.html")
    assert value["name"] == "run" and value["columns"][0]["rows"] == 101


def test_it_has_all_frames_and_asks_for_nothing_outside(tmp_path, capsys):
    import base64

    bag = write_bag(tmp_path / "run.bag", driven())
    assert main(["--html", bag, "-o", str(tmp_path / "page.html"), "--title", "</script><b>mine"]) == 0
    text = (tmp_path / "page.html").read_text()
    assert not re.search(r"(?:src|href)=\"(?!data:)", text) and "</script><b>" not in text
    entry = inside(tmp_path / "page.html")["columns"][0]
    message = COLUMNS + entry["robot"].to_bytes(2, "little") + base64.b64decode(entry["data"])
    assert len(read_columns(message, entry["rows"], entry["sonar"]).frames) == 101


@pytest.mark.parametrize("contents", [b"", b"no bag"])
def test_what_is_no_bag_leaves_nothing(tmp_path, capsys, contents):
    (tmp_path / "run.bag").write_bytes(contents)
    assert main(["--html", str(tmp_path / "run.bag")]) == 2
    assert "run.bag" in capsys.readouterr().err and not (tmp_path / "run.html").exists()


def test_a_folder_that_is_not_there_is_an_error(tmp_path, capsys):
    bag = write_bag(tmp_path / "run.bag", driven(seconds=1))
    assert main(["--html", bag, "-o", str(tmp_path / "nowhere" / "page.html")]) == 2
    assert "nowhere" in capsys.readouterr().err
