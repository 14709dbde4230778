"""Pictures, checked through matplotlib's objects."""

import math
import subprocess
import sys

import numpy as np
import pytest
from matplotlib.patches import Polygon
from std_msgs.msg import Header

import bag_factory as make
from pioneer_control.bags import draw
from pioneer_control.bags.pages import page
from pioneer_control.bags.recorded_run import PADDLE_MIDDLE
from pioneer_control.bags.run import read_run

PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture
def drawn(tmp_path):
    """Draw messages, and return the axes."""

    def drawn(messages, title=None):
        sheet = page.figure(read_run(make.write_bag(tmp_path / "run.bag", messages)), title)
        sheet.canvas.draw()  # what raises while it is rendered raises here
        return sheet.axes[0]

    return drawn


def labels(axes):
    """Return all labels that the legend could have."""
    return axes.get_legend_handles_labels()[1]


def line(axes, label):
    """Return x and y of the line with a label."""
    return dict(zip(*reversed(axes.get_legend_handles_labels())))[label].get_xydata()


def texts(axes):
    """Return all texts beside and on the drawing."""
    return [text.get_text() for text in axes.texts + axes.figure.texts]


def without(messages, *names):
    """Return the messages except those of topics with these last names."""
    return [entry for entry in messages if entry[0].rsplit("/", 1)[1] not in names]


def test_everything_is_there(drawn):
    axes = drawn(make.driven(drift=0.1))
    assert labels(axes) == ["true path", "odometry", "sonar echo", "can before", "can after", "way of a can",
                            "robot at start", "robot at end"]
    assert line(axes, "true path")[[0, -1]] == pytest.approx(np.array([(1.0, 1.0), (2.0, 1.0)]))
    assert line(axes, "odometry")[-1] == pytest.approx((1.9, 1.0))
    assert line(axes, "can before")[0] == pytest.approx((2.0, 1.0))
    assert line(axes, "can after")[0] == pytest.approx((2.3, 1.0))
    assert len(axes.images) == 1


def looking(pans, seconds=2.0):
    """Yield ptz_state of a camera that looks at each pan for so long, and turns in between."""
    time = 1000.0
    for pan in pans:
        for _ in range(round(seconds / 0.1)):
            yield "/pioneer/ptz_state", make.ptz(pan, 0), time
            time += 0.1
        for turning in range(5):
            yield "/pioneer/ptz_state", make.ptz(pan + turning + 1, 0), time
            time += 0.1


def test_what_a_camera_saw_is_drawn_as_fans_from_where_the_robot_was(drawn):
    axes = drawn([*make.driven(), *looking((90, 0, -45))])
    assert "camera's view" in labels(axes)
    fans = [each.get_xydata() for each in axes.get_lines() if each.get_label() == "camera's view"]
    assert len(fans) == 3
    ways = [fan[1:-1].mean(axis=0) - fan[0] for fan in fans]
    assert [round(math.degrees(math.atan2(y, x))) for x, y in ways] == [-90, 0, 45]     # pan is to the right
    assert [round(float(fan[0][0]), 1) for fan in fans] == [1.2, 1.4, 1.7]
    widths = [np.ptp(np.unwrap(np.arctan2(*(fan[1:-1] - fan[0]).T[::-1]))) for fan in fans]
    assert np.degrees(widths) == pytest.approx([45.0] * 3)
    assert "camera's view" not in labels(drawn(make.driven()))


def test_tracks_begin_together_in_the_map(drawn):
    axes = drawn(make.driven(start=(3.0, 4.0, -2.0), seconds=5))
    assert line(axes, "odometry")[0] == pytest.approx((3.0, 4.0))
    assert line(axes, "odometry") == pytest.approx(line(axes, "true path"))


def test_the_whole_room_is_seen_to_scale(drawn):
    axes = drawn(make.driven(start=(3.5, 1.0, 0.0)))
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    assert left < 0 and right > 8 and bottom < 0 and top > 6
    assert axes.get_aspect() == 1.0
    box = axes.get_window_extent()
    assert box.width / box.height == pytest.approx((right - left) / (top - bottom), rel=0.01)


def test_of_a_large_building_only_what_the_robot_saw_is_drawn(drawn):
    axes = drawn(without(make.driven(), "map") + [("/pioneer/map", make.room(80.0, 60.0), 1000.0)])
    assert axes.get_xlim()[1] < 10 and axes.get_ylim()[1] < 10


def test_the_robot_is_drawn_to_scale_where_it_was(drawn):
    axes = drawn(make.driven())
    end = next(patch for patch in axes.patches if isinstance(patch, Polygon) and patch.get_label() == "robot at end")
    assert np.ptp(end.get_xy(), axis=0) == pytest.approx((0.66, 0.4))
    assert end.get_xy()[:, 0].max() == pytest.approx(2.36)


