"""The two programs of the first lesson, as they are printed there, in a class."""

import contextlib
import pathlib
import re
import signal
import subprocess
import sys

import pytest

from class_site import ClassSite, TruthWatch
from real_time import LIMIT, until
from web_programs import key_of, url_of

LESSON = pathlib.Path(__file__).resolve().parents[2] / "docs" / "lesson.md"
FIRST, WALL = re.findall(r"```python\n(.*?)```", LESSON.read_text(encoding="utf-8"), re.DOTALL)
ROOM = """
walls: [{corners_m: [[0, 0], [4, 0], [4, 4], [0, 4]], closed: true}]
starts: [{position_m: [2.3, 2], heading_deg: 0}]
"""


@pytest.fixture(scope="module")
def school(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lesson")
    (folder / "room.yaml").write_text(ROOM)
    with ClassSite(folder, 1, "--world", str(folder / "room.yaml")) as site:
        yield site


@pytest.fixture
def ada(school):
    """A student and her robot, which no program drives before she lets them, as in the lesson."""
    with contextlib.ExitStack() as stack:
        viewer, robot = school.joined(stack, 1, "Ada")
        viewer.picture()
        until(lambda: viewer.newest("helm"), "who commands")
        viewer.do("take", robot=robot)
        until(lambda: viewer.newest("helm")["programs"] == "locked out", "as after driving by hand")
        yield viewer, robot


def start(school, viewer, robot, text):
    """Run a program of the lesson with the line of the student's page in it."""
    line = 'Robot("%s", key="%s")' % (url_of(school, robot), key_of(viewer, robot))
    text, count = re.subn(r'Robot\("ws:.*?", key="\.\.\."\)', line, text)
    assert count == 1
    return subprocess.Popen([sys.executable, "-u", "-c", text], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            universal_newlines=True)


def let_programs_drive(viewer, robot):
    viewer.do("release", robot=robot)
    until(lambda: viewer.newest("helm")["programs"] == "free", "programs may drive")


@pytest.mark.parametrize("allowed", [False, True])
def test_first_drives_a_third_of_a_metre_when_the_student_lets_programs_drive(school, ada, allowed):
    if allowed:
        let_programs_drive(*ada)
    with start(school, *ada, FIRST) as process:
        said, errors = process.communicate(timeout=LIMIT)
    way = float(re.fullmatch(r"I have driven (\S+) m\n", said).group(1))
    assert not errors and (0.15 < way < 0.5 if allowed else way == 0)


def test_wall_turns_left_before_a_wall_until_ctrl_c(school, ada):
    let_programs_drive(*ada)
    truth, (_, robot) = TruthWatch(school.truth), ada
    with start(school, *ada, WALL) as process:
        try:
            until(lambda: truth.newest["robots"][robot - 1][3] > 0.2, "it drives")
            until(lambda: truth.newest["robots"][robot - 1][4] > 0.5, "it turns left")
        finally:
            process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=LIMIT)[1].endswith("KeyboardInterrupt\n")
    until(lambda: truth.newest["robots"][robot - 1][3:5] == [0, 0], "it stands")
