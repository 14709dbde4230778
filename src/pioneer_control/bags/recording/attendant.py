"""Runs beside ``rosbag record``, and ends with it: publishes the recording's description, and says what is missing."""

import datetime
import os
import shutil
import threading
from time import monotonic
from typing import Any, Callable, Dict, Iterable, Iterator, Sequence

import rosgraph
import rospy
from std_msgs.msg import String

from ...ros_node import NO_ANSWER, init_node, peer
from .description import Description, nodes_of, text_of, versions
from .plan import PATIENCE, USUAL_RATE, WHAT_TO_DO, LogLine, RecordingPlan, in_words, room
from .topics import whole_name

TICK = 0.2
"""s between two checks that the recorder is there."""
LOOK = 3.0
"""s between two looks at the nodes and parameters of the master."""
LONGER = 1.2
"""How many times longer the wait after each published description is: a parameter that flickers fills no bag."""
BEGIN = 5.0
"""s that rosbag has to list all it subscribes to. What is said here then stands below that list."""
GRACE = 10.0
"""s from the start until the node says which topics have no publisher; drivers start beside the recorder."""
NO_CLOCK = LogLine("warning",
                   "nothing is recorded yet: this master has simulated time (/use_sim_time), perhaps of an earlier "
                   "replay, and nothing publishes /clock. For a robot: end this, rosparam set /use_sim_time false, and "
                   "start it again")
SAY = {"info": rospy.loginfo, "warning": rospy.logwarn, "error": rospy.logerr}


class Descriptions:
    """Publishes the description whenever something in it has changed.

    Args:
        plan: of the recording.
        publish: takes the text.
    """

    def __init__(self, plan: RecordingPlan, publish: Callable[[str], Any]) -> None:
        date = datetime.datetime.now().astimezone().isoformat(sep=" ", timespec="seconds")
        self._recording = {"date": date, "robots": list(plan.robots), "file": plan.file, "topics": list(plan.topics)}
        self._versions = versions()
        self._publish = publish
        self._last: Any = None
        self._wait, self._due = LOOK, 0.0
        self._parts = 1

    def look(self, time: float, state: Sequence[Any], parameters: Dict[str, Any], parts: int = 1) -> None:
        """Publish the description if something in it has changed, and if it is due.

        Args:
            time: now, s.
            state: what the master's getSystemState() returned.
            parameters: of the whole parameter server.
            parts: number of files of the recording. Each new file gets the description.
        """
        seen = nodes_of(state), parameters
        if parts == self._parts and (seen == self._last or time < self._due):
            return
        self._parts = parts
        self._last = seen
        self._publish(text_of(Description(self._recording, self._versions, *seen)))
        self._due = time + self._wait
        self._wait *= LONGER


def silent(plan: RecordingPlan, state: Sequence[Any]) -> Iterator[LogLine]:
    """What to say of topics that are to be recorded and have no publisher.

    Args:
        plan: of the recording.
        state: what the master's getSystemState() returned.
    """
    published = {topic for topic, nodes in state[0] if nodes}
    # the recorder itself publishes the recording's description
    heard = [topic for topic in published if not topic.endswith("/recording")]
    gone = [robot for robot in plan.robots
            if robot and not any(topic.startswith("/%s/" % robot) for topic in heard)]
    robots = sorted({topic.rpartition("/")[0].strip("/") for topic in published if topic.endswith("/pose")})
    there = "There are: " + ", ".join(robots) if robots else "There is no robot at all yet"
    for robot in gone:
        yield LogLine("warning", "nothing is published under /%s: is that the robot's name, and does its driver run? "
                      "%s. What comes later is recorded" % (robot, there))
    for topic in plan.asked_for:
        if topic not in published and not any(topic.startswith("/%s/" % robot) for robot in gone):
            yield LogLine("warning", "nothing publishes %s, which was asked for%s"
                          % (topic, " (set the driver's publish_wire)" if topic.endswith("/wire") else ""))


def begins(plan: RecordingPlan, goes_on: Callable[[], bool], tell: Callable[[Iterable[LogLine]], None]) -> bool:
    """Wait until there is a bag. rosbag begins one when ROS has a time.

    Args:
        plan: of the recording.
        goes_on: waits a moment; False when the recorder has ended.
        tell: takes what is to be said.

    Returns:
        Whether there is a bag before the recorder ends.
    """
    start, told = monotonic(), False
    while not plan.parts:
        if not goes_on():
            return False
        is_late = monotonic() >= start + BEGIN
        if is_late and rospy.get_time():
            break   # it is only slow
        if is_late and not told:
            told = True
            tell([NO_CLOCK])
    return True


def say(lines: Iterable[LogLine]) -> None:
    """Log lines."""
    for severity, text in lines:
        SAY[severity]("%s", text)


def attend(plan: RecordingPlan, recorder: int, name: str, lines: Sequence[LogLine]) -> None:
    """Run as a node, until the recorder ends.

    Args:
        plan: of the recording.
        recorder: process id of the recorder, which is the parent of this process.
        name: of the node.
        lines: what is said first.
    """
    init_node(name)
    stop = threading.Event()
    rospy.on_shutdown(stop.set)

    def goes_on() -> bool:
        return os.getppid() == recorder and not stop.wait(TICK)

    start = due = monotonic()
    if not begins(plan, goes_on, say):
        return
    say([*lines, first_words(plan, shutil.disk_usage(plan.folder).free)])
    publishers = [rospy.Publisher(whole_name(robot, "recording"), String, queue_size=1, latch=True)
                  for robot in plan.robots]
    descriptions = Descriptions(plan, lambda text: [publisher.publish(text) for publisher in publishers])
    master = peer(rosgraph.get_master_uri(), PATIENCE)
    node, told = rospy.get_name(), False
    while goes_on():
        if monotonic() < due:
            continue
        due = monotonic() + LOOK
        try:
            state, parameters = master.getSystemState(node)[2], master.getParam(node, "/")[2]
        except NO_ANSWER:
            continue
        descriptions.look(monotonic(), state, parameters, max(1, len(plan.parts)))
        if not told and monotonic() > start + GRACE:
            told = True
            say(silent(plan, state))
    if not stop.is_set():
        say([last_words(plan, shutil.disk_usage(plan.folder).free)])


def first_words(plan: RecordingPlan, free: int) -> LogLine:
    """What to say at first: what is recorded, and for how long there is room. `free`: bytes free on the disk."""
    kind, amount = plan.split
    parts = ", a new part each %s %s" % (amount, "MB" if kind == "size" else "s") if kind else ""
    return LogLine("info", "recording %s: %d topics into %s (%s%s). %s free: %s" % (
        ", ".join("/" + robot for robot in plan.robots), len(plan.topics), plan.file, plan.compression, parts,
        in_words(free), room(free, plan.keep_free, USUAL_RATE[plan.compression] * len(plan.robots))))


def last_words(plan: RecordingPlan, free: int) -> LogLine:
    """What to say when the recorder has ended and nothing asked this node to end. `free`: bytes free on the disk."""
    there = plan.parts
    unfinished = [path for path in there if path.endswith(".active")]
    if unfinished:
        return LogLine("error", "the recorder was killed, or failed. %s %s"
                       % (unfinished[-1], WHAT_TO_DO % unfinished[-1]))
    last = there[-1] if there else "no bag"
    if free <= plan.keep_free:
        return LogLine("error",
                       "the recording has ended because the disk is full: %s is closed and whole. Make room, and "
                       "start another one" % last)
    return LogLine("info", "the recording has ended: %s is closed" % last)
