"""The rules for `rosbag fix`, with the real commands, on bags whose messages have the names of p2os."""

import pathlib
import subprocess
import xml.etree.ElementTree as ElementTree

import pytest
import rosbag
from rosbag.migration import MessageMigrator
from std_msgs.msg import Header

import bag_factory as make
from old_messages import OLD_PACKAGES, VALUES, old_message, serialized
from pioneer_control import msg

ROOT = pathlib.Path(__file__).resolve().parents[3]
RULES = ROOT / "migration_rules" / "p2os.bmr"
TOPICS = [(package, name) for package in OLD_PACKAGES for name in VALUES]


def rosbag_knows_rules():
    """Return whether this rosbag can use rules. With Python 3.13, rosbag 1.17 (Debian 13) cannot: it looks in locals()
    for a class that it has just executed, and does not find it.
    """
    try:
        MessageMigrator([], plugins=False).make_update_rule(Header, Header)
    except KeyError:
        return False
    return True


pytestmark = pytest.mark.skipif(not rosbag_knows_rules(),
                                reason="this rosbag can do nothing with rules, whoever's: docs/old-bags.md")


@pytest.fixture(scope="module")
def migrator():
    """rosbag's own migrator with these rules and no others."""
    return MessageMigrator([str(RULES)], plugins=False)


