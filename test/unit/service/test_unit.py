"""The unit file of a service: legal for systemd, and with words that systemd and bash leave as they are."""

import re
import shutil
import subprocess

import pytest

from pioneer_control.errors import UsageError
from pioneer_control.service.unit import LOCAL_MASTER, Service, command, environment, master_command, unit_texts, word

LAUNCH = ("pioneer_control", "pioneer.launch", "port:=/dev/pioneer")
PLAIN = Service(LAUNCH, "ada", "/opt/ws/devel/setup.bash")
HOSTILE = "a:=%n $HOME ${X} \"q\" 'r' \\n ; & | `id` #"


def unit_text(service, name="pioneer"):
    return unit_texts(service)["/etc/systemd/system/%s.service" % name]


def settings(text):
    """Return the settings of a unit file: name and value of each line, by section."""
    found, section = {}, None
    for line in text.splitlines():
        if line.startswith("["):
            section = found.setdefault(line, [])
        elif line and not line.startswith("#"):
            section.append(tuple(line.split("=", 1)))
    return found


def systemd_words(line):
    """Return the words of a command line as systemd.service(5) says it reads them: quotes, escapes, %% and $$."""
    words = re.findall(r'"((?:[^"\\]|\\.)*)"|(\S+)', line)
    return [re.sub(r"\\(.)", r"\1", quoted or plain).replace("%%", "%").replace("$$", "$") for quoted, plain in words]


def test_what_a_unit_file_says():
    service = settings(unit_text(PLAIN))["[Service]"]
    for line in (("User", "ada"), ("Restart", "on-failure"), ("RestartPreventExitStatus", "2"),
                 ("KillSignal", "SIGTERM"), ("KillMode", "mixed"), ("SupplementaryGroups", "dialout"),
                 ("Environment", '"ROS_MASTER_URI=%s"' % LOCAL_MASTER), ("Environment", '"ROS_HOSTNAME=localhost"'),
                 ("Environment", '"ROS_LOG_DIR=/var/log/pioneer"'), ("LogsDirectory", "pioneer")):
        assert line in service


def test_the_master_has_a_unit_of_its_own_and_goes_with_the_last_that_needs_it():
    assert dict(settings(unit_text(PLAIN))["[Unit]"])["Requires"] == "pioneer-master.service"
    unit = settings(unit_text(PLAIN._replace(master="http://localhost:11999"), "pioneer-master"))
    assert ("StopWhenUnneeded", "yes") in unit["[Unit]"] and "[Install]" not in unit
    assert tuple(systemd_words(dict(unit["[Service]"])["ExecStart"]))[-4:] == ("/usr/bin/env", "roscore", "-p", "11999")


@pytest.mark.parametrize("master, hostname, address, here", [
    ("http://localhost:11311", "robot1", "", True), ("http://robot1:11311", "robot1", "", True),
    ("http://10.0.0.2:11311/", "localhost", "10.0.0.2", True), ("http://desk:11311", "robot1", "", False),
    ("http://robot:11311", "robot1", "", False)])
def test_a_master_of_another_computer_has_none(master, hostname, address, here):
    service = PLAIN._replace(master=master, hostname=hostname, address=address)
    assert (service.unit_names == ("pioneer-master", "pioneer")) == here == (len(unit_texts(service)) == 2)
    assert ("Requires=" in unit_text(service)) == here


def test_it_waits_for_no_network_and_tries_for_ever():
    sections = settings(unit_text(PLAIN))
    assert ("StartLimitIntervalSec", "0") in sections["[Unit]"]
    assert "network" not in " ".join("=".join(pair) for pair in sections["[Unit]"])


@pytest.mark.parametrize("service, own", [
    (PLAIN._replace(hostname="robot1"), ("ROS_HOSTNAME", "robot1")),
    (PLAIN._replace(address="192.168.1.20"), ("ROS_IP", "192.168.1.20")),
])
def test_the_name_that_others_reach_it_by_stands_alone(service, own):
    names = [pair for pair in environment(service) if pair[0] in ("ROS_HOSTNAME", "ROS_IP")]
    assert names == [own]


