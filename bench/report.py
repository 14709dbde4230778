#!/usr/bin/python3
"""What it costs to read a run from a bag, per GB, beside a bare loop over rosbag.Bag(path).read_messages().

    ./pioneer shell /usr/bin/python3 bench/report.py            # ten minutes; writes bench/report.md
    ./pioneer shell /usr/bin/python3 bench/report.py --quick    # a minute, small bags; writes nothing
    ./pioneer shell /usr/bin/python3 bench/report.py --huge 10  # once: a bag of so many GB with images, read_run alone

`--no-images` leaves the images out of that bag.

The bags are made, read, and removed: one of what record.launch keeps of a robot that drives all the time, and one with
camera images in it. Each reading is a process of its own, the two kinds by turns; its time is the processor's, its
memory the most it ever held (getrusage). A file that was just written lies in memory, so disks do not count.
Exit status 1 when memory grows with the size of the bag, or read_run takes longer than the bare loop.
"""

import argparse
import json
import math
import os
import platform
import random
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from io import BytesIO
from typing import Any, Dict, Iterator, List, NamedTuple, Tuple

HERE = os.path.dirname(os.path.abspath(__file__))
RESULTS = os.path.join(HERE, "report.md")
MB = 1000 * 1000
SPEED, RATE = 0.2, 10           # m/s and Hz of the robot
IMAGE = (640, 480)              # rgb8, 10 Hz: 9 MB a second
GROWTH = 1.3                    # of memory from the small bag to the large one, that is still no growth
REPEATS = 3


class Case(NamedTuple):
    """A kind of bag."""

    name: str
    images: bool
    compression: str
    sizes: Tuple[int, ...]
    """MB before compression"""


CASES = (
    Case("the robot's topics", False, "none", (100, 1000)),
    Case("the same and camera images", True, "none", (100, 1000)),
    Case("the robot's topics, lz4", False, "lz4", (100,)),
    Case("the robot's topics, bz2", False, "bz2", (100,)),
)
READERS = ("bare", "run")


def steps() -> Iterator[Dict[str, Any]]:
    """Yield the messages of one moment after another, by topic."""
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
    from geometry_msgs.msg import TransformStamped, Twist
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import Image, JointState
    from tf2_msgs.msg import TFMessage

    from pioneer_control import msg

    chance = random.Random(1)
    pose, image = Odometry(), Image(width=IMAGE[0], height=IMAGE[1], encoding="rgb8", step=3 * IMAGE[0])
    pose.header.frame_id, pose.child_frame_id, image.header.frame_id = "odom", "base_link", "camera"
    image.data = bytes(3 * IMAGE[0] * IMAGE[1])
    transform = TransformStamped(child_frame_id="base_link")
    transform.header.frame_id = "odom"
    tasks = ("Link", "Battery", "Motors", "Stall", "Bumpers", "Temperature")
    health = DiagnosticArray(status=[
        DiagnosticStatus(name="pioneer/p2os: %s" % task, message="as it should be",
                         values=[KeyValue("Value", "12.3")] * 5) for task in tasks])
    still = {
        "/tf": TFMessage([transform] * 2), "/pioneer/joint_states": JointState(
            name=["left", "right"], position=[0.0, 0.0], velocity=[0.0, 0.0]),
        "/pioneer/battery_state": msg.BatteryState(voltage=12.5), "/pioneer/motor_state": msg.MotorState(state=1),
        "/pioneer/stall": msg.Stall(),
        "/pioneer/bumpers": msg.Bumpers(front=[False] * 5, rear=[False] * 5),
        "/pioneer/gripper_state": msg.GripperState(),
        "/pioneer/dio": msg.DIO(count=16), "/pioneer/aio": msg.AIO(voltages_count=1, voltages=[0.0])}
    step = 0
    while True:
        heading = 0.5 * math.sin(step / 200) + step / 5000
        pose.pose.pose.position.x += SPEED / RATE * math.cos(heading)
        pose.pose.pose.position.y += SPEED / RATE * math.sin(heading)
        pose.pose.pose.orientation.z, pose.pose.pose.orientation.w = math.sin(heading / 2), math.cos(heading / 2)
        pose.twist.twist.linear.x = SPEED + chance.uniform(-0.01, 0.01)
        ranges = [round(chance.uniform(0.3, 6.0), 3) for _ in range(16)]
        moment = {"/pioneer/pose": pose, "/pioneer/ground_truth": pose,
                  "/pioneer/sonar": msg.SonarArray(ranges_count=16, ranges=ranges), **still}
        command = Twist()
        command.linear.x, command.angular.z = SPEED, chance.uniform(-0.3, 0.3)
        moment["/pioneer/cmd_vel"] = command
        if step % RATE == 0:
            moment["/diagnostics"] = health
        moment["/camera/image_raw"] = image
        yield moment
        step += 1


