"""`./pioneer` with stand-ins for apt, sudo, catkin and roslaunch: what it calls, what it prints, how it ends."""

import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import time
import xml.etree.ElementTree as ElementTree

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Each notes how it was called. catkin_make leaves a workspace whose Python finds a stand-in for the drawing of
# pictures.
TOOLS = {
    "dpkg-query": 'for name in $INSTALLED; do echo "installed $name"; done',
    "apt-get": 'echo "apt-get $*" >>"$CALLS"; [ "${*: -1}" != "$UNAVAILABLE" ] || { echo "E: Unable to locate"; exit '
               '100; }',
    "sudo": 'echo "sudo $*" >>"$CALLS"; [ -z "$REFUSING" ] || exit 1; [ "$1" = -v ] || exec "$@"',
    "id": "echo ${USER_ID:-0}",
    "catkin_make": r'''
        echo "catkin_make $* PYTHONPATH=$PYTHONPATH FOREIGN=$FOREIGN" >>"$CALLS"
        [ -z "$BROKEN_BUILD" ] || { echo "error: broken"; exit 2; }
        mkdir -p "$2/devel/pioneer_control/bags"
        touch "$2/devel/pioneer_control/__init__.py" "$2/devel/pioneer_control/bags/__init__.py"
        echo "import sys; open(sys.argv[3], 'w').write('picture')" >"$2/devel/pioneer_control/bags/draw.py"
        echo "import sys; print('the page of', sys.argv[1:])" >"$2/devel/pioneer_control/web.py"
        echo "export PYTHONPATH='$2/devel'" >"$2/devel/setup.bash"''',
    "roslaunch": r'''
        echo "roslaunch $* $ROS_MASTER_URI" >>"$CALLS"
        echo "$PIONEER_WEB_KEY" >"$CALLS.key"
        for argument; do case $argument in bag:=*) bag=${argument#bag:=} ;; esac; done
        trap 'echo "|INFO| It stops."; echo bag >"$bag"; exit' INT
        echo "SUMMARY"; echo "|INFO| looking for a robot on /tmp/line"
        [ -n "$MISTAKEN" ] || echo "|INFO| wander, for 40 s at most"; echo "|INFO| It drives."
        case $HANGING in 1) while :; do read -rt 1 <> <(:); done ;; esac
        [ -z "$DYING" ] || echo "[p2os-3] process has died [pid 1, exit code 2, cmd p2os_driver]"
        [ -n "$WITHOUT_BAG" ] || echo bag >"$bag"''',
    "rostest": ":",
    "awk": '[ -n "$USERS_AT" ] || exec /usr/bin/awk "$@"; [[ "$*" != *"$PORT_OF_USERS"* ]] || echo $USERS_AT',
    "getent": '[ -z "$NAMELESS" ] || exit 2; echo 127.0.1.1 computer',
}


class Clone:
    """A directory of any name, with a copy of what the script needs of the repository."""

    def __init__(self, folder, name):
        self.folder, self.tools = folder / name, folder / "tools"
        self.folder.mkdir()
        self.tools.mkdir()
        shutil.copy(str(ROOT / "pioneer"), str(self.folder))
        shutil.copy(str(ROOT / "package.xml"), str(self.folder))
        (self.folder / "launch").mkdir()
        shutil.copy(str(ROOT / "launch" / "demo.launch"), str(self.folder / "launch"))
        for name, body in TOOLS.items():
            (self.tools / name).write_text("#!/bin/bash\n" + body + "\n")
            (self.tools / name).chmod(0o755)
        self.calls_file = folder / "calls"
        self.environment = {
            "PATH": os.environ["PATH"], "HOME": str(folder), "CALLS": str(self.calls_file),
            "PIONEER_TEST_TOOLS": str(self.tools),
            "PIONEER_ROS_PREFIXES": "", "INSTALLED": " ".join(debian_packages()),
            "USERS_AT": "nobody", "PORT_OF_USERS": "no port"}       # every port is free, whatever runs on this machine

    @property
    def calls(self):
        return self.calls_file.read_text().splitlines() if self.calls_file.exists() else []

    def start(self, *arguments, before=None, stdin=None, **environment):
        return subprocess.Popen(
            [str(self.folder / "pioneer"), *arguments], env=dict(self.environment, **environment), preexec_fn=before,
            stdin=stdin, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)

    def run(self, *arguments, **environment):
        """Run to the end. Returns (exit status, everything printed)."""
        with self.start(*arguments, **environment) as process:
            output = process.communicate(timeout=60)[0]
        return process.returncode, output