@pytest.mark.parametrize("setup", ["", "/opt/ws/devel/setup.bash", "/opt/a %h \"$b\" c/setup.bash"])
def test_systemd_starts_the_command_word_by_word(setup):
    service = PLAIN._replace(setup=setup, launch=(*LAUNCH, HOSTILE))
    line = dict(settings(unit_text(service))["[Service]"])["ExecStart"]
    assert tuple(systemd_words(line)) == command(service)
    line = dict(settings(unit_text(service, "pioneer-master"))["[Service]"])["ExecStart"]
    assert tuple(systemd_words(line)) == master_command(service)


def test_bash_passes_each_word_on_and_keeps_them_from_the_setup_file(tmp_path):
    setup = tmp_path / "setup 1.bash"
    setup.write_text('export SEEN="$#"\n')
    words = command(PLAIN._replace(setup=str(setup)))
    done = subprocess.run([*words[:4], "/bin/sh", "-c", 'printf "%s\\n" "$SEEN" "$@"', "-", HOSTILE, ""],
                          stdout=subprocess.PIPE, universal_newlines=True, check=True)
    assert done.stdout == "0\n%s\n\n" % HOSTILE


def test_without_the_setup_file_nothing_starts(tmp_path):
    words = command(PLAIN._replace(setup=str(tmp_path / "none.bash")))
    done = subprocess.run([*words[:4], "/bin/echo", "started"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    assert done.returncode and not done.stdout


@pytest.mark.parametrize("wrong, words", [
    (dict(name="a/b"), "--name 'a/b'"), (dict(name="../ssh"), "--name"), (dict(name=""), "--name"),
    (dict(name="Pioneer"), "--name 'Pioneer'"), (dict(name="a" * 32), "31 at most"),
    (dict(name="pioneer-master"), "--name 'pioneer-master': what ends in -master"),
    (dict(launch=()), "no launch file"), (dict(launch=("a\nExecStart=x",)), "control character in 'a\\nExecStart=x'"),
    (dict(user="ada\nUser=root"), "control character"), (dict(setup="devel/setup.bash"), "whole path"),
    (dict(hostname="-x"), "--hostname '-x'"), (dict(hostname="a b"), "--hostname"),
    (dict(address="robot1"), "--ip 'robot1'"), (dict(address="1.2.3.256"), "--ip"),
    (dict(master="http://a:0"), "--master 'http://a:0'"), (dict(master="http://a:65536"), "--master"),
    (dict(master="localhost:11311"), "--master"), (dict(master="http://a:1\nX=y"), "--master"),
])
def test_what_is_not_legal_is_named(wrong, words):
    with pytest.raises(UsageError, match=re.escape(words)):
        unit_text(PLAIN._replace(**wrong))


def test_a_word_is_never_read_by_systemd():
    assert word('%n $HOME "\\') == '"%%n $$HOME \\"\\\\"'


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="there is no systemd-analyze here")
@pytest.mark.parametrize("launch, expected", [(LAUNCH, ""), ((*LAUNCH, HOSTILE), ""), (None, "Unknown key")])
def test_systemd_finds_no_fault_with_it(tmp_path, launch, expected):
    setup = tmp_path / "a b" / "setup.bash"
    setup.parent.mkdir()
    setup.write_text("")
    paths = []
    for name, text in unit_texts(PLAIN._replace(user="root", setup=str(setup), launch=launch or LAUNCH)).items():
        paths.append(tmp_path / name.rpartition("/")[2])
        paths[-1].write_text(text if launch else text.replace("RestartSec", "RestartSecs"))
    done = subprocess.run(["systemd-analyze", "verify", "--man=no", "--recursive-errors=no", *map(str, paths)],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)
    if "Failed to initialize" in done.stdout:
        pytest.skip(done.stdout.strip())
    assert ("pioneer" in done.stdout) == bool(expected) and expected in done.stdout
