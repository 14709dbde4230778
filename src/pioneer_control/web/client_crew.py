"""The robots whose ports were named, and the map of simulated ones: what the page shows without ROS."""

import functools
from time import monotonic
from typing import Any, List, Optional, Sequence

from ..client.tcp import tcp_address
from .backend import TextFeed
from .client_robot import ClientRobot
from .owner import Owner
from .program_line import ProgramLine
from .programs import SharedRobot, Wire
from .trail import Trail
from .truth import TruthLine


class ClientCrew:
    """Gives an owner its robots, with the numbers 1 and up, and listens to their simulator.

    Args:
        urls: the ports of the robots.
        truth: path of the socket at which their simulator tells the truth; None without one.
        owner: gets the robots.
        feed: takes what the simulator tells; None for the owner's outbox.
        options: more arguments for each Robot.
    """

    def __init__(self, urls: Sequence[str], truth: Optional[str], owner: Owner, feed: Optional[TextFeed] = None,
                 **options: Any) -> None:
        wires = [Wire(owner.wake) for _ in urls]
        self.robots: List[ClientRobot] = [
            ClientRobot(number, url, owner.outbox, owner, truth is not None, on_wire=wire.take, **options)
            for number, (url, wire) in enumerate(zip(urls, wires), 1)]
        addresses = [(robot.number, tcp_address(url)) for robot, url in zip(self.robots, urls)]
        self.truth = None if truth is None else TruthLine(
            truth, {address[1]: number for number, address in addresses if address is not None},
            lambda number: self.robots[number - 1].base, owner.outbox if feed is None else feed,
            functools.partial(self._begin_trail, owner.outbox))
        owner.keep(self.robots)
        for robot, wire in zip(self.robots, wires):
            robot.has_programs = True
            owner.programs.add(robot.number, SharedRobot(
                functools.partial(_name_of, robot), wire,
                functools.partial(ProgramLine, robot.robot, robot.steered)), owner.rules)

    def look(self) -> None:
        """Listen to the simulator. The owner calls this in each of its turns."""
        if self.truth is not None:
            self.truth.turn(monotonic())

    def _begin_trail(self, outbox: TextFeed, number: int) -> None:
        """Forget the way of a robot that was carried: it did not drive from there to here."""
        self.robots[number - 1].trail = Trail()
        outbox.text("trail", [], number)

    def close(self) -> None:
        """Listen no more."""
        if self.truth is not None:
            self.truth.close()


def _name_of(robot: ClientRobot) -> str:
    """Return the name of a robot, or its port as long as it has not answered."""
    return str(robot.entry["name"])
