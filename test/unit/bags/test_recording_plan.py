"""The plan of a recording, made from the command line of `record`, and the files that it must not destroy."""

import os
import time

import pytest

from pioneer_control.bags.command_line import parser_of
from pioneer_control.bags.recording import plan, start
from pioneer_control.bags.recording.plan import GB, MB
from pioneer_control.errors import UsageError

NOW = time.strptime("2026-11-21 18:05:09", "%Y-%m-%d %H:%M:%S")
LIST = "always: {own: {pose: where}, shared: {/tf: frames}}\nalso: {wire: {wire: raw}}\n"


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "list.yaml").write_text(LIST)
    return tmp_path


def recording(*words):
    return plan.plan_of(parser_of("record", "", plan.OPTIONS).parse_args([*words, "--topics=list.yaml"]), NOW)


def test_a_robot_by_default(here):
    made = recording()
    assert made.robots == ("pioneer",) and made.topics == ("/pioneer/pose", "/tf") and made.asked_for == ()
    assert made.file == str(here / "pioneer_2026-11-21-18-05-09.bag")
    assert made.command == ["rosrun", "rosbag", "record", "--output-name=" + made.stem, "--tcpnodelay",
                            "--min-space=256M", "--chunksize=64", "--lz4",
                            "/pioneer/pose", "/tf"]


def test_several_robots_however_they_are_typed(here):
    for words in (["a", "b"], ["a b"], ["/a/, b"], ["a,b", "a"]):
        assert recording(*words).robots == ("a", "b")
    assert recording("a", "b").topics == ("/a/pose", "/b/pose", "/tf")
    assert recording("a", "b").file == str(here / "a_b_2026-11-21-18-05-09.bag")
    assert recording("/").robots == ("",) and recording("/").topics == ("/pose", "/tf")
    assert recording("/").file == str(here / "robot_2026-11-21-18-05-09.bag")
    assert recording("lab/a", "b", "c", "d").file == str(here / "lab-a_and_3_more_2026-11-21-18-05-09.bag")


def test_parts_repeat_what_is_latched(here):
    made = recording("--split=500MB", "--bag=x")
    assert made.file == str(here / "x_0.bag")
    assert {"--split", "--size=500", "--repeat-latched"} <= set(made.command)
    assert {"--split", "--duration=5400", "--repeat-latched"} <= set(recording("--split=1.5h").command)
    assert not {"--split", "--repeat-latched"} & set(recording().command)


def test_compression(here, capsys):
    assert "--bz2" in recording("--compression=bz2").command
    assert not {"--lz4", "--bz2", "--none"} & set(recording("--compression=none").command)
    assert "--lz4" in recording("--compression=").command, "record.launch gives every option"
    with pytest.raises(SystemExit):
        recording("--compression=zip")
    assert "invalid choice: 'zip'" in capsys.readouterr().err


def test_what_was_asked_for_on_top(here):
    assert recording("a", "--also=wire").asked_for == ("/a/wire",)


@pytest.mark.parametrize("bag, stem", [
    ("x", "x"), ("x.bag", "x"), ("x.bag.active", "x"), ("sub/x.bag", "sub/x"), ("x.y", "x.y"),
    ("sub", "sub/pioneer_2026-11-21-18-05-09"), ("new/", "new/pioneer_2026-11-21-18-05-09"),
    ("with space/x.bag", "with space/x")])
def test_where_the_bag_goes(here, bag, stem):
    (here / "sub").mkdir()
    assert recording("--bag=" + bag).stem == str(here / stem)
    assert recording("--bag=" + str(here / bag) + "/" * bag.endswith("/")).stem == str(here / stem)


