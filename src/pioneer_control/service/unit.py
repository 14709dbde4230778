"""The texts of the unit files of a service, with `unit_texts`. systemd.unit(5), .service(5), .exec(5) describe them.

There are two: the ROS master has a unit of its own. When a node crashes, the launch file starts again, and the programs
that drive the robot find the new driver at the old master; a master that ends takes the whole graph with it.
"""

import re
import shlex
from typing import Dict, List, NamedTuple, Tuple

from ..errors import UsageError

LOCAL_MASTER = "http://localhost:11311"
RESTART_AFTER = 3       # s between the end of a program that crashed and the next start
MASTER_RESTART_AFTER = 1
STOP_WITHIN = 30        # s: roslaunch gives its nodes 15 s after SIGINT, and 2 s after SIGTERM
NAME = re.compile(r"[a-z][a-z0-9_-]{0,30}")
HOST = re.compile(r"[A-Za-z0-9]([A-Za-z0-9.-]*[A-Za-z0-9])?")
ADDRESS = re.compile(r"\d{1,3}(\.\d{1,3}){3}")
MASTER = re.compile(r"http://(?P<host>%s):(?P<port>\d{1,5})/?" % HOST.pattern)
UNIT = "/etc/systemd/system/%s.service"


class Service(NamedTuple):
    """All that the unit files of a service say."""

    launch: Tuple[str, ...]
    """what roslaunch gets: [PACKAGE] FILE [NAME:=VALUE ...]"""
    user: str
    setup: str = ""
    """the setup.bash of the catkin workspace; empty: ROS and this package are found without one"""
    name: str = "pioneer"
    hostname: str = "localhost"
    """ROS_HOSTNAME: the name by which other programs reach these nodes"""
    address: str = ""
    """ROS_IP, in place of the name; empty: none"""
    master: str = LOCAL_MASTER
    """ROS_MASTER_URI"""

    @property
    def master_name(self) -> str:
        """The name of the unit of the master. Empty: the master runs on another computer."""
        found = MASTER.fullmatch(self.master)
        here = ("localhost", "127.0.0.1", self.hostname, self.address)
        return self.name + "-master" if found is not None and found.group("host") in here else ""

    @property
    def unit_names(self) -> Tuple[str, ...]:
        """The names of its units, in the order in which they start."""
        return tuple(name for name in (self.master_name, self.name) if name)

    @property
    def logs(self) -> str:
        """The folder of ROS's logs: one folder for each run."""
        return "/var/log/" + self.name

    @property
    def state(self) -> str:
        """The folder in which programs run: ROS_HOME, and where files without a folder are looked for."""
        return "/var/lib/" + self.name

    def check(self) -> None:
        """Raise UsageError, which names it, if something in this service is not legal."""
        controls = [text for text in (*self.launch, self.setup, self.user) if re.search(r"[\x00-\x1f\x7f]", text)]
        checks = (
            (NAME.fullmatch(self.name), "--name %r: begin with a small letter; then small letters, digits, _ and -, "
                                        "31 at most" % self.name),
            (not self.name.endswith("-master"), "--name %r: what ends in -master is the master of a service"
             % self.name),
            (self.launch, "no launch file"),
            (not controls, "a control character in " + ", ".join(map(repr, controls))),
            (not self.setup or self.setup.startswith("/"), "--setup %r: give the whole path" % self.setup),
            (HOST.fullmatch(self.hostname),
             "--hostname %r: give a name such as robot1, or robot1.local" % self.hostname),
            (not self.address or _is_address(self.address), "--ip %r: give four numbers from 0 to 255, such as "
                                                            "192.168.1.20" % self.address),
            (_is_master(self.master),
             "--master %r: give http://HOST:PORT, such as %s" % (self.master, LOCAL_MASTER)),
        )
        for is_legal, mistake in checks:
            if not is_legal:
                raise UsageError(mistake)


def _is_address(text: str) -> bool:
    return bool(ADDRESS.fullmatch(text)) and all(int(part) <= 255 for part in text.split("."))


def _is_master(text: str) -> bool:
    found = MASTER.fullmatch(text)
    return found is not None and 1 <= int(found.group("port")) <= 65535


def command(service: Service, *options: str) -> Tuple[str, ...]:
    """Return the words of the command that runs the launch file of a service, or with ``--check`` checks it."""
    return _in_workspace(service, "/usr/bin/python3", "-m", "pioneer_control.service", *options, *service.launch)