def debian_packages():
    text = (ROOT / "pioneer").read_text()
    return re.search(r"^packages=\((.*?)^\)", text, re.MULTILINE | re.DOTALL).group(1).split()


def named_by_package_xml():
    manifest = ElementTree.parse(str(ROOT / "package.xml")).getroot()
    return {element.text for element in manifest if element.tag.endswith("depend")}


@pytest.fixture
def clone(tmp_path):
    return Clone(tmp_path, "clone")


def test_help_names_the_commands(clone):
    status, output = clone.run("help")
    assert status == 0
    assert all("./pioneer " + command in output for command in ("run", "test", "shell"))


def test_it_is_found_by_a_link_and_without_a_slash(clone, tmp_path):
    (tmp_path / "link").symlink_to(clone.folder / "pioneer")
    for command, place in (([str(tmp_path / "link"), "shell", "true"], tmp_path),
                           (["bash", "pioneer", "shell", "true"], clone.folder)):
        assert subprocess.run(command, cwd=str(place), env=clone.environment, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL).returncode == 0
    assert all("--source %s " % clone.folder in call for call in clone.calls)


def test_an_unknown_command_fails(clone):
    status, output = clone.run("runn")
    assert status == 1
    assert "no such command: runn" in output


# --- Installing ---

def test_nothing_missing_leaves_apt_alone(clone):
    assert clone.run("shell", "true")[0] == 0
    assert [call.split()[0] for call in clone.calls] == ["catkin_make"]


def test_what_is_missing_is_installed_and_no_more(clone):
    installed = " ".join(set(debian_packages()) - {"cmake", "python3-tf"})
    assert clone.run("shell", "true", INSTALLED=installed)[0] == 0
    update, install = clone.calls[:2]
    assert update.endswith(" update")
    assert install.endswith("install -y --no-install-recommends cmake python3-tf")


def test_a_package_that_apt_does_not_have_is_said_loudly(clone):
    status, output = clone.run("shell", "true", INSTALLED=" ".join(set(debian_packages()) - {"rosbash"}),
                               UNAVAILABLE="rosbash")
    assert status == 1
    assert "E: Unable to locate" in output and "apt-install.log" in output
    assert not [call for call in clone.calls if call.startswith("catkin_make")]


def test_a_user_installs_with_sudo(clone):
    assert clone.run("shell", "true", INSTALLED="", USER_ID="1000")[0] == 0
    assert clone.calls[0] == "sudo -v"
    assert [call for call in clone.calls if call.startswith("sudo env DEBIAN_FRONTEND=noninteractive apt-get")]


def test_a_user_who_may_not_is_told_what_is_missing(clone):
    status, output = clone.run("shell", "true", INSTALLED="", USER_ID="1000", REFUSING="1")
    assert status == 1
    assert "cmake" in output and "sudo may not install them" in output
    assert not [call for call in clone.calls if call.startswith("apt-get")]


# --- ROS under another prefix ---

@pytest.fixture
def noetic(tmp_path):
    """A stand-in for /opt/ros/noetic that has every ROS package of package.xml, except tf."""
    prefix = tmp_path / "opt" / "noetic"
    for name in named_by_package_xml() - {"tf"}:
        (prefix / "share" / name).mkdir(parents=True)
        (prefix / "share" / name / "package.xml").write_text("<package/>")
    (prefix / "setup.bash").write_text("export FOREIGN=noetic\n")
    return prefix


def test_ros_under_another_prefix_is_used(clone, noetic):
    assert clone.run("shell", "true", PIONEER_ROS_PREFIXES="/no/such/place:%s" % noetic)[0] == 0
    assert clone.calls[-1].startswith("catkin_make") and clone.calls[-1].endswith("FOREIGN=noetic")


def test_what_another_prefix_lacks_is_installed_by_its_name(clone, noetic):
    system = "python3-setuptools " + clone.environment["INSTALLED"]
    assert clone.run("shell", "true", PIONEER_ROS_PREFIXES=str(noetic), INSTALLED=system)[0] == 0
    assert [call for call in clone.calls if call.endswith("install -y --no-install-recommends ros-noetic-tf")]


def test_rviz_is_installed_by_the_other_prefixs_name(clone, noetic):
    shutil.rmtree(str(noetic / "share" / "rviz"))
    system = "python3-setuptools " + clone.environment["INSTALLED"]
    clone.run("run", "--rviz", PIONEER_ROS_PREFIXES=str(noetic), INSTALLED=system, DISPLAY=":0")
    assert [call for call in clone.calls
            if call.endswith("install -y --no-install-recommends ros-noetic-tf ros-noetic-rviz")]


