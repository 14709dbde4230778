"""Simulated robots on the command line, without ROS: ``python3 -m pioneer_control.simulator --tcp 8101``."""

import argparse
import signal
import sys
import textwrap
import threading
from typing import Any, Dict, List, Optional, Union

from ..errors import PioneerError, UsageError
from ..p2os.recording import Entry, read_record
from ..robots import find_model, load_table
from .hardware.arm import KINDS_OF_ARMS
from .line import Fault, LineRecorder, LineSimulation, Server, camera_ports, fault_of, laser_ports, load_faults
from .line.cameras import AUX_OF_CAMERAS, CAMERA_CABLINGS, KINDS_OF_CAMERAS
from .line.faults import KINDS
from .line.lasers import KINDS_OF_LASERS, ROBOTS_LINE, STANDARD_LASER_PORT
from .line.lines import STANDARD_PORT
from .line.pace import SPEEDS
from .parameters import Place
from .played import PlayedRobot, compare, play_client
from .simulation import MOST_ROBOTS, Simulation, prepared, simulate
from .tasks import Grounds, Referee, load_tasks
from .truth import TruthService
from .world import World, known_worlds, load_world, standing_places
from .world.generated import KINDS as GENERATED
from .world.poses import Pose


def main(arguments: Optional[List[str]] = None) -> int:
    """Run simulated robots until Ctrl-C or SIGTERM. With --client, compare them with recorded robots.

    Returns:
        The exit code. 0: ended by the user, or no differences found. 1: a failure, or differences found. 2: an argument
        is not legal.
    """
    options = parser().parse_args(arguments)
    try:
        return serve(options) if options.client is None else compare_with(options)
    except PioneerError as error:
        print("simulator: %s" % error, file=sys.stderr)
        return 2 if isinstance(error, ValueError) else 1


def serve(options: argparse.Namespace) -> int:
    """Run a server for simulated robots, or for one robot of a recording, until Ctrl-C or SIGTERM.

    Returns:
        The exit code: 0 ended by the user, 1 the server has failed.
    """
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    allow_many_files()
    grounds = grounds_of(options) if options.tasks else None
    robots: Union[Simulation, PlayedRobot] = (
        simulation_of(options, grounds.world if grounds else None) if options.play is None else played_robot(options))
    server = Server(robots, options.tcp, options.pty, speed=options.speed, seed=options.seed, faults=faults_of(options),
                    record=options.record, say=say, lockstep=options.lockstep,
                    lasers=laser_ports(options.laser, options.laser_port, options.laser_pty),
                    cameras=camera_ports(options.camera, options.camera_cabling, options.camera_aux,
                                         options.camera_port, options.camera_pty))
    truth: Optional[TruthService] = None
    try:
        if options.truth is not None and isinstance(robots, Simulation):
            truth = TruthService(server, robots, options.truth, Referee(robots, grounds))
        print(*welcome(server, robots), sep="\n")
        if truth is not None:
            print("The true state of the world is at %s" % options.truth)
            truth.start()
        if server.open_to_others:
            print("simulator: every machine that reaches this one can drive it: the protocol knows no password",
                  file=sys.stderr)
        print("Ctrl-C ends it.", flush=True)
        server.start()  # last, so that the report of a fault does not come between the lines above
        while server.running and not stop.wait(0.2):
            pass
        return 0 if stop.is_set() else 1
    finally:
        if truth is not None:
            truth.stop()
        server.stop()
        if server.pace.late_answers is not None:
            say("answers that came too late: %d" % server.pace.late_answers)


def allow_many_files() -> None:
    """Let this process open as many files as the system allows: many robots need many. Windows has no such limit."""
    try:
        import resource
    except ImportError:
        return
    most_files = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (most_files, most_files))


def grounds_of(options: argparse.Namespace) -> Grounds:
    """Return the world that the options of the command line describe, with the arenas of all tasks beside it.

    Raises:
        UsageError: an option is not legal.
    """
    if options.truth is None:
        raise UsageError("--tasks needs --truth: a task is chosen by an order at that socket")
    world = world_of(options)
    starts = standing_places(world, find_model(options.model, options.models), options.robots)
    return Grounds(world, starts, load_tasks())


