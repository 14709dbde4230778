"""Read and check the list of the topics to record: ``config/record.yaml``.

::

    always:               groups that are always recorded
      GROUP:
        TOPIC: reason     /TOPIC is recorded once; TOPIC is recorded in the namespace of each robot
    also:                 groups that are recorded only if --also names them
      GROUP:
        TOPIC: reason

The reason is for people. No program uses it. A topic that is listed twice is recorded once.
"""

import os
import re
from typing import Any, Iterable, Iterator, NamedTuple, Optional, Sequence, Tuple

import yaml

from ...errors import UsageError
from ...parameters import nearest

SECTIONS = {"always": False, "also": True}
"""The sections of the list. The value is True if a group of the section is recorded only when --also names it."""
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*")
"""Matches the name of a robot or of a topic, without a slash at the begin."""


class KeptTopic(NamedTuple):
    """One row of the list of topics to record."""

    topic: str
    """the name in the list: /tf is one topic, pose is a topic in the namespace of each robot"""
    group: str
    asked_for: bool
    """whether the topic is recorded only when --also names its group"""


def load_list(path: Optional[str] = None) -> Tuple[KeptTopic, ...]:
    """Read a list of topics to record.

    Args:
        path: the file of the list. None or empty: config/record.yaml of this package.

    Raises:
        UsageError: the file cannot be read, or is not a legal list. The error says where.
    """
    if not path:
        import rospkg

        path = os.path.join(rospkg.RosPack().get_path("pioneer_control"), "config", "record.yaml")
    path = os.path.expanduser(path)
    try:
        with open(path, encoding="utf-8") as file:
            return tuple(_rows(yaml.safe_load(file)))
    except UsageError as error:
        raise UsageError("%s: %s" % (path, error)) from None
    except OSError as error:
        raise UsageError("cannot read the list of topics %s: %s" % (path, error.strerror)) from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, "problem_mark", None)
        where = ", line %s" % (mark.line + 1) if mark else ""
        raise UsageError("%s%s: %s; a row is 'topic: reason'"
                         % (path, where, getattr(error, "problem", None) or error)) from error


def _rows(given: Any) -> Iterator[KeptTopic]:
    """Check the content of a list of topics and yield its rows. `given` is the value that YAML read from the file.

    Raises:
        UsageError: the content is not a legal list.
    """
    for section, groups in _items("the list", given):
        if section not in SECTIONS:
            raise UsageError("no section is called %r; there are %s" % (section, " and ".join(SECTIONS)))
        for group, topics in _items("section %r" % section, groups):
            for topic, _ in _items("group %r" % group, topics):
                if not NAME.fullmatch(topic[topic.startswith("/"):]):
                    raise UsageError("%r in group %r is no name of a topic: give one like pose, p2os/wire or /tf"
                                     % (topic, group))
                yield KeptTopic(topic, group, SECTIONS[section])


def _items(what: str, given: Any) -> Iterator[Tuple[str, Any]]:
    """Yield the keys and values of a mapping. None counts as an empty mapping. `what` names the mapping in errors.

    Raises:
        UsageError: `given` is not a mapping, or a key is not a text.
    """
    if not isinstance(given, (dict, type(None))):
        raise UsageError("%s is to have rows 'name: ...', not %r" % (what, given))
    for key, value in (given or {}).items():
        if not isinstance(key, str):
            raise UsageError("%s has a row %r, which is no text: put it in quotes" % (what, key))
        yield key, value


def groups_to_ask_for(rows: Iterable[KeptTopic]) -> Tuple[str, ...]:
    """Return the names of the groups that are recorded only when --also names them."""
    return tuple(dict.fromkeys(row.group for row in rows if row.asked_for))


def whole_name(robot: str, topic: str) -> str:
    """Return the full name of a topic of a robot. `robot` is its namespace; "" is the root namespace."""
    return "/%s/%s" % (robot, topic) if robot else "/" + topic


def topics_of(rows: Sequence[KeptTopic], robots: Sequence[str], also: Sequence[str] = ()) -> Tuple[str, ...]:
    """Return the full names of all topics to record.

    Args:
        rows: the rows of the list of topics.
        robots: the namespaces of the robots, without slashes at their ends. "" is the root namespace.
        also: the groups that --also names.

    Raises:
        UsageError: the list has no group with a name in `also`.
    """
    there = groups_to_ask_for(rows)
    for group in also:
        if group not in there:
            near = nearest(group, there)
            raise UsageError("no group %r can be asked for with also%s; there are: %s" % (
                group, ": did you mean %r?" % near if near else "", ", ".join(there) or "none"))
    kept = [row.topic for row in rows if not row.asked_for or row.group in also]
    own = [whole_name(robot, topic) for robot in robots for topic in kept if not topic.startswith("/")]
    return tuple(dict.fromkeys(own + [topic for topic in kept if topic.startswith("/")]))
