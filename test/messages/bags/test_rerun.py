"""What a bag tells about a program that gave commands, and the result of a comparison. The tests use bag files and no
master.
"""

import bag_factory as make
import genpy
import pytest
import rosbag
from geometry_msgs.msg import Twist
from std_msgs.msg import Header, String

from pioneer_control.bags.command_line import parser_of
from pioneer_control.bags.replaying import rerun
from pioneer_control.bags.reader import BagError
from pioneer_control.bags.recording.description import Description, text_of
from pioneer_control.errors import UsageError
from pioneer_control.msg import Decision, MotorState

PROGRAM = "/lab/mine"


def decision(stamp, wander=1, **values):
    return Decision(header=Header(stamp=genpy.Time.from_sec(stamp)), wander=wander, seed=7, speed=0.1, linear=0.1,
                    reason="driving", **values)


def twist(linear, angular=0.0):
    message = Twist()
    message.linear.x, message.angular.z = linear, angular
    return message


def write(path, messages, caller=PROGRAM):
    """Like make.write_bag, with the name of the publisher."""
    with rosbag.Bag(str(path), "w") as bag:
        for topic, message, seconds in messages:
            header = dict(topic=topic, type=message._type, md5sum=message._md5sum,
                          message_definition=message._full_text, callerid=caller)
            bag.write(topic, message, genpy.Time.from_sec(seconds), connection_header=header)
    return str(path)


def live_of(path, robot, program):
    """Return a re-run before any program is started."""
    return rerun.Rerun(parser_of("", "", rerun.OPTIONS).parse_args([path, "--robot", robot, "--program", program]))


def described(parameters):
    return String(text_of(Description({"date": "today"}, {}, {}, parameters)))


@pytest.fixture
def bag(tmp_path):
    early = described({"lab": {"mine": {"seed": 7, "deep": {"er": 1}}}})
    late = described({"other": 1})  # it had ended
    told = [("/pioneer/recording", early, 10.0), ("/pioneer/cmd_motor_state", MotorState(1), 10.5)]
    told += [("/pioneer/decision", decision(11.0 + 0.1 * n, 1 if n < 20 else 2), 11.05 + 0.1 * n) for n in range(40)]
    told += [("/pioneer/cmd_vel", twist(0.1), 11.06 + 0.1 * n) for n in range(40)]
    return write(tmp_path / "run.bag", [*told, ("/pioneer/recording", late, 20.0)])


class TestWhatTheBagTells:
    def test_who_commanded_whom_with_what(self, bag):
        live = live_of(bag, "", "rosPioneer2.py")
        assert (live._live.robot, live._node, live._parameters) == ("pioneer", PROGRAM, {"seed": 7, "deep": {"er": 1}})
        counts = {name: len(messages) for name, messages in live._live.messages.items() if name in rerun.KINDS}
        assert counts == {"cmd_motor_state": 1, "decision": 40, "cmd_vel": 40}
        assert live._time.to_sec() == pytest.approx(10.0)

    def test_a_wander_begins_and_ends_where_it_did(self, bag):
        live = live_of(bag, "pioneer", "")
        decided = rerun.decided([message for _, message in live._live.messages["decision"]])
        assert decided.pop("seed") == live._live.messages["decision"][0][1].seed
        assert decided == {"begin_at": pytest.approx([11.0, 13.0]), "end_at": pytest.approx([12.9, 14.9])}

    def test_without_decisions_there_are_no_limits(self):
        assert rerun.decided([]) == {"begin_at": [], "end_at": []}

    def test_a_seed_that_no_parameter_can_hold_is_left_out(self):
        large = decision(1.0, 1)
        large.seed = 2 ** 31
        assert rerun.decided([large]) == {"begin_at": [1.0], "end_at": [1.0]}

    def test_of_a_bag_that_does_not_say_who_it_was_the_programs_name_is_taken(self, tmp_path):
        path = make.write_bag(tmp_path / "old.bag", [("/pioneer/cmd_vel", twist(0.1), 1.0)])
        live = live_of(path, "", "my_wander.py")
        assert (live._node, live._parameters) == ("/my_wander", {})

    def test_nobody_commanded(self, tmp_path):
        path = write(tmp_path / "quiet.bag", [("/pioneer/pose", make.odometry(0, 0, 0), 1.0)])
        with pytest.raises(BagError, match="no robot was told anything"):
            live_of(path, "", "")

    def test_several_robots(self, tmp_path):
        path = write(tmp_path / "two.bag", [("/alice/cmd_vel", twist(0.1), 1.0), ("/bob/cmd_vel", twist(0.1), 1.1)])
        with pytest.raises(BagError, match="alice, bob. Choose one with robot:="):
            live_of(path, "", "")
        assert live_of(path, "/bob/", "")._live.robot == "bob"
        with pytest.raises(BagError, match="robot 'carol' was told nothing in it.*these robots were: alice, bob"):
            live_of(path, "carol", "")

    def test_a_description_that_makes_no_sense_is_none(self, tmp_path):
        messages = [("/pioneer/recording", String("[1"), 1.0), ("/pioneer/cmd_vel", twist(0.1), 1.0)]
        path = write(tmp_path / "odd.bag", messages)
        assert live_of(path, "", "")._parameters == {}