def test_debians_ros_is_used_when_there_is_no_other(clone):
    clone.run("shell", "true", PIONEER_ROS_PREFIXES="/no/such/place")
    assert clone.calls[-1].endswith("FOREIGN=")


# --- Building ---

def test_another_python_and_another_workspace_stay_outside(clone):
    clone.run("shell", "true", PYTHONPATH="/somebody/elses")
    assert "-DPYTHON_EXECUTABLE=/usr/bin/python3" in clone.calls[-1]
    assert "/somebody/elses" not in clone.calls[-1]


def test_a_broken_build_shows_its_end(clone):
    status, output = clone.run("test", BROKEN_BUILD="1")
    assert status == 1
    assert "error: broken" in output and "build.log" in output


def test_a_clone_that_was_moved_is_built_anew(clone, tmp_path):
    clone.run("shell", "true")
    stale = clone.folder / "build" / ".ws" / "stale"
    stale.touch()
    clone.run("shell", "true")
    assert stale.exists()
    clone.folder = clone.folder.rename(tmp_path / "moved")
    clone.run("shell", "true")
    assert not (clone.folder / "build" / ".ws" / "stale").exists()


@pytest.mark.parametrize("name", ["my robot", "it's \"mine\" $HOME", "a:b;c", "r\u00f6b\u00f6ter", "-n"])
def test_any_directory_name(tmp_path, name):
    clone = Clone(tmp_path, name)
    status, output = clone.run("run")
    assert status == 0, output
    assert re.match(r"catkin_make -C [A-Za-z0-9/._-]+ --source [A-Za-z0-9/._-]+ ", clone.calls[0])
    (picture,) = (clone.folder / "runs").glob("*.png")
    assert "picture  %s" % picture in output


# --- Running ---

def test_a_run_narrates_and_leaves_bag_and_picture(clone):
    status, output = clone.run("run", "world:=office")
    assert status == 0
    assert "It drives." in output and "SUMMARY" not in output and "looking for" not in output
    (bag,), (picture,) = (clone.folder / "runs").glob("*.bag"), (clone.folder / "runs").glob("*.png")
    assert output.endswith("bag      %s\npicture  %s\n" % (bag, picture))
    assert "bag:=%s page_port:=8080 world:=office" % bag in clone.calls[-1]


def page_of(output):
    """Return port and key of the address that a run printed."""
    return re.search(r"in a browser .*: http://127.0.0.1:(\d+)/#(\w+)$", output, re.MULTILINE).groups()


def test_a_run_says_where_it_can_be_watched_and_keeps_the_key_to_itself(clone):
    _, output = clone.run("run")
    port, key = page_of(output)
    assert port == "8080" and len(key) == 32
    assert (clone.calls_file.parent / "calls.key").read_text().strip() == key
    assert not any(key in call for call in clone.calls)
    assert key not in (clone.folder / "build" / "log" / "run.log").read_text()
    assert page_of(clone.run("run")[1])[1] != key


def test_another_port_is_taken_when_somebody_has_the_usual_one(clone):
    _, output = clone.run("run", USERS_AT="0", PORT_OF_USERS="1F90")    # 8080
    port, _ = page_of(output)
    assert port != "8080" and "page_port:=%s " % port in clone.calls[-1]


def test_a_run_without_a_page_names_none(clone):
    assert "in a browser" not in clone.run("run", "page:=false")[1]


def test_a_run_opens_the_browser_when_the_page_is_there(clone, tmp_path):
    opened = tmp_path / "opened"
    browser = clone.tools / "browser"
    browser.write_text('#!/bin/bash\necho "$1" >>%s\n' % opened)
    browser.chmod(0o755)
    process = clone.start("run", "--browser", USERS_AT="0", PORT_OF_USERS="1F90", HANGING="1",
                          BROWSER="%s %%s" % browser)
    port = next(int(page_of(line)[0]) for line in process.stdout if "in a browser" in line)
    with socket.create_server(("127.0.0.1", port)):     # now the page is there
        end = time.monotonic() + 60
        while not opened.exists() and time.monotonic() < end:
            time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert opened.read_text().startswith("http://127.0.0.1:%d/#" % port)


def test_the_page_gets_its_arguments(clone):
    status, output = clone.run("web", "run.bag", "--port", "0")
    assert status == 0 and output.endswith("the page of ['run.bag', '--port', '0']\n")


