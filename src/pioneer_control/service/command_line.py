"""The commands ``install_service`` and ``uninstall_service``."""

import argparse
import glob
import os
import pwd
import shlex
import subprocess
import sys
from typing import Dict, List, Mapping, Optional, Sequence

from ..errors import PioneerError, UsageError
from .installed import InstalledFiles
from .launched import checked
from .unit import LOCAL_MASTER, UNIT, Service, command, environment, master_command, unit_texts

DEFAULT_LAUNCH = ("pioneer_control", "pioneer.launch", "port:=/dev/pioneer")
RULES = "/etc/udev/rules.d/99-pioneer.rules"
SYSTEMD = "/run/systemd/system"     # is there while systemd runs this computer (sd_booted(3))
PASSED_ON = ("CMAKE_PREFIX_PATH", "PYTHONPATH", "ROS_PACKAGE_PATH", "SUDO_USER")
"""What rosrun's environment has that this program needs, and sudo takes away."""


class ServiceError(PioneerError):
    """Something on this computer keeps a service from being installed: no root, no systemd, a command that failed."""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line of ``install_service``."""
    result = argparse.ArgumentParser(
        prog="install_service", description="Start a launch file at boot, as a systemd service. Motors stay off until "
                                            "somebody asks. --print shows what would be written, and writes nothing.",
        epilog="Installed again, the new service replaces the old one. uninstall_service removes what was installed.")
    result.add_argument("launch", nargs="*", metavar="[PACKAGE] FILE [NAME:=VALUE ...]",
                        help="what roslaunch gets; files with whole paths (default: %s)" % " ".join(DEFAULT_LAUNCH))
    result.add_argument("--print", action="store_true", help="show the files, write nothing; needs no root")
    result.add_argument("--name", default="pioneer", help="name of the service (default: %(default)s)")
    result.add_argument("--user", help="who runs it, and may read the workspace (default: who typed sudo)")
    result.add_argument("--setup", metavar="FILE",
                        help="setup.bash of the catkin workspace (default: that of this shell's); '' for none")
    own = result.add_mutually_exclusive_group()
    own.add_argument("--hostname", default="localhost", metavar="NAME",
                     help="name by which other computers reach this one, such as robot1: ROS_HOSTNAME (default: "
                          "%(default)s: this computer alone)")
    own.add_argument("--ip", default="", metavar="ADDRESS", help="fixed address in place of a name: ROS_IP")
    result.add_argument("--master", default=LOCAL_MASTER, metavar="URI",
                        help="ROS_MASTER_URI; a master of this computer is started with it (default: %(default)s)")
    result.add_argument("--no-udev", action="store_false", dest="udev",
                        help="leave the rules alone that name the robot's port /dev/pioneer")
    return result


def service_of(options: argparse.Namespace, environ: Mapping[str, str]) -> Service:
    """Return the service that the command line and the environment describe.

    Raises:
        UsageError: it does not say who runs it, or something in it is not legal.
    """
    user = options.user or environ.get("SUDO_USER") or (environ.get("USER", "root") if os.geteuid() else "")
    if not user or (user == "root" and options.user != "root"):
        raise UsageError("who shall run it? Give --user NAME (--user root, if it must be), or type it with sudo")
    setup = setup_of(environ) if options.setup is None else options.setup
    launch = tuple(options.launch) or DEFAULT_LAUNCH
    if len(launch) == 1 or ":=" in launch[1]:   # a file: of this folder, or else of this package
        known = os.path.isfile(launch[0])
        launch = (os.path.abspath(launch[0]), *launch[1:]) if known else ("pioneer_control", *launch)
    service = Service(launch, user, setup, options.name, options.hostname, options.ip, options.master)
    service.check()
    return service


def setup_of(environ: Mapping[str, str]) -> str:
    """Return the setup.bash of the catkin workspace of an environment; empty if it has none, as with ROS in /usr alone.
    """
    paths = [os.path.join(prefix, "setup.bash") for prefix in environ.get("CMAKE_PREFIX_PATH", "").split(":") if prefix]
    return next((path for path in paths if os.path.isfile(path)), "")


def files_of(service: Service, rules: Optional[str]) -> Dict[str, str]:
    """Return the texts of the files of a service, by their paths. ``rules`` is the text of the udev rules, or None."""
    files = unit_texts(service)
    if rules is not None:
        files[RULES] = rules
    return files


def install(service: Service, files: Mapping[str, str], installed: InstalledFiles) -> None:
    """Write the files of a service, and start it.

    Raises:
        UsageError: another service has this name, or its master this port, or the launch file may not run at boot.
        ServiceError: the user does not exist or may not read the workspace, or a command failed.
    """
    foreign = installed.foreign(files)
    others = [path for path in foreign if path != RULES]
    others += [path for path in ("/lib/systemd/system/%s.service" % name for name in service.unit_names)
               if os.path.exists(path)]
    if others:
        raise UsageError("there is another service of this name: %s. Choose a --name" % others[0])
    port = master_command(service)[-1]
    for path in glob.glob(UNIT % "*-master") if service.master_name else ():
        with open(path, encoding="utf-8") as file:
            if path != UNIT % service.master_name and "roscore -p %s\n" % port in file.read():
                raise UsageError("%s starts a master at port %s, too: give another --master, such as"
                                 " http://localhost:11312" % (path, port))
    for stranger in check(service):
        print("note: it starts %s, too: whether that asks for motors is not known here" % stranger)
    if RULES in foreign:
        print("left as it is, somebody has made it: %s" % RULES)
    print(*installed.write({path: text for path, text in files.items() if path not in foreign}), sep="\n")
    if RULES in files and RULES not in foreign:
        reload_rules()
    call("systemctl", "daemon-reload")
    call("systemctl", "enable", "--quiet", service.name)
    call("systemctl", "restart", *service.unit_names)
    print("started, now and at each boot. To see how it is:\n    systemctl status %s\n    journalctl -u %s -f\n"
          "    ls %s" % (service.name, service.name, service.logs))
    if service.hostname == "localhost" and not service.address:
        print("Programs on this computer reach it. For others give --hostname or --ip: docs/two-computers.md")


def check(service: Service) -> List[str]:
    """Have the service check itself, as its user and in its environment. Return its nodes of other packages.

    Raises:
        UsageError: the launch file may not run at boot.
        ServiceError: the user does not exist, or may not read the workspace.
    """
    try:
        home = pwd.getpwnam(service.user).pw_dir
    except KeyError:
        raise ServiceError("there is no user %r. To make one: adduser --system --group %s" % (
            service.user, service.user)) from None
    variables = {**dict(environment(service)), "HOME": home, "PATH": "/usr/local/bin:/usr/bin:/bin",
                 "ROS_HOME": "/nonexistent", "ROS_LOG_DIR": "/nonexistent"}
    words = ["runuser", "-u", service.user, "--", "env", "-i", *("%s=%s" % pair for pair in variables.items()),
             *command(service, "--check")]
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, cwd="/")
    if done.returncode == 2:
        raise UsageError(done.stderr.strip().replace("service: ", "", 1))
    if done.returncode:
        raise ServiceError("as user %s, this failed, with\n%s\n%s\nMay that user read %s? Or name another: --user, "
                           "--setup" % (service.user, done.stderr.strip() or "no word why",
                                        " ".join(map(shlex.quote, command(service, "--check"))),
                                        service.setup or "the package pioneer_control"))
    return done.stdout.split()


def uninstall(name: str, installed: InstalledFiles) -> None:
    """End a service, and remove its files.

    Raises:
        UsageError: there is no such service of this package.
        ServiceError: a command failed.
    """
    listed = installed.listed
    if not listed:
        raise UsageError("no service named %r was installed by install_service" % name)
    service = Service(("-",), "root", name=name)
    units = [each for each in reversed(service.unit_names) if UNIT % each in listed]
    there = [each for each in units if os.path.exists(UNIT % each)]     # somebody may have removed one by hand
    subprocess.run(["systemctl", "stop", *units], stderr=subprocess.DEVNULL)
    if there:
        call("systemctl", "disable", "--quiet", "--now", *there)
    print(*installed.remove(), sep="\n")
    call("systemctl", "daemon-reload")
    subprocess.run(["systemctl", "reset-failed", *units], stderr=subprocess.DEVNULL)
    if RULES in listed:
        reload_rules()
    left = [folder for folder in (service.logs, service.state) if os.path.isdir(folder)]
    if left:
        print("its logs and its own files stay. To remove them: rm -r %s" % " ".join(left))


def reload_rules() -> None:
    """Have udev read its rules, and name the ports that are there. Where no udev runs, the next boot does it."""
    for words in (["control", "--reload"], ["trigger", "--subsystem-match=tty"]):
        subprocess.run(["udevadm", *words], stderr=subprocess.DEVNULL)


def call(*words: str) -> None:
    """Run a command. Raises ServiceError, with what it said, when it fails."""
    try:
        done = subprocess.run(words, stderr=subprocess.PIPE, universal_newlines=True)
    except FileNotFoundError:
        raise ServiceError("there is no command %s on this computer" % words[0]) from None
    if done.returncode:
        raise ServiceError("%s: %s" % (" ".join(words), done.stderr.strip() or "exit code %d" % done.returncode))


def require_root(program: str, arguments: Sequence[str], environ: Mapping[str, str]) -> None:
    """Raise ServiceError unless this is root on a computer that systemd runs. The error has the command to type.

    ``sudo rosrun`` would not do: sudo takes away the environment in which rosrun finds packages.
    """
    if os.geteuid():
        passed = ["%s=%s" % (name, environ[name]) for name in PASSED_ON if environ.get(name)]
        words = ["sudo", "env", *passed, "/usr/bin/python3", os.path.abspath(program), *arguments]
        raise ServiceError("only root may do that. Type:\n    %s" % " ".join(map(shlex.quote, words)))
    if not os.path.isdir(SYSTEMD):
        raise ServiceError("this computer is not run by systemd (there is no %s)" % SYSTEMD)


def own_rules() -> str:
    """Return the text of the udev rules of this package."""
    import rospkg

    path = os.path.join(rospkg.RosPack().get_path("pioneer_control"), "config", os.path.basename(RULES))
    with open(path, encoding="utf-8") as file:
        return file.read()


def main_install(arguments: Optional[Sequence[str]] = None) -> int:
    """Install a service. Returns the exit code: 0 done, 1 this computer refuses, 2 a wrong argument or launch file."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    options = parser().parse_args(given)
    try:
        service = service_of(options, os.environ)
        files = files_of(service, own_rules() if options.udev else None)
        if options.print:
            checked(service.launch)
            for path, text in files.items():
                print("# --- %s\n%s" % (path, text))
            return 0
        require_root(sys.argv[0], given, os.environ)
        install(service, files, InstalledFiles(service.name))
    except (PioneerError, OSError) as error:
        print("install_service: %s" % error, file=sys.stderr)
        return 2 if isinstance(error, UsageError) else 1
    return 0


def main_uninstall(arguments: Optional[Sequence[str]] = None) -> int:
    """Remove a service. Returns the exit code: 0 done, 1 this computer refuses, 2 there is no such service."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    parser = argparse.ArgumentParser(prog="uninstall_service",
                                     description="Remove a service, and each file that install_service wrote for it.")
    parser.add_argument("--name", default="pioneer", help="name of the service (default: %(default)s)")
    options = parser.parse_args(given)
    try:
        Service(("-",), "root", name=options.name).check()
        require_root(sys.argv[0], given, os.environ)
        uninstall(options.name, InstalledFiles(options.name))
    except (PioneerError, OSError) as error:
        print("uninstall_service: %s" % error, file=sys.stderr)
        return 2 if isinstance(error, UsageError) else 1
    return 0