def master_command(service: Service) -> Tuple[str, ...]:
    """Return the words of the command that runs the ROS master of a service."""
    found = MASTER.fullmatch(service.master)
    return _in_workspace(service, "/usr/bin/env", "roscore", "-p", found.group("port") if found else "11311")


def _in_workspace(service: Service, *words: str) -> Tuple[str, ...]:
    """Return a command behind the setup.bash of the workspace, if there is one.

    bash reads that in a function, for catkin's file takes the arguments that it finds for its own.
    """
    if not service.setup:
        return words
    return ("/bin/bash", "-c", 'setup() { . "$0"; }; setup && exec "$@"', service.setup, *words)


def environment(service: Service) -> Tuple[Tuple[str, str], ...]:
    """Return the names and values of the environment of a service.

    ROS_IP stands alone: beside ROS_HOSTNAME it would not count.
    """
    own_name = ("ROS_IP", service.address) if service.address else ("ROS_HOSTNAME", service.hostname)
    return (("ROS_MASTER_URI", service.master), own_name, ("ROS_HOME", service.state), ("ROS_LOG_DIR", service.logs),
            ("PYTHONUNBUFFERED", "1"), ("LC_ALL", "C.UTF-8"))


def word(text: str) -> str:
    """Return a text as one word of a systemd command line: no %-specifier, no variable, no escape in it."""
    return setting(text.replace("$", "$$"))


def setting(text: str) -> str:
    """Return a text as one word of a setting that is no command line, and knows no variables."""
    for character, written in (("\\", "\\\\"), ('"', '\\"'), ("%", "%%")):
        text = text.replace(character, written)
    return '"%s"' % text


def unit_texts(service: Service) -> Dict[str, str]:
    """Return the text of each unit file of a service, by its path.

    Raises:
        UsageError: something in the service is not legal. The error names it.
    """
    service.check()
    texts = {UNIT % service.name: _launch_unit(service)}
    if service.master_name:
        texts[UNIT % service.master_name] = _master_unit(service)
    return texts


def _launch_unit(service: Service) -> str:
    master = service.master_name + ".service"
    return _text(
        ["Description=Pioneer robot, " + " ".join(map(shlex.quote, service.launch)).replace("%", "%%")] +
        # Restarted with its master: nodes do not register again.
        (["Requires=" + master, "After=" + master] if service.master_name else []),
        service, command(service), RESTART_AFTER,
        ["# A wrong parameter or launch file: the same again would not help.",
         "RestartPreventExitStatus=2"],
        ["[Install]", "WantedBy=multi-user.target", ""])


def _master_unit(service: Service) -> str:
    return _text(
        ["Description=ROS master of %s.service" % service.name, "StopWhenUnneeded=yes"],
        service, master_command(service), MASTER_RESTART_AFTER, [], [])


def _text(about: List[str], service: Service, start: Tuple[str, ...], restart_after: int, more: List[str],
          end: List[str]) -> str:
    lines = [
        "# Made by: rosrun pioneer_control install_service. Install again to change it; uninstall_service removes it.",
        "[Unit]",
        *about,
        *(["RequiresMountsFor=" + setting(service.setup)] if service.setup else []),
        "# It needs no network, and starts again for as long as it takes.",
        "StartLimitIntervalSec=0",
        "",
        "[Service]",
        "Type=exec",
        "User=" + service.user,
        "# May use serial ports.",
        "SupplementaryGroups=dialout",
        *("Environment=" + setting("%s=%s" % pair) for pair in environment(service)),
        "StateDirectory=" + service.name,
        "LogsDirectory=" + service.name,
        "WorkingDirectory=" + service.state,
        "SyslogIdentifier=" + service.name,
        "ExecStart=" + " ".join(part if re.fullmatch(r"[A-Za-z0-9_./:=-]+", part) else word(part) for part in start),
        "Restart=on-failure",
        "RestartSec=%d" % restart_after,
        *more,
        "# SIGTERM goes to roslaunch alone, which ends its nodes in order: robots stop, and motors go off.",
        "# (SIGINT can get lost while roslaunch starts: it has an except: that takes KeyboardInterrupt.)",
        "KillSignal=SIGTERM",
        "KillMode=mixed",
        "TimeoutStopSec=%d" % STOP_WITHIN,
        "",
        *end]
    return "\n".join(lines)