def test_a_class_is_a_page_for_so_many(clone):
    status, output = clone.run("class", "30", "--share")
    assert status == 0 and output.endswith("the page of ['--class', '30', '--share']\n")
    assert clone.run("class") == (1, "pioneer: class wants the number of students: ./pioneer class 30\n")
    assert clone.run("class", "--share")[0] == 1


def test_a_run_without_a_bag_is_a_failure(clone):
    status, output = clone.run("run", WITHOUT_BAG="1")
    assert status == 1
    assert "left no bag" in output


def test_a_run_in_which_a_program_failed_is_a_failure(clone):
    status, output = clone.run("run", DYING="1")
    assert status == 1
    assert "ended badly" in output and "run.log" in output and "picture  " in output


@pytest.mark.parametrize("failing", [{}, {"DYING": "1"}])
def test_a_run_that_never_moved_leaves_no_bag(clone, failing):
    """A run in a world that does not exist never moves."""
    status, output = clone.run("run", MISTAKEN="1", **failing)
    assert status == 1
    assert "Nothing is kept" in output and "picture" not in output
    assert list((clone.folder / "runs").iterdir()) == []


@pytest.mark.parametrize("argument", ["wordl:=office", "world=office", "sim:=false", "bag:=mine.bag", "--rvis"])
def test_an_argument_that_is_not_the_demos_is_refused(clone, argument):
    status, output = clone.run("run", argument)
    assert status == 1
    assert "does not know " + argument in output and "world:=tutorial" in output
    assert clone.calls == []


def test_rviz_without_a_display_is_refused(clone):
    status, output = clone.run("run", "--rviz")
    assert status == 1
    assert "DISPLAY" in output


def test_rviz_is_installed_when_it_is_asked_for(clone):
    assert clone.run("run", "--rviz", DISPLAY=":0")[0] == 0
    assert [call for call in clone.calls if call.endswith("install -y --no-install-recommends rviz")]
    assert "rviz:=true" in clone.calls[-1]


def test_a_taken_port_is_left_to_whom_has_it(clone):
    with socket.socket() as other:
        # connections of a roscore that has ended linger on the port
        other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            other.bind(("localhost", 31311))
            other.listen(1)
        except OSError:
            pass  # a roscore of this machine has it: as good
        status, output = clone.run("run", USERS_AT="", USER_ID="0")
    assert status == 0
    (uri,) = re.findall(r"export ROS_MASTER_URI=(\S+)", output)
    assert uri != "http://localhost:31311"
    assert clone.calls[-1].endswith(uri)


def ignore_interrupts():
    """Do what a shell without job control does to a program that it starts with &."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@pytest.mark.parametrize("before", [None, ignore_interrupts])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_stops_the_robot_first(clone, number, before):
    with clone.start("run", before=before, HANGING="1") as process:
        for line in process.stdout:
            if "It drives." in line:
                break
        process.send_signal(number)
        output = process.communicate(timeout=60)[0]
    assert "It stops." in output
    assert process.returncode == 130
    (bag,), (picture,) = (clone.folder / "runs").glob("*.bag"), (clone.folder / "runs").glob("*.png")
    assert output.endswith("bag      %s\npicture  %s\n" % (bag, picture))


def test_interrupted_before_the_robot_moved_it_leaves_nothing(clone):
    with clone.start("run", HANGING="1", MISTAKEN="1") as process:
        for line in process.stdout:
            if "It drives." in line:
                break
        process.send_signal(signal.SIGINT)
        output = process.communicate(timeout=60)[0]
    assert "interrupted before the robot moved" in output and process.returncode != 0
    assert list((clone.folder / "runs").iterdir()) == []


# --- A master for each user ---

SHOW_MASTER = "shell", "sh", "-c", 'echo "at $ROS_MASTER_URI as $ROS_HOSTNAME"'


@pytest.mark.parametrize("user, port", [("0", 11311), ("1000", 12311), ("1001", 12312)])
def test_each_user_has_a_master_of_his_own(clone, user, port):
    _, output = clone.run(*SHOW_MASTER, USER_ID=user)
    assert "ROS master: http://localhost:%d," % port in output
    assert "at http://localhost:%d as \n" % port in output


@pytest.mark.parametrize("user, port", [("0", 31311), ("1000", 32311)])
def test_a_run_leaves_the_master_of_the_shell_alone(clone, user, port):
    """A robot of the shell ended the run's robot, for it had its name at the same master."""
    clone.run("run", USER_ID=user)
    assert clone.calls[-1].endswith("http://localhost:%d" % port)


