"""Stands beside ``rosbag record``: publishes the recording's description, watches the disk, says what is missing. Ends with the recorder."""

import os
import threading
import xmlrpc.client
from time import monotonic
from typing import Any, Callable, Dict, Iterable, Iterator, Optional, Sequence, Tuple

import rosgraph
import rospy
from std_msgs.msg import String

from ...ros_node import NO_ANSWER, Impatient, init_node
from .description import Description, nodes_of, now, text_of, versions
from .disk import USUAL_RATE, DiskWatch, Notice, Sample
from .start import PATIENCE, WHAT_TO_DO, Recording, free_space
from .topics import whole_name

TICK = 0.2
"""s between two looks whether the recorder is there."""
LOOK = 3.0
"""s between two looks at nodes, parameters and the disk."""
LONGER = 1.2
"""Each description that is published makes the next wait so much longer: a parameter that flickers fills no bag."""
BEGIN = 5.0
"""s for which rosbag may first list all it subscribes to, so that what is said here stands below."""
GRACE = 10.0
"""s after which it is said what nobody publishes; drivers start beside the recorder."""
NO_CLOCK = Notice("warning", "nothing is recorded yet: this master has simulated time (/use_sim_time), perhaps of an earlier replay, and nobody tells it "
                  "on /clock. For a robot: end this, rosparam set /use_sim_time false, and start it again")
SAY = {"info": rospy.loginfo, "warning": rospy.logwarn, "error": rospy.logerr}


class Descriptions:
    """Publishes the description whenever something in it has changed.

    Args:
        recording: what it is of.
        publish: takes the text.
    """

    def __init__(self, recording: Recording, publish: Callable[[str], None]) -> None:
        self._recording = {"date": now(), "robots": list(recording.robots), "file": recording.file, "topics": list(recording.topics)}
        self._versions = versions()
        self._publish = publish
        self._last: Any = None
        self._wait, self._due = LOOK, 0.0
        self._parts = 1

    def look(self, time: float, state: Sequence[Any], parameters: Dict[str, Any], parts: int = 1) -> None:
        """`time` in s; `state`: what the master's getSystemState() returned; `parts`: so many files there are. In each it is said anew."""
        seen = nodes_of(state), parameters
        if parts == self._parts and (seen == self._last or time < self._due):
            return
        self._parts = parts
        self._last = seen
        self._publish(text_of(Description(self._recording, self._versions, *seen)))
        self._due = time + self._wait
        self._wait *= LONGER


def silent(recording: Recording, state: Sequence[Any]) -> Iterator[Notice]:
    """What nobody publishes although it was meant to be recorded: of what the master's getSystemState() returned."""
    published = {topic for topic, nodes in state[0] if nodes}
    robots = sorted({topic.rpartition("/")[0].strip("/") for topic in published if topic.endswith("/pose")})
    gone = []
    for robot in recording.robots:
        own = not robot or {topic for topic in published if topic.startswith("/%s/" % robot) and not topic.endswith("/recording")}
        if not own:
            gone.append(robot)
            yield Notice("warning", "nothing is published under /%s: is that the robot's name, and does its driver run? " % robot
                         + ("There are: %s" % ", ".join(robots) if robots else "There is no robot at all yet")
                         + ". What comes later is recorded")
    for topic in recording.asked_for:
        if topic not in published and not any(topic.startswith("/%s/" % robot) for robot in gone):
            how = " (set the driver's publish_wire)" if topic.endswith("/wire") else ""
            yield Notice("warning", "nobody publishes %s, which was asked for%s" % (topic, how))


def seen_by(master: Any) -> Optional[Tuple[Sequence[Any], Dict[str, Any]]]:
    """Nodes and parameters; None when the master does not say."""
    try:
        return master.getSystemState(rospy.get_name())[2], master.getParam(rospy.get_name(), "/")[2]
    except NO_ANSWER:
        return None


def begins(recording: Recording, goes_on: Callable[[], bool], tell: Callable[[Iterable[Notice]], None]) -> bool:
    """Wait until there is a bag, which needs a time; whether that came before the end. `goes_on`: waits a moment, False at the end."""
    start, told = monotonic(), False
    while not recording.parts:
        if not goes_on():
            return False
        if monotonic() < start + BEGIN:
            continue
        if rospy.get_time():
            break   # only slow
        if not told:
            told = True
            tell([NO_CLOCK])
    return True


def say(notices: Iterable[Notice]) -> None:
    """Into the log."""
    for severity, text in notices:
        SAY[severity]("%s", text)


def sample(recording: Recording) -> Sample:
    """The disk and the recording as they are."""
    return Sample(monotonic(), free_space(recording.folder), sum(_size(path) for path in recording.parts))


def _size(path: str) -> int:
    try:
        return os.path.getsize(path)
    except OSError:     # it was just renamed
        return 0


def attend(recording: Recording, recorder: int, name: str, notices: Sequence[Notice]) -> None:
    """Run as a node of this name, as a child of the recorder (its process id), until that ends. `notices` are said first."""
    init_node(name)
    stop = threading.Event()
    rospy.on_shutdown(stop.set)
    start = monotonic()
    if not begins(recording, lambda: os.getppid() == recorder and not stop.wait(TICK), say):
        return
    say(notices)
    parts = ", a new part each %s %s" % (recording.split[1], "MB" if recording.split[0] == "size" else "s") if recording.split[0] else ""
    rospy.loginfo("recording %s: %d topics into %s (%s%s)", ", ".join("/" + robot for robot in recording.robots), len(recording.topics),
                  recording.file, recording.compression, parts)
    disk = DiskWatch(recording.folder, recording.keep_free, USUAL_RATE[recording.compression] * len(recording.robots))
    say([disk.first(sample(recording))])
    publishers = [rospy.Publisher(whole_name(robot, "recording"), String, queue_size=1, latch=True) for robot in recording.robots]
    descriptions = Descriptions(recording, lambda text: [publisher.publish(text) for publisher in publishers])
    master = xmlrpc.client.ServerProxy(rosgraph.get_master_uri(), transport=Impatient(PATIENCE))
    due, told = start, False
    while not rospy.is_shutdown() and os.getppid() == recorder:
        if monotonic() >= due:
            due = monotonic() + LOOK
            say(disk.look(sample(recording)))
            seen = seen_by(master)
            if seen:
                descriptions.look(monotonic(), *seen, max(1, len(recording.parts)))
                if not told and monotonic() > start + GRACE:
                    told = True
                    say(silent(recording, seen[0]))
        stop.wait(TICK)
    if not rospy.is_shutdown():
        say([looking_back(recording, disk.full)])


def looking_back(recording: Recording, full: bool) -> Notice:
    """What to say when the recorder has ended and nobody told us to end too. `full`: there was no room left."""
    there = recording.parts
    unfinished = [path for path in there if path.endswith(".active")]
    if unfinished:
        return Notice("error", "the recorder was killed, or failed. %s %s" % (unfinished[-1], WHAT_TO_DO.format(file=unfinished[-1])))
    last = there[-1] if there else "no bag"
    if full:
        return Notice("error", "the recording has ended because the disk is full: %s is closed and whole. Make room, and start another one" % last)
    return Notice("info", "the recording has ended: %s is closed" % last)