def simulation_of(options: argparse.Namespace, world: Optional[World] = None) -> Simulation:
    """Return the simulation, with world and robots, that the options of the command line describe.

    Args:
        options: the options.
        world: the world in which the robots stand. If None, that of the options.

    Raises:
        UsageError: an option is not legal.
    """
    return simulate(
        world or world_of(options), find_model(options.model, options.models), options.robots, options.name,
        options.seed,
        gripper=options.gripper, arm=options.arm != "none", rear_sonar=options.rear_sonar, noise=options.noise,
        numbers_file=options.numbers, real=options.real, serial=options.serial,
        line_laser=options.laser == ROBOTS_LINE)


def world_of(options: argparse.Namespace) -> World:
    """Return the world that the options of the command line describe, without the arenas of tasks.

    Raises:
        UsageError: an option is not legal.
    """
    return prepared(load_world(options.world), find_model(options.model, options.models), options.robots, options.seed,
                    options.start, options.unmapped, options.walkers)


def played_robot(options: argparse.Namespace) -> PlayedRobot:
    """Return the played robot of the recording that option --play names.

    Raises:
        UsageError: the recording is not legal, or a laser is wanted.
    """
    if options.laser == ROBOTS_LINE:
        raise UsageError("a laser over the robot's line is for simulated robots: a record has nothing of what it would"
                         " see. Leave out --laser or --play")
    return PlayedRobot(
        read_record(options.play), options.robot,
        lambda time, sentence: say("%.3f s of the record: %s" % (time, sentence)))


def compare_with(options: argparse.Namespace) -> int:
    """Send the bytes of recorded clients to simulated robots, and print how answers differ from the recorded answers.

    Returns:
        The exit code: 0 all bytes are equal, 1 there are differences.
    """
    notes: List[Entry] = []
    simulation, recorded = simulation_of(options), read_record(options.client)
    recording = LineRecorder(options.record)
    lines = LineSimulation(
        simulation, options.seed, faults_of(options),
        lambda time, sentence: notes.append(Entry(time, 0, False, b"", sentence)))
    made = sorted(notes + play_client(recorded, lines), key=lambda entry: entry.time)
    for entry in made:
        recording.put(entry)
    recording.close()
    found = compare(recorded, made, [robot.model for robot in simulation.robots])
    print(*found, sep="\n")
    return 0 if all(each.same for each in found) else 1


def faults_of(options: argparse.Namespace) -> List[Fault]:
    """Return the faults of the options --fault and --faults.

    Raises:
        ParameterError: a fault is not legal, or a file cannot be read.
    """
    return [fault_of(words) for words in options.fault] + [fault for path in options.faults
                                                           for fault in load_faults(path)]


def welcome(server: Server, robots: Union[Simulation, PlayedRobot]) -> List[str]:
    """Return lines of text to print at the start: which robots there are, and where clients connect to each of them."""
    single = len(server.berths) == 1
    if isinstance(robots, PlayedRobot):
        lines = ["A robot that plays back %s of the record. Connect to it at" % robots.name]
    else:
        kind = robots.robots[0].model.subtype, robots.world.name
        lines = ["World file, skipped: %s" % skipped for skipped in robots.world.skipped]
        lines += ["A simulated %s stands in the world %r. Connect to it at" % kind if single else
                  "%d simulated %s stand in the world %r. Connect to them at" % (len(server.berths), *kind)]
    for berth in server.berths:
        places = [place for place in (berth.url, berth.pty_link) if place is not None]
        lines += ["    " + words for words in (places if single else ["  ".join([berth.robot.name, *places])])]
    if server.lasers:
        lines += ["Connect to %s at" % ("its laser" if single else "their lasers")]
        lines += ["    " + laser.place if single else "    %s  %s" % (berth.robot.name, laser.place)
                  for berth, laser in zip(server.berths, server.lasers)]
    if server.cameras:
        lines += ["Connect to %s at" % ("its camera" if single else "their cameras")]
        lines += ["    " + camera.place if single else "    %s  %s" % (berth.robot.name, camera.place)
                  for berth, camera in zip(server.berths, server.cameras)]
    return lines