def test_gripper_events_are_numbered_where_the_paddles_were(drawn):
    axes = drawn(make.driven())
    picked = next(text for text in axes.texts if text.get_text() == "1")
    assert picked.xy == pytest.approx((1.5 + 0.36 - PADDLE_MIDDLE, 1.0))
    assert "picked up at 5 s" in texts(axes) and "put down at 8 s" in texts(axes)


def test_title(drawn):
    written = texts(drawn(make.driven()))
    assert "pioneer (p3dx-sh) in tutorial" in written
    assert any(text.startswith("10 s   ·   1.0 m driven") for text in written)
    assert "mine" in texts(drawn(make.driven(), "mine"))


def test_a_real_robots_bag(drawn):
    axes = drawn(without(make.driven(), "ground_truth", "map", "world", "cans"))
    assert labels(axes) == ["odometry", "sonar echo *", "robot at start", "robot at end"]
    assert line(axes, "odometry")[0] == pytest.approx((0.0, 0.0))
    assert not axes.images
    assert any("as the robot's odometry has it" in text for text in texts(axes))


def test_a_map_without_truth_is_not_drawn_in_the_wrong_place(drawn):
    assert not drawn(without(make.driven(), "ground_truth")).images


@pytest.mark.parametrize("missing", ["map", "ground_truth", "sonar", "gripper_state", "robot_info", "cans", "world"])
def test_whatever_is_missing_the_rest_is_drawn(drawn, missing):
    assert "odometry" in labels(drawn(without(make.driven(), missing)))


def test_scans_of_a_laser_change_nothing(drawn):
    messages = list(make.driven())
    assert labels(drawn(messages + list(make.scans()))) == labels(drawn(messages))


def test_a_laser_that_is_lost_is_told(tmp_path, drawn):
    told = [("/diagnostics", make.diagnostics("pioneer/laser", Laser=(2, "no scans: the laser is silent")), 1005.0)]
    messages = [*make.eventful(seconds=10), *make.scans(), *told]
    drawn(messages)
    [report] = [each for each in read_run(make.write_bag(tmp_path / "lost.bag", messages)).faults
                if each.who == "Laser"]
    assert report.what == "no scans: the laser is silent"


def test_a_robot_that_never_moved(drawn):
    axes = drawn(make.driven(speed=0.0))
    assert any("0.0 m driven" in text for text in texts(axes))


def test_a_single_pose(drawn):
    assert "odometry" in labels(drawn([("/pose", make.odometry(1.0, 2.0, 0.5), 1.0)]))


def test_no_cans_in_the_world(drawn):
    messages = without(make.driven(seconds=1), "cans") + [("/pioneer/cans", make.cans(), 1000.0)]
    assert "can before" not in labels(drawn(messages))


def test_dollars_in_what_was_decided_make_no_formula(drawn):
    decision = make.message_class("Decision")(wander=1, reason="$\\frac{$ is what it costs")
    drawn([*make.driven(seconds=1), ("/pioneer/decision", decision, 1000.2), ("/pioneer/decision", decision, 1000.8)])


