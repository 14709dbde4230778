"""A launch file is checked before it may run at boot, and the end of a run says whether starting again can help."""

import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import time

import pytest
import rosgraph
from roslaunch.config import load_config_default

from pioneer_control.errors import UsageError
from pioneer_control.service import command_line
from pioneer_control.service.installed import InstalledFiles
from pioneer_control.service.launched import checked, main, prune
from pioneer_control.service.unit import Service, unit_texts

LIMIT = 60.0
DRIVER = '<node pkg="pioneer_control" type="p2os_driver" name="p2os" required="true">%s</node>'


def launch_file(folder, body):
    path = folder / "x.launch"
    path.write_text("<launch>%s</launch>" % body)
    return str(path)


@pytest.fixture
def environment(tmp_path):
    """The environment of a run with a master of its own."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    found = dict(os.environ, ROS_MASTER_URI="http://localhost:%d" % port, ROS_HOSTNAME="localhost",
                 ROS_LOG_DIR=str(tmp_path / "logs"), ROS_HOME=str(tmp_path), PYTHONUNBUFFERED="1")
    with subprocess.Popen(["rosmaster", "--core", "-p", str(port)], env=found, stdout=subprocess.DEVNULL) as master:
        server, end = rosgraph.Master("/test", master_uri=found["ROS_MASTER_URI"]), time.monotonic() + LIMIT
        while True:
            try:
                server.setParam("/run_id", "1")     # as roscore does
                break
            except ConnectionRefusedError:      # it is about to start
                assert time.monotonic() < end
                time.sleep(0.05)
        yield found
        master.send_signal(signal.SIGINT)


@pytest.mark.parametrize("words", [
    ("pioneer_control", "pioneer.launch"), ("pioneer_control", "navigate.launch", "sim:=true", "world:=office"),
    ("pioneer_control", "record.launch", "bag:=/tmp/x.bag"), ("pioneer_control", "web.launch")])
def test_our_launch_files_may_run_at_boot(words):
    launch = checked(words)
    assert os.path.isabs(launch.file) and list(launch.arguments) == [word for word in words if ":=" in word]
    assert launch.others == []


@pytest.mark.parametrize("words, wrong", [
    ((), "give one launch file"),
    (("pioneer_control", "pioneer.launch", "more"), "'more' makes no sense"),
    (("pioneer_control", "none.launch"), "none.launch"),
    (("no_such_package", "none.launch"), "none.launch"),
    (("pioneer_control", "pioneer.launch", "prot:=/dev/ttyS0"), "did you mean port"),
    (("pioneer_control", "demo.launch", "bag:=/tmp/x.bag"), "rosPioneer2.py switches the motors on"),
])
def test_what_may_not_is_named(words, wrong):
    with pytest.raises(UsageError, match=re.escape(wrong)):
        checked(words)


@pytest.mark.parametrize("inside", [
    '<param name="enable_motors_on_start" value="true"/>',
    '<rosparam>enable_motors_on_start: true</rosparam>',
])
def test_motors_on_at_the_start_are_refused_wherever_that_stands(tmp_path, inside, capsys):
    assert main(["--check", launch_file(tmp_path, DRIVER % inside)]) == 2
    assert "/p2os/enable_motors_on_start is True" in capsys.readouterr().err


@pytest.mark.parametrize("body", ["<node", '<include file="/none"/>',
                                  '<arg name="a"/><param name="b" value="$(arg a)"/>',
                                  '<node pkg="x"/>'])
def test_a_launch_file_with_a_mistake_is_refused(tmp_path, body, capsys):
    assert main(["--check", launch_file(tmp_path, body)]) == 2
    assert "service: " in capsys.readouterr().err


def test_a_wrong_parameter_ends_with_2(tmp_path, environment):
    path = launch_file(tmp_path, DRIVER % '<param name="baud" value="12345"/>')
    done = subprocess.run([sys.executable, "-m", "pioneer_control.service", path], env=environment, timeout=LIMIT,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)
    assert done.returncode == 2 and "baud" in done.stdout


def test_a_parameter_that_somebody_set_at_the_master_is_refused_too(tmp_path, environment):
    master = rosgraph.Master("/test", master_uri=environment["ROS_MASTER_URI"])
    master.setParam("/p2os/enable_motors_on_start", True)
    done = subprocess.run([sys.executable, "-m", "pioneer_control.service", launch_file(tmp_path, DRIVER % "")],
                          env=environment, timeout=LIMIT, stderr=subprocess.PIPE, universal_newlines=True)
    assert done.returncode == 2 and "/p2os/enable_motors_on_start is True" in done.stderr


@pytest.mark.parametrize("what, code", [("driver", 1), ("service", 0)])
def test_a_driver_that_is_killed_ends_with_1_and_an_ordered_end_with_0(tmp_path, environment, what, code):
    path = launch_file(tmp_path, DRIVER % '<param name="port" value="%s"/>' % (tmp_path / "none"))
    with subprocess.Popen([sys.executable, "-m", "pioneer_control.service", path], env=environment,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True) as running:
        for line in running.stdout:
            found = re.search(r"process\[p2os-\d+\]: started with pid \[(\d+)\]", line)
            if found:
                break
        master, end = rosgraph.Master("/test", master_uri=environment["ROS_MASTER_URI"]), time.monotonic() + LIMIT
        # While roslaunch starts a node, a signal holds it up for 20 s (seen with 1.15.15): so wait for the node.
        while "/p2os" not in str(master.getSystemState()):
            assert time.monotonic() < end
            time.sleep(0.02)
        pid, number = (int(found.group(1)), signal.SIGKILL) if what == "driver" else (running.pid, signal.SIGTERM)
        os.kill(pid, number)
        rest = running.communicate(timeout=LIMIT)[0]
    assert running.returncode == code, rest


def test_only_the_newest_logs_stay(tmp_path):
    for age in range(6):
        (tmp_path / str(age)).mkdir()
        (tmp_path / str(age) / "x.log").write_text("x")
        os.utime(str(tmp_path / str(age)), (1000 - age, 1000 - age))
    (tmp_path / "latest").symlink_to(tmp_path / "0")
    (tmp_path / "file").write_text("x")
    prune(tmp_path, 2)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0", "1", "file", "latest"]
    prune(tmp_path / "none", 2)


def test_print_shows_the_files_and_writes_none(capsys):
    assert command_line.main_install(["--print", "--user", "ada", "--hostname", "robot1"]) == 0
    shown = capsys.readouterr().out
    for words in ("# --- /etc/systemd/system/pioneer.service", "User=ada", "ROS_HOSTNAME=robot1",
                  "setup.bash", "pioneer_control pioneer.launch port:=/dev/pioneer", 'SYMLINK+="pioneer"'):
        assert words in shown
    assert command_line.main_install(["--print", "--user", "ada", "--no-udev", "--setup", ""]) == 0
    shown = capsys.readouterr().out
    assert "SYMLINK" not in shown and "ExecStart=/usr/bin/python3 -m pioneer_control.service" in shown


def test_print_checks_the_launch_file(capsys):
    assert command_line.main_install(["--print", "--user", "ada", "pioneer.launch", "prt:=x"]) == 2
    said = capsys.readouterr()
    assert "has no argument 'prt'; did you mean port?" in said.err and not said.out


def test_two_services_have_two_masters(monkeypatch, tmp_path):
    """At one master the second driver would end the first, which has the same name."""
    texts = unit_texts(Service(("x.launch",), "root"))
    monkeypatch.setattr(command_line, "UNIT", str(tmp_path / "%s.service"))
    monkeypatch.setattr(command_line, "check", lambda service: pytest.fail("it goes on"))
    for path, text in texts.items():
        (tmp_path / os.path.basename(path)).write_text(text)
    installed = InstalledFiles("second", str(tmp_path / "root"))
    second = Service(("x.launch",), "root", name="second")
    with pytest.raises(UsageError, match="pioneer-master.service starts a master at port 11311, too: give another"):
        command_line.install(second, {}, installed)
    for other in (second._replace(master="http://localhost:11312"), second._replace(master="http://desk:11311"),
                  second._replace(name="pioneer")):
        with pytest.raises(pytest.fail.Exception, match="it goes on"):
            command_line.install(other, {}, installed)


def test_a_service_whose_files_somebody_removed_is_uninstalled_all_the_same(monkeypatch, capsys, tmp_path):
    """systemctl disable refuses a unit that has no file."""
    unit = tmp_path / "pioneer.service"
    monkeypatch.setattr(command_line, "UNIT", str(tmp_path / "%s.service"))
    installed = InstalledFiles("pioneer", str(tmp_path / "root"))
    monkeypatch.setattr(InstalledFiles, "listed", {str(unit): "", str(tmp_path / "pioneer-master.service"): ""})
    said = []
    monkeypatch.setattr(command_line.subprocess, "run", lambda words, **_: said.append(tuple(words)))
    monkeypatch.setattr(command_line, "call", lambda *words: said.append(words))
    unit.write_text("")
    command_line.uninstall("pioneer", installed)
    assert ("systemctl", "stop", "pioneer", "pioneer-master") in said
    assert ("systemctl", "disable", "--quiet", "--now", "pioneer") in said
    unit.unlink()
    said.clear()
    command_line.uninstall("pioneer", installed)
    assert not any("disable" in words for words in said)


def test_without_root_the_command_for_sudo_is_told(monkeypatch, capsys):
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    monkeypatch.setenv("CMAKE_PREFIX_PATH", "/opt/a b")
    assert command_line.main_install(["--user", "ada", "pioneer.launch", "world:=x y"]) == 1
    said = capsys.readouterr().err
    assert "only root" in said and "sudo env 'CMAKE_PREFIX_PATH=/opt/a b'" in said and "'world:=x y'" in said
    assert command_line.main_uninstall([]) == 1 and "only root" in capsys.readouterr().err


def test_nobody_is_made_root_by_accident(monkeypatch, capsys):
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    monkeypatch.delenv("SUDO_USER", raising=False)
    assert command_line.main_install(["--print"]) == 2 and "--user" in capsys.readouterr().err
    monkeypatch.setenv("SUDO_USER", "ada")
    assert command_line.main_install(["--print"]) == 0 and "User=ada\n" in capsys.readouterr().out


def test_where_systemd_does_not_run_nothing_is_written(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    monkeypatch.setattr(command_line, "SYSTEMD", str(tmp_path / "none"))
    assert command_line.main_install(["--user", "root"]) == 1
    assert command_line.main_uninstall(["--name", "x"]) == 1
    assert capsys.readouterr().err.count("not run by systemd") == 2


@pytest.mark.parametrize("given", [["--name", "a b"], ["--ip", "robot1"], ["--master", "x"], ["--setup", "rel"]])
def test_a_wrong_option_ends_with_2(given, capsys):
    assert command_line.main_install(["--print", "--user", "ada", *given]) == 2
    assert given[1] in capsys.readouterr().err


@pytest.mark.parametrize("given, user", [(["user:=ada"], "ada"), ([], None)])
def test_a_fleet_has_a_driver_on_each_robots_computer(given, user):
    """Without a user, roslaunch leaves it to the configuration of ssh."""
    path = str(pathlib.Path(__file__).resolve().parents[3] / "launch" / "fleet_machines.launch")
    config = load_config_default([(path, ["robots:=robot1 robot2 robot3", "port:=/dev/ttyS0", *given])], None,
                                 verbose=False, assign_machines=False)
    assert [(node.namespace, node.machine_name, node.type) for node in config.nodes] == [
        ("/%s/" % name, name, "p2os_driver") for name in ("robot1", "robot2", "robot3")]
    assert {name: (machine.address, machine.user, machine.env_loader) for name, machine in config.machines.items()
            if name} == {name: (name, user, "/usr/local/bin/pioneer-env") for name in ("robot1", "robot2", "robot3")}
    assert config.params["/robot3/p2os/frame_prefix"].value == "robot3/"
    assert {config.params["/%s/p2os/port" % name].value for name in ("robot1", "robot2")} == {"/dev/ttyS0"}
