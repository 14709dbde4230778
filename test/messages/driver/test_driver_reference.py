"""docs/driver.md and the README list what the driver really offers: names and types of topics and services, and the
tasks of diagnostics.
"""

import pathlib
import re
from typing import List, Tuple

import pytest

from pioneer_control import standard_messages
from pioneer_control.client.health import TASKS
from pioneer_control.driver import accessory_requests, conversions, requests
from pioneer_control.driver.arm_topics import ARM_PUBLISHED, ARM_SERVICES, ARM_TOPICS
from pioneer_control.driver.parameters import DriverParameters
from pioneer_control.driver.publications import Publications

ROOT = pathlib.Path(__file__).resolve().parents[3]
REFERENCE = (ROOT / "docs" / "driver.md").read_text(encoding="utf-8")
EVERYDAY = (ROOT / "README.md").read_text(encoding="utf-8")

PUBLISHED = [(topic.name, topic.message._type) for topic in Publications._table(object(), DriverParameters())]
TAKEN = [(topic.name, topic.message._type) for topic in requests.TOPICS]
SERVED = [(service.name, service.kind._type) for service in requests.SERVICES]


def listed(text: str, chapter: str) -> List[Tuple[str, str]]:
    """Return name and type in the rows of the first table of a chapter. A type without a package is one of ours."""
    table = re.search(r"(?:^\|.*\n)+", text.partition("\n## %s\n" % chapter)[2], re.MULTILINE).group()
    return [(name, kind if "/" in kind else "pioneer_control/" + kind)
            for name, kind in re.findall(r"^\|(?: \w+ \|)? `([\w/]+)` \| ([\w/]+) \|", table, re.MULTILINE)]


def test_what_is_published():
    assert listed(REFERENCE, "What it publishes") == PUBLISHED


def test_what_is_taken():
    assert listed(REFERENCE, "What it takes") == TAKEN


def test_what_is_served():
    assert listed(REFERENCE, "Services") == SERVED


def test_what_a_pioneer_arm_publishes_takes_and_serves():
    arm = (ROOT / "docs" / "arm.md").read_text(encoding="utf-8")
    assert listed(arm, "What it publishes") == [(name, kind._type) for name, kind in ARM_PUBLISHED]
    assert listed(arm, "What it takes") == [(topic.name, topic.message._type) for topic in ARM_TOPICS]
    assert listed(arm, "Services") == [(service.name, service.kind._type) for service in ARM_SERVICES]


def test_the_tasks_of_diagnostics():
    table = re.search(r"(?:^\|.*\n)+", REFERENCE.partition("\n## Diagnostics\n")[2], re.MULTILINE).group()
    assert re.findall(r"^\| (\w+) \|", table, re.MULTILINE)[1:] == list(TASKS)


def test_what_the_readme_names_is_there():
    few = listed(EVERYDAY, "Topics and services of the driver")
    assert len(few) > 5 and set(few) <= set(PUBLISHED + TAKEN + SERVED)


@pytest.mark.parametrize("sentence, number", [
    ("for %g s at most. Otherwise it answers why not", requests.CONFIRM_TIMEOUT),
    ("`dock` and `undock` may take %g s", accessory_requests.POWER_TIMEOUT),
    ("0.0: no reading for %g s", conversions.SONAR_LIFETIME),
    ("not older than %g s", conversions.SONAR_LIFETIME),
    ("%.1f: no echo", conversions.NO_ECHO),
    ("The smallest range is %g m", standard_messages.MIN_RANGE),
    ("of the transducers, %g m above the floor", standard_messages.HEIGHT),
])
def test_a_number_in_a_sentence_is_the_constant(sentence, number):
    assert sentence % number in " ".join(REFERENCE.split())


def test_a_row_that_lies_is_seen():
    lie = REFERENCE.replace("| `pose` | nav_msgs/Odometry |", "| `pose` | geometry_msgs/Pose |")
    assert listed(lie, "What it publishes") != PUBLISHED
