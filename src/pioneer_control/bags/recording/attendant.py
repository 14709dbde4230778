"""The attendant: a node that runs beside ``rosbag record`` and ends with it.

It publishes the description of the recording, and logs warnings about topics without a publisher.
"""

import datetime
import os
import shutil
import threading
from time import monotonic
from typing import Any, Callable, Dict, Iterator, Sequence

import rosgraph
import rospy
from std_msgs.msg import String

from ...ros_node import NO_ANSWER, init_node, peer
from ..command_line import MASTER_PATIENCE
from .description import Description, nodes_of, text_of, versions
from .plan import USUAL_RATE, WHAT_TO_DO, RecordingPlan, in_words, room
from .topics import whole_name

TICK = 0.2
"""The time (s) between two checks that the recorder still runs."""
LOOK = 3.0
"""The time (s) between two requests to the master for its nodes and parameters."""
LONGER = 1.2
"""The factor by which the wait grows after each published description.

So a parameter that changes all the time does not fill the bag with descriptions."""
BEGIN = 5.0
"""The time (s) after which a bag that does not exist yet is late."""
GRACE = 10.0
"""The time (s) from the start until the node logs which topics have no publisher.

Drivers that start together with the recorder need some time."""
NO_CLOCK = ("nothing is recorded yet: this master has simulated time (/use_sim_time), perhaps of an earlier replay, "
            "and nothing publishes /clock. For a robot: end this, rosparam set /use_sim_time false, and start it again")


class Descriptions:
    """Publishes the description of a recording whenever something in it has changed.

    Args:
        plan: the plan of the recording.
        publish: a function that publishes the text of a description.
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
        """Publish the description if nodes or parameters have changed and the wait since the last one is over.

        If the recording has a new file, publish at once, so that each file gets the description.

        Args:
            time: the present time (s).
            state: the value that the master's getSystemState() returned.
            parameters: the tree of the whole parameter server.
            parts: the number of files of the recording.
        """
        seen = nodes_of(state), parameters
        if parts == self._parts and (seen == self._last or time < self._due):
            return
        self._parts = parts
        self._last = seen
        self._publish(text_of(Description(self._recording, self._versions, *seen)))
        self._due = time + self._wait
        self._wait *= LONGER


def silent(plan: RecordingPlan, state: Sequence[Any]) -> Iterator[str]:
    """Yield a warning for each robot that publishes nothing, and for each topic of `plan.asked_for` without publisher.

    Args:
        plan: the plan of the recording.
        state: the value that the master's getSystemState() returned.
    """
    published = {topic for topic, nodes in state[0] if nodes}
    # the recorder itself publishes the recording's description
    heard = [topic for topic in published if not topic.endswith("/recording")]
    gone = [robot for robot in plan.robots
            if robot and not any(topic.startswith("/%s/" % robot) for topic in heard)]
    robots = sorted({topic.rpartition("/")[0].strip("/") for topic in published if topic.endswith("/pose")})
    there = "There are: " + ", ".join(robots) if robots else "There is no robot at all yet"
    for robot in gone:
        yield ("nothing is published under /%s: is that the robot's name, and does its driver run? %s. What comes "
               "later is recorded" % (robot, there))
    for topic in plan.asked_for:
        if topic not in published and not any(topic.startswith("/%s/" % robot) for robot in gone):
            yield ("nothing publishes %s, which was asked for%s"
                   % (topic, " (set the driver's publish_wire)" if topic.endswith("/wire") else ""))


def begins(plan: RecordingPlan, goes_on: Callable[[], bool]) -> bool:
    """Wait until rosbag has created the bag. With simulated time, rosbag creates it after the first /clock message.

    After `BEGIN` seconds without a bag it stops waiting if ROS has a time, and logs `NO_CLOCK` if ROS has no time.

    Args:
        plan: the plan of the recording.
        goes_on: a function that waits a moment, and returns False when the recorder has ended.

    Returns:
        False if the recorder ended during the wait.
    """
    start, told = monotonic(), False
    while not plan.parts:
        if not goes_on():
            return False
        is_late = monotonic() >= start + BEGIN
        if is_late and rospy.get_time():
            break   # rosbag is only slow
        if is_late and not told:
            told = True
            rospy.logwarn(NO_CLOCK)
    return True


def attend(plan: RecordingPlan, recorder: int, name: str, warning: str) -> None:
    """Run the attendant as a node until the recorder ends.

    Args:
        plan: the plan of the recording.
        recorder: the process id of the recorder, which is the parent of this process.
        name: the name of the node.
        warning: a warning to log when the bag exists. Empty: none.
    """
    init_node(name)
    stop = threading.Event()
    rospy.on_shutdown(stop.set)

    def goes_on() -> bool:
        return os.getppid() == recorder and not stop.wait(TICK)

    start = due = monotonic()
    if not begins(plan, goes_on):
        return
    if warning:
        rospy.logwarn(warning)
    rospy.loginfo(first_words(plan, shutil.disk_usage(plan.folder).free))
    publishers = [rospy.Publisher(whole_name(robot, "recording"), String, queue_size=1, latch=True)
                  for robot in plan.robots]
    descriptions = Descriptions(plan, lambda text: [publisher.publish(text) for publisher in publishers])
    master = peer(rosgraph.get_master_uri(), MASTER_PATIENCE)
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
            for text in silent(plan, state):
                rospy.logwarn(text)
    if not stop.is_set():
        last_words(plan, shutil.disk_usage(plan.folder).free)


def first_words(plan: RecordingPlan, free: int) -> str:
    """Return the first line for the log: what is recorded, and how long the free disk space lasts.

    `free` is the free space on the disk (bytes).
    """
    kind, amount = plan.split
    parts = ", a new part each %s %s" % (amount, "MB" if kind == "size" else "s") if kind else ""
    return "recording %s: %d topics into %s (%s%s). %s free: %s" % (
        ", ".join("/" + robot for robot in plan.robots), len(plan.topics), plan.file, plan.compression, parts,
        in_words(free), room(free, plan.keep_free, USUAL_RATE[plan.compression] * len(plan.robots)))


def last_words(plan: RecordingPlan, free: int) -> None:
    """Log the last line: whether the recording ended well, was killed, or filled the disk.

    `attend` logs it if the recorder ended before this node was shut down. `free` is the free disk space (bytes).
    """
    there = plan.parts
    unfinished = [path for path in there if path.endswith(".active")]
    last = there[-1] if there else "no bag"
    if unfinished:
        rospy.logerr("the recorder was killed, or failed. %s %s", unfinished[-1], WHAT_TO_DO % unfinished[-1])
    elif free <= plan.keep_free:
        rospy.logerr("the recording has ended because the disk is full: %s is closed and whole. Make room, and start "
                     "another one", last)
    else:
        rospy.loginfo("the recording has ended: %s is closed", last)