def write(path: str, case: Case, size: int) -> float:
    """Write a bag of so many MB before compression. Returns the length (s) of its run."""
    from pioneer_control.bags.writer import BagWriter

    writer, connections, bytes_of, written = BagWriter(path, case.compression), {}, {}, 0
    for step, moment in enumerate(steps()):
        for number, (topic, message) in enumerate(moment.items()):
            if topic == "/camera/image_raw" and not case.images:
                continue
            if topic not in connections:
                header = dict(topic=topic, type=message._type, md5sum=message._md5sum,
                              message_definition=message._full_text)
                connections[topic] = writer.connect(topic, header)
            often = "/pioneer/pose", "/pioneer/ground_truth", "/pioneer/sonar", "/pioneer/cmd_vel"
            if topic not in bytes_of or topic in often:
                buffer = BytesIO()
                message.serialize(buffer)
                bytes_of[topic] = buffer.getvalue()
            writer.write(connections[topic], bytes_of[topic], 10 ** 18 + step * 10 ** 9 // RATE + number)
            written += len(bytes_of[topic]) + 46
        if written > size * MB:
            writer.close()
            return step / RATE


def read(reader: str, path: str) -> Dict[str, float]:
    """Read a bag. measured() runs this in a process of its own. Returns the processor time (s), the peak memory (MB),
    and how many messages or poses were read.
    """
    if reader == "bare":
        import rosbag

        begin = time.process_time()
        count = sum(1 for _ in rosbag.Bag(path).read_messages())
    else:
        import pioneer_control.bags.run  # noqa: F401  # what read_run imports is not its time
        from pioneer_control.bags.run import read_run

        begin = time.process_time()
        run = read_run(path)
        count = len(run.odometry.time)
        assert not run.damage, run.damage
    return dict(seconds=time.process_time() - begin, memory=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
                count=count)


def measured(reader: str, path: str) -> Dict[str, float]:
    """Run read() in a process of its own, and return what it measured."""
    done = subprocess.run([sys.executable, os.path.abspath(__file__), "--read", reader, path], stdout=subprocess.PIPE,
                          check=True)
    return json.loads(done.stdout.decode())


def spread(values: List[float], form: str = "%.1f") -> str:
    """Return the median and the range."""
    return "%s (%s to %s)" % (form % statistics.median(values), form % min(values), form % max(values))


def compare(case: Case, size: int, folder: str, repeats: int) -> Tuple[str, float, float]:
    """Return the rows of the table, and of read_run the peak memory (MB) and the ratio."""
    path = os.path.join(folder, "run.bag")
    seconds = write(path, case, size)
    try:
        results: Dict[str, List[Dict[str, float]]] = {reader: [] for reader in READERS}
        for _ in range(repeats):
            for reader in READERS:
                results[reader].append(measured(reader, path))
        kept = os.path.getsize(path) / MB
    finally:
        os.remove(path)
    per_gb = {reader: [result["seconds"] / size * 1000 for result in results[reader]] for reader in READERS}
    ratios = [run / bare for run, bare in zip(per_gb["run"], per_gb["bare"])]
    memory = {reader: statistics.median(result["memory"] for result in results[reader]) for reader in READERS}
    row = ("| %s | %s | %.0f | %.1f | %s | %s | %s "
           "| %.0f | %.0f |" % (case.name, size, kept, seconds / 60, spread(per_gb["bare"]), spread(per_gb["run"]),
                                spread(ratios, "%.2f"), memory["bare"], memory["run"]))
    return row, memory["run"], statistics.median(ratios)


HEADING = ("| bag | MB of messages | MB of file | min | bare loop, s per GB | read_run, s per GB | ratio "
           "| bare loop, peak MB | read_run, peak MB |\n"
           "|---|---|---|---|---|---|---|---|---|")


def huge(size: int, case: Case, folder: str) -> int:
    """Read one bag of so many GB with read_run alone."""
    path = os.path.join(folder, "run.bag")
    begin = time.monotonic()
    minutes = write(path, case, size * 1000) / 60
    size_gb, seconds = os.path.getsize(path) / 1e9, time.monotonic() - begin
    print("%s, %.2f GB, %.1f min: written in %.0f s" % (case.name, size_gb, minutes, seconds), flush=True)
    try:
        begin = time.monotonic()
        result = measured("run", path)
    finally:
        os.remove(path)
    seconds = time.monotonic() - begin
    print("read_run: %.1f s of the processor, %.1f s, peak %.0f MB, %s poses" % (
        result["seconds"], seconds, result["memory"], result["count"]))
    return 0


def main() -> int:
    """Measure all cases. Returns 1 when a limit is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="small bags, once")
    parser.add_argument("--huge", type=int, metavar="GB", help="one bag of this size with images, read_run alone")
    parser.add_argument("--no-images", action="store_true", help="with --huge: the robot's topics alone")
    parser.add_argument("--folder", help="where to make the bags (default: the system's for temporary files)")
    parser.add_argument("--read", nargs=2, metavar=("READER", "BAG"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.read:
        print(json.dumps(read(*options.read)))
        return 0
    with tempfile.TemporaryDirectory(prefix="pioneer-report-", dir=options.folder) as folder:
        if options.huge:
            return huge(options.huge, CASES[0 if options.no_images else 1], folder)
        rows, wrong = [], []
        print(HEADING, flush=True)
        for case in CASES:
            peaks = []
            for size in [max(1, size // 20) for size in case.sizes] if options.quick else case.sizes:
                row, peak, ratio = compare(case, size, folder, 1 if options.quick else REPEATS)
                print(row, flush=True)
                rows.append(row)
                peaks.append(peak)
                if ratio > 1:
                    wrong.append("%s, %s MB: %.2f of the bare loop's time" % (case.name, size, ratio))
            if peaks[-1] > GROWTH * peaks[0]:
                wrong.append("%s: memory grows with the size, from %.0f to %.0f MB" % (case.name, peaks[0], peaks[-1]))
    for sentence in wrong:
        print(sentence, file=sys.stderr)
    if not options.quick:
        with open(RESULTS, encoding="utf-8") as file:
            head, mark, tail = file.read().partition("\n| bag |")
        rest = tail.partition("\n\n")[2]
        with open(RESULTS, "w", encoding="utf-8") as file:
            file.write("\n".join([head, HEADING, *rows, "", rest]))
        print("%s: %s, %s processors" % (RESULTS, platform.python_version(), os.cpu_count()))
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