@pytest.mark.parametrize("words, told", [
    (["a!"], "'a!' is no name of a robot"),
    ([" "], "no robot is named"),
    (["--split=5"], "split '5' is not legal: give a number with a unit, one of MB, GB, s, min, h"),
    (["--split=5m"], "split '5m' is not legal"),
    (["--split=0s"], "split '0s' is not legal: give at least"),
    (["--keep-free=1h"], "keep_free '1h' is not legal: give a size"),
    (["--also=nothing"], "no group 'nothing'"),
])
def test_what_makes_no_sense_is_told_with_what_would(here, words, told):
    with pytest.raises(UsageError, match=told):
        recording(*words)


class TestPlace:
    """No existing file is lost, and a plan that cannot work is refused at the start."""

    def test_a_free_name_in_a_directory_with_room(self, here):
        (here / "xy.bag").write_bytes(b"")
        (here / "x_y.bag").write_bytes(b"")
        plan.check_place(recording("--bag=x"), GB)
        assert sorted(os.listdir(str(here))) == ["list.yaml", "x_y.bag", "xy.bag"]

    @pytest.mark.parametrize("there, split", [
        ("x.bag", ""),
        ("x.bag.active", ""),
        ("x_0.bag", "1h"),
        ("x_12.bag", "1h"),
        ("x_3.bag.active", "1h"),
    ])
    def test_what_is_there_stays(self, here, there, split):
        (here / there).write_bytes(b"precious")
        # of that nothing would be lost
        plan.check_place(recording("--bag=x", "--split=" + ("" if split else "1h")), GB)
        with pytest.raises(UsageError, match="%s is there already, and stays as it is" % there) as caught:
            plan.check_place(recording("--bag=x", "--split=" + split), GB)
        is_unfinished = there.endswith(".active")
        assert ("is being recorded, or is of a recorder that was killed" in str(caught.value)) == is_unfinished
        assert (here / there).read_bytes() == b"precious"

    def test_no_permission(self, here, monkeypatch):
        def refuse(dir):
            raise PermissionError(13, "Permission denied")
        monkeypatch.setattr(plan.tempfile, "TemporaryFile", refuse)
        with pytest.raises(UsageError, match="cannot write x.bag in .*: Permission denied"):
            plan.check_place(recording("--bag=x"), GB)

    def test_a_full_disk(self, here):
        with pytest.raises(UsageError, match="only 200 MB are free in .*ends below 256 MB.*keep_free"):
            plan.check_place(recording("--bag=x"), 200 * MB)
        plan.check_place(recording("--bag=x", "--keep-free=100MB"), 200 * MB)


def test_parts_are_in_their_order(here):
    for number in (0, 1, 2, 10):
        (here / ("x_%s.bag%s" % (number, ".active" if number == 10 else ""))).write_bytes(b"")
    (here / "x.bag").write_bytes(b"")
    parts = [os.path.basename(path) for path in recording("--bag=x", "--split=1h").parts]
    assert parts == ["x_0.bag", "x_1.bag", "x_2.bag", "x_10.bag.active"]
    assert [os.path.basename(path) for path in recording("--bag=x").parts] == ["x.bag"]
    assert recording("--bag=nowhere/x").parts == []


def test_what_a_killed_recorder_left_is_told_what_is_being_written_is_not(here):
    (here / "old.bag.active").write_bytes(b"")
    os.utime(str(here / "old.bag.active"), (1000.0, 1000.0))
    (here / "new.bag.active").write_bytes(b"")
    os.utime(str(here / "new.bag.active"), (5000.0, 5000.0))
    text = plan.left_behind(str(here), 5001.0)
    assert "old.bag.active" in text and "rosbag reindex" in text
    (here / "old.bag.active").unlink()
    assert plan.left_behind(str(here), 5001.0) == ""


@pytest.mark.parametrize("word", ["bag:=x.bag", "also:=wire", "keep_free:=1GB", "robots:=a"])
def test_what_was_meant_for_roslaunch_is_refused(monkeypatch, word):
    monkeypatch.setattr("sys.argv", ["record", word, "__name:=recorder"])
    with pytest.raises(SystemExit, match="record: %s: this is the form for roslaunch" % word):
        start.main()
