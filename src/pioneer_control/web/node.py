"""The ROS node that serves the page for all robots of the graph: ``roslaunch pioneer_control web.launch``.

This process has the seats, and publishes what persons drive; its child serves the browsers. When either ends in any
way, the drivers hear nothing more on ``teleop/cmd_vel``, and their robots stand within ``teleop_timeout``.
"""

import contextlib
import os
import sys
from dataclasses import dataclass
from time import monotonic
from typing import Any, Mapping, Tuple

import rospy

from ..errors import ParameterError, PioneerError
from ..parameters import Switch, Text, Whole, check, parameter
from ..ros_node import init_node
from .graph import Graph
from .owner import Owner
from .site import KEY, Site, open_site


@dataclass(frozen=True)
class WebParameters:
    """The private parameters of the node."""

    port: int = parameter(8080, Whole(0, 65535), "TCP port of the page; 0: any that is free")
    share: bool = parameter(False, Switch(), "let other machines open the page")
    robots: str = parameter("", Text(empty=True), "namespaces of the robots to show, with spaces; empty: all")
    title: str = parameter("robots", Text(), "what the page is called")


def check_parameters(given: Mapping[str, Any]) -> WebParameters:
    """Check the private parameters of the node. Raises ParameterError for a wrong value or an unknown name."""
    parameters: WebParameters
    parameters, unknown = check(WebParameters, given)
    if unknown:
        raise ParameterError("~%s: there is no such parameter" % ", ~".join(unknown))
    return parameters


def serve(site: Site, wanted: Tuple[str, ...]) -> None:
    """Serve the page until ROS shuts down. ``wanted``: the namespaces of the robots to show; empty: all."""
    owner = Owner(site.listening, site.told)
    graph = Graph(owner.outbox, owner, wanted)

    def look() -> None:
        if graph.look(monotonic()):
            owner.keep(graph.robots.values())
            graph.tell()

    owner.look = look
    rospy.on_shutdown(owner.end)
    if not rospy.is_shutdown():
        owner.run()


def main() -> int:
    """Run the node. Returns the exit code: 0 after a shutdown, 1 the port is taken, 2 a wrong parameter."""
    init_node("web")
    try:
        parameters = check_parameters(rospy.get_param("~", {}))
        site = open_site(parameters.title, parameters.port, parameters.share, os.environ.get(KEY))
    except PioneerError as error:
        rospy.logfatal("%s", error)
        return 2 if isinstance(error, ParameterError) else 1
    with contextlib.closing(site):
        if site.warning:
            rospy.logwarn("%s", site.warning)
        if KEY not in os.environ:
            print(*site.welcome(), sep="\n", flush=True)    # not by the log: it must not keep the key
        serve(site, tuple(name.strip("/") for name in parameters.robots.split()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