@pytest.fixture
def run():
    """Run a command of rosbag. Returns its exit code and its output."""
    def rosbag_command(*arguments):
        done = subprocess.run(["rosbag", *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              stdin=subprocess.DEVNULL, text=True)
        return done.returncode, done.stdout
    return rosbag_command


def content(path):
    """Return (topic, type, bytes, time, latching) of every message of a bag, in order."""
    with rosbag.Bag(str(path)) as bag:
        return [(topic, raw[0], raw[1], time.to_nsec(), connection["latching"])
                for topic, raw, time, connection in bag.read_messages(raw=True, return_connection_header=True)]


def mixed():
    """Yield (topic, message, seconds): all nine messages of each old package, with ours and others between them."""
    seconds = 10.0
    for repeat in range(2):
        for package, name in TOPICS:
            yield "/%s/%s" % (package, name), old_message(name, package), seconds
            yield "/ours/sonar", make.sonar([1.0, 2.0]), seconds + 0.01
            yield "/others", Header(frame_id="else"), seconds + 0.02
            seconds += 0.05


class TestRules:
    def test_there_are_rules_for_what_p2os_has_and_for_nothing_else(self, migrator):
        rules = [rule for chain in migrator.rulechains.values() for rule in [*chain.chain, chain.rename]]
        found = {(rule.old_type, rule.new_type) for rule in rules}
        chains = list(zip((*OLD_PACKAGES, "pioneer_control"), (*OLD_PACKAGES, "pioneer_control")[1:]))
        expected = {("%s/%s" % (old, name), "%s/%s" % (new, name)) for name in VALUES for old, new in chains}
        assert len(rules) == len(found) and found == expected
        assert migrator.all_rules_valid()

    @pytest.mark.parametrize("name", VALUES)
    def test_the_last_definition_is_the_messages_own(self, migrator, name):
        ours = getattr(msg, name)
        last = migrator.rulechains["p2os_msgs/%s" % name].rename
        assert (last.new_full_text, last.new_md5sum) == (ours._full_text, ours._md5sum)

    @pytest.mark.parametrize("package, name", TOPICS)
    def test_each_definition_names_the_parts_of_its_own_package(self, migrator, package, name):
        rule = migrator.rulechains["%s/%s" % (package, name)].rename
        assert "pioneer_control" not in rule.old_full_text
        made = make.message_class(name, package)
        assert rule.old_class._full_text == made._full_text or name in ("SonarArray", "BatteryState")
        assert rule.old_md5sum == made._md5sum

    @pytest.mark.parametrize("package, name", TOPICS)
    def test_a_rule_keeps_every_value(self, migrator, package, name):
        """rosbag applies no rule when the md5 is the same. A user's message may contain one of these messages, and then
        needs the rule.
        """
        rule = migrator.rulechains["%s/%s" % (package, name)].rename
        made = rule.apply(old_message(name, package))
        assert made._type == rule.new_type and serialized(made) == serialized(old_message(name, package))

    def test_rosbag_finds_them_by_itself_where_rosdep_is_set_up(self, monkeypatch):
        """Without rosdep, rosbag does not know which packages depend on rosbag."""
        import rospkg
        monkeypatch.setattr(rospkg.RosPack, "get_depends_on", lambda self, name,
                            implicit=True: ["pioneer_control"] * (name == "rosbag"))
        assert set(MessageMigrator().rulechains) == {"%s/%s" % (package, name) for package, name in TOPICS}

    def test_another_definition_has_no_rule(self, migrator):
        """The message has the name of an old message, but one field more."""
        import genpy.dynamic
        name = "p2os_msgs/MotorState"
        other = genpy.dynamic.generate_dynamic(name, "int32 state\nint32 more\n")[name]
        path = migrator.find_path(other, migrator.find_target(other))
        assert [node.rule.valid for node in path].count(False) == 1


class TestCommands:
    @pytest.mark.parametrize("compression", ["none", "bz2"])
    def test_fix(self, run, tmp_path, compression):
        old = make.write_bag(tmp_path / "old.bag", mixed(), compression,
                             latched=("/p2os_msgs/MotorState", "/ours/sonar"))
        code, said = run("fix", old, tmp_path / "new.bag", RULES)
        assert (code, said.splitlines()) == (0, ["Bag migrated successfully."])
        before, after = content(old), content(tmp_path / "new.bag")
        assert len(before) == 2 * 3 * len(TOPICS)
        wanted = [(topic, "pioneer_control/" + kind.split("/")[1] if kind.startswith("p2os") else kind, *rest)
                  for topic, kind, *rest in before]
        assert after == wanted
        assert {latching for topic, _, _, _, latching in after
                if topic in ("/p2os_msgs/MotorState", "/ours/sonar")} == {b"1"}
        with rosbag.Bag(str(tmp_path / "new.bag")) as bag:
            read = [(topic.split("/"), message)
                    for topic, message, _ in bag.read_messages() if topic.startswith("/p2os")]
        expected = [str(old_message(name, package)) for (_, package, name), _ in read]
        assert [str(message) for _, message in read] == expected

    def test_check(self, run, tmp_path):
        old = make.write_bag(tmp_path / "old.bag", mixed())
        code, said = run("check", old, RULES)
        assert code == 0 and "All rules defined" in said and "rules missing" not in said
        code, said = run("check", old)
        assert code == 0 and "rules missing" in said, "it exits with 0 either way: what it says is what counts"

    def test_the_header_of_the_first_releases(self, run, tmp_path):
        """In the bags of the first releases, Header belongs to roslib."""
        import genpy.dynamic
        text = make.message_class("SonarArray", "p2os_driver")._full_text.replace("std_msgs/Header", "roslib/Header")
        sonar = genpy.dynamic.generate_dynamic("p2os_driver/SonarArray", text)["p2os_driver/SonarArray"](ranges=[1.0])
        old = tmp_path / "old.bag"
        with rosbag.Bag(str(old), "w") as bag:
            header = dict(topic="/sonar", type=sonar._type, md5sum=sonar._md5sum, message_definition=text, latching="0")
            bag.write("/sonar", sonar, connection_header=header)
        assert run("fix", old, tmp_path / "new.bag", RULES)[0] == 0
        assert [(kind, data) for _, kind, data, _, _ in content(tmp_path / "new.bag")] == [
            ("pioneer_control/SonarArray", serialized(sonar))]

    def test_a_type_that_nobody_knows(self, run, tmp_path):
        """`rosbag fix` stops at an unknown type and leaves an empty file. With --force it keeps the messages unchanged.
        """
        messages = [("/sonar", old_message("SonarArray", "p2os_msgs"), 1.0),
                    ("/mine", make.message_class("DIO", "my_msgs")(), 2.0)]
        old = make.write_bag(tmp_path / "old.bag", messages)
        code, said = run("fix", old, tmp_path / "new.bag", RULES)
        assert code == 1 and "my_msgs/DIO" in said and (tmp_path / "new.bag").stat().st_size == 0
        assert run("fix", "--force", old, tmp_path / "forced.bag", RULES)[0] == 0
        kinds = [kind for _, kind, *_ in content(tmp_path / "forced.bag")]
        assert kinds == ["pioneer_control/SonarArray", "my_msgs/DIO"]


def test_package_xml_tells_rosbag_where_they_are():
    """rosbag finds the rules in package.xml by itself where rosdep is set up."""
    manifest = ElementTree.parse(ROOT / "package.xml").getroot()
    assert [element.get("migration_rule_file")
            for element in manifest.findall("export/rosbag")] == [RULES.relative_to(ROOT).as_posix()]
    assert "rosbag" in [element.text for element in manifest.findall("exec_depend")]


def test_they_are_installed():
    installed = [line for line in (ROOT / "CMakeLists.txt").read_text().splitlines()
                 if line.startswith("install(DIRECTORY")]
    assert any(RULES.parent.name in line.split() for line in installed)