class TestVerdict:
    live = {"decision": [(1.0 + 0.1 * n, decision(1.0 + 0.1 * n)) for n in range(30)],
            "cmd_vel": [(1.0 + 0.1 * n, twist(0.1)) for n in range(30)],
            "cmd_motor_state": [(0.5, MotorState(1))]}

    def test_the_same(self):
        verdict = rerun.compare(self.live, self.live, 0.95)
        assert verdict.same and len(verdict.sentences) == 3

    def test_decisions_decide(self):
        faster = dict(self.live, cmd_vel=[(time, twist(0.5)) for time, _ in self.live["cmd_vel"]])
        assert rerun.compare(self.live, faster, 0.95).same, "how a velocity came through is the line's matter"
        other = dict(self.live, decision=[(time, decision(time, angular=1e-12)) for time, _ in self.live["decision"]])
        assert not rerun.compare(self.live, other, 0.95).same

    def test_without_decisions_velocities_do(self):
        live = {"cmd_vel": self.live["cmd_vel"]}
        assert rerun.compare(live, live, 0.95).same
        assert not rerun.compare(live, {"cmd_vel": [(time, twist(0.5)) for time, _ in live["cmd_vel"]]}, 0.95).same
        assert not rerun.compare(live, {}, 0.95).same

    def test_whether_motors_were_asked_for_is_told_and_not_judged(self):
        live = {"cmd_vel": self.live["cmd_vel"], "cmd_motor_state": self.live["cmd_motor_state"]}
        verdict = rerun.compare(live, {"cmd_vel": live["cmd_vel"]}, 0.95)
        assert verdict.same and any("cmd_motor_state: different" in sentence for sentence in verdict.sentences)

    def test_decisions_that_there_were_none_of_live_do_not_decide(self):
        live = {"cmd_vel": self.live["cmd_vel"]}
        verdict = rerun.compare(live, self.live, 0.95)
        assert verdict.same and any(sentence.startswith("no decisions live") for sentence in verdict.sentences)
        faster = dict(self.live, cmd_vel=[(time, twist(0.5)) for time, _ in self.live["cmd_vel"]])
        assert not rerun.compare(live, faster, 0.95).same


@pytest.mark.parametrize("options", ["-l", "-r 2 --loop"])
def test_there_is_no_end_to_a_loop(bag, options):
    with pytest.raises(UsageError, match="leave -l out"):
        rerun.Rerun(parser_of("", "", rerun.OPTIONS).parse_args([bag, "--options=" + options]))


@pytest.mark.parametrize("enough", ["1.1", "-0.1", "nan", "much"])
def test_a_share_that_is_none(bag, enough):
    with pytest.raises(UsageError, match="enough: '%s' is not legal: give a number from 0 to 1" % enough):
        rerun.Rerun(parser_of("", "", rerun.OPTIONS).parse_args([bag, "--enough=" + enough]))


@pytest.mark.parametrize("enough", ["0", "1"])
def test_a_share_may_be_none_or_all(bag, enough):
    rerun.Rerun(parser_of("", "", rerun.OPTIONS).parse_args([bag, "--enough=" + enough]))


class TestARobotThatComesMeanwhile:
    @pytest.fixture
    def look_out(self, bag, monkeypatch):
        def look_out(*others):
            monkeypatch.setattr(rerun, "possible_robots", lambda: list(others))
            rerun.Rerun(parser_of("", "", rerun.OPTIONS).parse_args([bag]))._look_out()
        return look_out

    def test_ends_it(self, look_out):
        with pytest.raises(UsageError, match="/alice/p2os .* is on this master"):
            look_out("/alice/p2os (/alice/cmd_vel)", rerun.PLAYER + " (/pioneer/motor_state)")

    def test_player_and_program_are_none(self, look_out):
        look_out(rerun.PLAYER + " (/pioneer/motor_state)", PROGRAM + " (/pioneer/cmd_vel)")