class TestCommand:
    def test_beside_the_bag(self, tmp_path, capsys):
        assert draw.main([make.write_bag(tmp_path / "run.bag", make.driven(seconds=2))]) == 0
        assert capsys.readouterr().out.strip() == str(tmp_path / "run.png")
        assert (tmp_path / "run.png").read_bytes().startswith(PNG)

    @pytest.mark.parametrize("ending, begins", [("png", PNG), ("pdf", b"%PDF"), ("svg", b"<?xml")])
    def test_named(self, tmp_path, ending, begins):
        bag, picture = make.write_bag(tmp_path / "run.bag", make.driven(seconds=2)), tmp_path / ("x.%s" % ending)
        assert draw.main([bag, "-o", str(picture)]) == 0
        assert picture.read_bytes().startswith(begins)

    @pytest.mark.parametrize("messages, says", [([], "is empty"), ([("/chatter", Header(), 1.0)], "/chatter")])
    def test_nothing_to_draw(self, tmp_path, capsys, messages, says):
        assert draw.main([make.write_bag(tmp_path / "run.bag", messages)]) == 2
        error = capsys.readouterr().err
        assert error.startswith("draw_run: ") and says in error and error.count("\n") == 1
        assert not (tmp_path / "run.png").exists()

    def test_no_such_bag(self, tmp_path, capsys):
        assert draw.main([str(tmp_path / "missing.bag")]) == 2
        assert "no such file" in capsys.readouterr().err

    def test_a_picture_that_cannot_be_written(self, tmp_path, capsys):
        bag = make.write_bag(tmp_path / "run.bag", make.driven(seconds=1))
        assert draw.main([bag, "-o", str(tmp_path / "missing" / "x.png")]) == 2
        assert "x.png" in capsys.readouterr().err

    def test_a_format_that_is_none(self, tmp_path, capsys):
        bag = make.write_bag(tmp_path / "run.bag", make.driven(seconds=1))
        assert draw.main([bag, "-o", str(tmp_path / "x.doc")]) == 2
        assert ".png" in capsys.readouterr().err

    def test_a_place_where_nothing_can_be_written_is_said_before_the_bag_is_read(self, tmp_path, capsys):
        assert draw.main([str(tmp_path / "missing.bag"), "-o", str(tmp_path / "missing" / "x.png")]) == 2
        assert "there is no directory" in capsys.readouterr().err

    def test_a_directory_is_no_picture(self, tmp_path, capsys):
        (tmp_path / "x.png").mkdir()
        assert draw.main([str(tmp_path / "missing.bag"), "-o", str(tmp_path / "x.png")]) == 2
        assert "is a directory" in capsys.readouterr().err

    def test_several_are_compared(self, tmp_path, capsys):
        bags = [make.write_bag(tmp_path / ("%s.bag" % name), make.driven(seconds=2, speed=speed))
                for name, speed in (("a", 0.1), ("b", 0.2))]
        assert draw.main(bags) == 0
        assert capsys.readouterr().out.strip() == str(tmp_path / "a-compared.png")
        assert (tmp_path / "a-compared.png").read_bytes().startswith(PNG)

    def test_too_many_are_said_before_they_are_read(self, tmp_path, capsys):
        assert draw.main([str(tmp_path / ("%s.bag" % number)) for number in range(9)]) == 2
        assert "9 runs are too many" in capsys.readouterr().err

    def test_parts_are_in_the_order_of_their_numbers(self):
        named = ["run/x_0.bag", "run/x_1.bag", "run/x_10.bag.active", "run/x_2.bag"]
        ordered = ["run/x_0.bag", "run/x_1.bag", "run/x_2.bag", "run/x_10.bag.active"]
        assert draw.wanted(named, [], True) == [(ordered, None)]

    def test_parts_of_one_recording(self, tmp_path, capsys):
        messages = sorted(make.driven(seconds=4), key=lambda entry: entry[2])
        parts = [make.write_bag(tmp_path / ("%s.bag" % number), half)
                 for number, half in enumerate((messages[:80], messages[80:]))]
        assert draw.main(["--parts", *parts, "-o", str(tmp_path / "x.png")]) == 0
        (run,) = [draw.read(*each) for each in draw.wanted(parts, [], True)]
        assert run.duration == pytest.approx(4.0)

    def test_a_damaged_bag_is_drawn_and_the_damage_is_said(self, tmp_path, capsys):
        bag = make.write_bag(tmp_path / "run.bag", make.driven(seconds=5))
        with open(bag, "r+b") as file:
            file.truncate(int(0.6 * file.seek(0, 2)))
        assert draw.main([bag]) == 0
        told = capsys.readouterr()
        assert told.out.strip() == str(tmp_path / "run.png") and told.err.startswith("draw_run: %s: " % bag)

    def test_robots_of_one_bag_are_compared(self, tmp_path):
        bag = make.write_bag(tmp_path / "run.bag",
                             list(make.driven(seconds=1, name="alice")) + list(make.driven(seconds=1, name="bob")))
        assert draw.main([bag, "--robot", "alice", "--robot", "bob"]) == 0
        assert (tmp_path / "run-compared.png").exists()

    def test_robots_that_fit_no_bags(self, capsys):
        assert draw.main(["a.bag", "b.bag", "c.bag", "--robot", "alice", "--robot", "bob"]) == 2
        assert "one for each of the 3" in capsys.readouterr().err

    def test_one_of_several_robots(self, tmp_path, capsys):
        messages = list(make.driven(seconds=1, name="alice")) + list(make.driven(seconds=1, name="bob"))
        bag = make.write_bag(tmp_path / "run.bag", messages)
        assert draw.main([bag]) == 2 and "--robot" in capsys.readouterr().err
        assert draw.main([bag, "--robot", "bob"]) == 0


def test_matplotlib_is_loaded_only_to_draw():
    check = ("import sys, pioneer_control.bags.draw; "
             "sys.exit(any(name in sys.modules for name in ('matplotlib', 'rospy', 'rosbag')))")
    assert subprocess.run([sys.executable, "-c", check]).returncode == 0