def say(sentence: str) -> None:
    """Print a line, and flush the output."""
    print(sentence, flush=True)


def count(text: str) -> int:
    """Convert an argument of the command line to a number of robots, from 1 to `MOST_ROBOTS`.

    Raises:
        ArgumentTypeError: the text is not such a number.
    """
    if not text.isdigit() or not 1 <= int(text) <= MOST_ROBOTS:
        raise argparse.ArgumentTypeError("%r is not legal: give a whole number from 1 to %s" % (text, MOST_ROBOTS))
    return int(text)


def start_of(text: str) -> Union[Pose, str, None]:
    """Convert an argument of the command line to a start; see `parameters.Place`.

    Raises:
        ArgumentTypeError: the text is not a start.
    """
    try:
        return Place().accept(text)
    except ValueError:
        raise argparse.ArgumentTypeError("%r is not legal: give %s" % (text, Place().legal)) from None


OPTIONS: Dict[str, Dict[str, Any]] = {
    "--model": dict(default="p3dx-sh", help="robot model, by its subtype: see below (default: %(default)s)"),
    "--world": dict(default="tutorial",
                    help="name of a world, or path of a world file or a map: see below (default: %(default)s)"),
    "--robots": dict(type=count, default=1, metavar="N", help="number of robots (default: %(default)s)"),
    "--start": dict(type=start_of, metavar="X,Y,HEADING",
                    help="where the first robot stands at first (m, m, rad); random: where all robots stand, by the"
                         " seed (default: at the starts of the world)"),
    "--unmapped": dict(type=int, default=0, metavar="N", choices=range(101),
                       help="add N obstacles that are on no map, by the seed (default: %(default)s)"),
    "--walkers": dict(type=int, default=0, metavar="N", choices=range(101),
                      help="add N people who walk about, by the seed (default: %(default)s)"),
    "--tcp": dict(metavar="PORT",
                  help="TCP port of the first robot; the other robots have the next ports; 0: any free ports. Only"
                       " clients on this machine can connect, unless you give HOST:PORT, such as 0.0.0.0:8101"
                       " (default: %s, unless --pty is given)" % STANDARD_PORT),
    "--pty": dict(metavar="LINK",
                  help="make a pseudo-terminal with this link to it; several robots have LINK1, LINK2, ..."),
    "--laser": dict(default="none", choices=("none", *KINDS_OF_LASERS),
                    help="laser on each robot: lms200, on a line of its own; line, over the robot's own line, as other"
                         " simulators have it (default: %(default)s)"),
    "--laser-port": dict(metavar="PORT",
                         help="TCP port of the first robot's laser; the others have the next ports; 0: any free ports;"
                              " or HOST:PORT (default: the first port after those of the robots, or %s)"
                              % STANDARD_LASER_PORT),
    "--laser-pty": dict(metavar="LINK",
                        help="make a pseudo-terminal for the laser with this link to it, instead of a TCP port"),
    "--camera": dict(default="none", choices=("none", *KINDS_OF_CAMERAS),
                     help="camera that turns on each robot, at an auxiliary port of it (default: %(default)s)"),
    "--camera-aux": dict(type=int, default=AUX_OF_CAMERAS, choices=(1, 2, 3),
                         help="which auxiliary port (default: %(default)s)"),
    "--camera-cabling": dict(default=CAMERA_CABLINGS[0], choices=CAMERA_CABLINGS,
                             help="one_way: no answer of the camera arrives, as on many robots (default: %(default)s)"),
    "--camera-port": dict(metavar="PORT",
                          help="TCP port for the first robot's camera, instead of an auxiliary port; the others have"
                               " the next ports; 0: any free ports; or HOST:PORT"),
    "--camera-pty": dict(metavar="LINK",
                         help="make a pseudo-terminal for the camera with this link to it, instead of that"),
    "--seed": dict(type=int, default=0,
                   help="random seed of sonar noise, wheel slip and damaged packets (default: %(default)s)"),
    "--speed": dict(type=float, default=1.0, metavar="X",
                    help="simulated seconds per real second, %g to %g (default: %%(default)s)" % SPEEDS),
    "--lockstep": dict(type=float, nargs="?", const=1.0, metavar="LIMIT",
                       help="simulated time waits for the client at each SIP, LIMIT real seconds at most (default:"
                            " %(const)s); see docs/simulator.md"),
    "--record": dict(metavar="FILE",
                     help="record all bytes on the lines to this file; python3 -m pioneer_control.p2os --record FILE"
                          " explains them"),
    "--truth": dict(metavar="PATH",
                    help="make a Unix domain socket, at which other programs get the true state of the world and give"
                         " orders; see docs/simulator.md"),
    "--tasks": dict(action="store_true",
                    help="add the arenas of all tasks beside the world; needs --truth; see docs/simulator.md"),
    "--play": dict(metavar="FILE",
                   help="play back the robot in this record, instead of a simulated robot; see docs/wire.md"),
    "--client": dict(metavar="FILE",
                     help="send the simulated robots what the clients in this record sent, and print how the answers"
                          " differ"),
    "--robot": dict(type=count, default=1, metavar="N",
                    help="number of the robot in the record that --play plays back (default: %(default)s)"),
    "--fault": dict(action="append", default=[], metavar="WORDS",
                    help="such as 'loss 0.1 from 10 to 20'; may be given again; see below"),
    "--faults": dict(action="append", default=[], metavar="FILE", help="a YAML list of faults; may be given again"),
    "--noise": dict(type=float, metavar="M",
                    help="largest random error of a sonar range (default: that of robot.yaml)"),
    "--gripper": dict(action="store_true", default=None, help="fit a gripper (default: on a p3dx-sh)"),
    "--no-gripper": dict(action="store_false", dest="gripper", help="fit no gripper"),
    "--arm": dict(default="none", choices=("none", *KINDS_OF_ARMS),
                  help="arm on each robot (default: %(default)s)"),
    "--no-rear-sonar": dict(action="store_false", dest="rear_sonar", help="fit no rear sonar array"),
    "--name": dict(help="the robot's own name; several are numbered, NAME_0001 and up (default: sim_0001 and up)"),
    "--serial": dict(metavar="TEXT",
                     help="serial number that the robots tell; SIM, with --laser line: clients that know simulators by"
                          " it take that laser (default: that of robot.yaml)"),
    "--models": dict(metavar="FILE", help="a models file that overrides or adds robot models"),
    "--real": dict(action="store_true",
                   help="wheels and sonar err as those of real robots, drawn from the seed; see docs/worlds.md"),
    "--numbers": dict(metavar="FILE", help="a file that overrides numbers of robot.yaml"),
}
"""Options of the command line, in the order of the help text, with their arguments for argparse."""


def parser() -> argparse.ArgumentParser:
    """Return the argument parser of the command line."""
    result = argparse.ArgumentParser(
        prog="python3 -m pioneer_control.simulator", description="Simulated Pioneers that speak P2OS.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="\n".join([
            "worlds: %s" % ", ".join(known_worlds()),
            "generated worlds: KIND-SEED, such as offices-7; kinds: %s" % ", ".join(sorted(GENERATED)), "",
            *textwrap.wrap("models: %s" % ", ".join(load_table().models), 79, break_on_hyphens=False), "",
            "faults, written as KIND [VALUE] [way to-robot|from-robot] [robot N] [from S] [to S], S in simulated"
            " seconds:",
            *("  %-17s %s" % (" ".join(filter(None, (kind.name, kind.unit))), kind.meaning)
              for kind in KINDS.values())]),
    )
    played, fitted = result.add_mutually_exclusive_group(), result.add_mutually_exclusive_group()
    group_of = {"--truth": played, "--play": played, "--client": played, "--gripper": fitted, "--no-gripper": fitted}
    for name, how in OPTIONS.items():
        group_of.get(name, result).add_argument(name, **how)
    return result


if __name__ == "__main__":
    sys.exit(main())