def test_a_port_that_a_program_of_another_user_has_is_left_to_it(clone):
    taken = {"USER_ID": "1000", "PORT_OF_USERS": ":%04X" % 12311}
    assert "at http://localhost:22311 as" in clone.run(*SHOW_MASTER, USERS_AT="1001", **taken)[1]
    own = clone.run(*SHOW_MASTER, USERS_AT="1000", **taken)[1]
    assert "at http://localhost:12311 as" in own, "the program is the user's own"


def test_a_master_that_is_named_is_kept(clone):
    _, output = clone.run(*SHOW_MASTER, ROS_MASTER_URI="http://robot:11311")
    assert "at http://robot:11311 as" in output


def test_on_a_computer_whose_name_does_not_resolve_ros_works_all_the_same(clone):
    _, output = clone.run(*SHOW_MASTER, NAMELESS="1")
    assert "as localhost\n" in output and "does not resolve" in output
    _, output = clone.run(*SHOW_MASTER, NAMELESS="1", ROS_IP="10.0.0.2")
    assert "as \n" in output and "does not resolve" not in output


def test_a_shell_completes_names_of_packages(clone):
    process = clone.start("shell", before=os.setsid, stdin=subprocess.PIPE)
    with process:
        output = process.communicate("complete -p rosrun roslaunch\nexit\n", timeout=60)[0]
    assert "_roscomplete_exe rosrun" in output and "_roscomplete_launch roslaunch" in output


# --- One list of packages ---

# Which of Debian's packages brings what package.xml names.
BROUGHT_BY = {
    "actionlib": "python3-actionlib", "actionlib_msgs": "python3-actionlib-msgs",
    "move_base_msgs": "python3-move-base-msgs",
    "catkin": "ros-core-python-dev", "geometry_msgs": "ros-core-python-dev",
    "message_generation": "ros-core-python-dev",
    "message_runtime": "ros-core-python-dev", "nav_msgs": "ros-core-python-dev",
    "python3-setuptools": "ros-core-python-dev",
    "rosgraph_msgs": "ros-core-python-dev", "roslaunch": "ros-core-python-dev", "roslib": "ros-core-python-dev",
    "rospy": "ros-core-python-dev",
    "std_msgs": "ros-core-python-dev", "std_srvs": "ros-core-python-dev", "trajectory_msgs": "ros-core-python-dev",
    "visualization_msgs": "ros-core-python-dev",
    "diagnostic_msgs": "python3-diagnostic-updater",
    "diagnostic_aggregator": "libdiagnostic-aggregator-tools", "diagnostic_updater": "python3-diagnostic-updater",
    "dynamic_reconfigure": "python3-dynamic-reconfigure",
    "robot_state_publisher": "ros-robot-state-publisher", "rosbag": "python3-rosbag", "rostest": "python3-rostest",
    "sensor_msgs": "python3-sensor-msgs", "tf": "python3-tf",
    "tf2_msgs": "python3-tf2-msgs", "tf2_ros": "python3-tf2-ros",
}
# Needed by the build itself, by those above for their package.xml,
# or by mypy (Debian has its stubs for libraries in a package of their own).
BUILD_TOOLS = {"cmake", "make", "g++", "python3-typeshed", "rosbash", "librostest-dev", "libtf-dev", "libtf2-msgs-dev",
               "libtf2-ros-dev", "libsensor-msgs-dev", "libactionlib-msgs-dev", "libmove-base-msgs-dev",
               "libdynamic-reconfigure-config-init-mutex-dev", "libdiagnostic-updater-dev",
               "libdiagnostic-aggregator-dev"}


def test_the_list_of_packages_agrees_with_package_xml():
    """Only RViz and what the tests alone need are not in the list: `run --rviz` and `test` install them."""
    assert {BROUGHT_BY.get(name, name) for name in named_by_package_xml() -
            {"rviz", "python3-selenium", "python3-venv", "liburdfdom-tools"}} | BUILD_TOOLS == set(debian_packages())


def test_only_the_tests_install_a_browser(clone):
    installed = " ".join(debian_packages())
    clone.run("shell", "true", INSTALLED=installed)
    assert [call for call in clone.calls if "chromium" in call] == []
    clone.run("test", INSTALLED=installed)
    (install,) = [call for call in clone.calls if "chromium" in call]
    assert install.endswith("install -y --no-install-recommends chromium chromium-driver liburdfdom-tools"
                            " python3-selenium python3-venv")


def test_continuous_integration_calls_the_same_command():
    assert '/pioneer" test' in (ROOT / ".ci" / "run").read_text()
    assert "./pioneer test" in (ROOT / "README.md").read_text()
