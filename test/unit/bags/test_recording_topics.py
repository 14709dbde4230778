"""The list of recorded topics is read, checked, and turned into whole names."""

import pathlib

import pytest
import yaml

from pioneer_control.bags.recording.topics import KeptTopic, groups_to_ask_for, load_list, topics_of
from pioneer_control.errors import UsageError

ROOT = pathlib.Path(__file__).resolve().parents[3]
LIST = """
always:
  reported:
    pose: where it is
  shared:
    /tf: frames
    /map:
also:
  wire:
    p2os/wire: raw
"""


@pytest.fixture
def write(tmp_path):
    def written(text):
        path = tmp_path / "list.yaml"
        path.write_text(text)
        return str(path)
    return written


def test_rows(write):
    assert load_list(write(LIST)) == (
        KeptTopic("pose", "reported", False), KeptTopic("/tf", "shared", False), KeptTopic("/map", "shared", False),
        KeptTopic("p2os/wire", "wire", True))


def test_whole_names_are_those_of_each_robot_and_everybodys_once(write):
    rows = load_list(write(LIST))
    assert topics_of(rows, ["a", "lab/b"]) == ("/a/pose", "/lab/b/pose", "/tf", "/map")
    assert topics_of(rows, ["a"], ["wire"]) == ("/a/pose", "/a/p2os/wire", "/tf", "/map")
    assert topics_of(rows, [""]) == ("/pose", "/tf", "/map")


def test_a_topic_that_is_listed_twice_is_recorded_once(write):
    rows = load_list(write("always: {a: {pose: x, /tf: x}, b: {pose: y}}\nalso: {c: {/tf: y}}"))
    assert topics_of(rows, ["a"]) == topics_of(rows, ["a"], ["c"]) == ("/a/pose", "/tf")


def test_a_group_that_cannot_be_asked_for_is_told_with_those_that_can(write):
    with pytest.raises(UsageError, match="no group 'wier'.*did you mean 'wire'.*there are: wire"):
        topics_of(load_list(write(LIST)), ["a"], ["wier"])
    with pytest.raises(UsageError, match="no group 'reported'"):
        topics_of(load_list(write(LIST)), ["a"], ["reported"])


@pytest.mark.parametrize("text, told", [
    ("always: {a: {pose: [1, 2}}", r"list\.yaml, line 1: .*a row is 'topic: reason'"),
    ("always:\n  a:\n    pose: x\n   sonar: y\n", r"list\.yaml, line 4: "),
    ("pose: where", "no section is called 'pose'; there are always and also"),
    ("- pose", "the list is to have rows"),
    ("always: {a: [pose, sonar]}", r"group 'a' is to have rows 'name: ...', not \['pose', 'sonar'\]"),
    ("always: {a: {po se: x}}", "'po se' in group 'a' is no name of a topic"),
    ("always: {a: {pose/: x}}", "'pose/' in group 'a' is no name of a topic"),
    ("always: {a: {1: x}}", "a row 1, which is no text"),
])
def test_a_mistake_is_told_with_its_file_and_place(write, text, told):
    with pytest.raises(UsageError, match=told):
        load_list(write(text))


def test_a_home_is_found(write, tmp_path, monkeypatch):
    """The shell does not expand ~ behind topics:=."""
    monkeypatch.setenv("HOME", str(tmp_path))
    assert load_list(write(LIST)) == load_list("~/list.yaml")


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(UsageError, match="cannot read the list of topics .*nothing.yaml: No such file"):
        load_list(str(tmp_path / "nothing.yaml"))


class TestOurs:
    """The list in config/record.yaml."""

    path = ROOT / "config" / "record.yaml"
    rows = load_list(str(path))

    def test_every_topic_has_a_reason(self):
        groups = [group for section in yaml.safe_load(self.path.read_text()).values() for group in section.values()]
        assert [topic for group in groups for topic, reason in group.items() if not isinstance(reason, str)] == []

    def test_what_makes_the_robot_send_more_has_to_be_asked_for(self):
        assert groups_to_ask_for(self.rows) == ("wire", "packets", "rviz")
        usual = {row.topic for row in self.rows if not row.asked_for}
        assert not usual & {"io", "imu", "wire"}
