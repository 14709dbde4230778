"""Which topics are kept, and why: ``config/record.yaml``, read and checked.

::

    always:               kept in each recording
      GROUP:
        TOPIC: reason     a topic that begins with / is everybody's; any other is one of each robot's
    also:                 groups that are kept when asked for by name
      GROUP:
        TOPIC: reason
"""

import os
import re
from typing import Any, Iterable, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import yaml

from ...errors import UsageError
from ...parameters import nearest

SECTIONS = {"always": False, "also": True}
"""Of the list; whether its groups are kept only when asked for."""
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*")
"""A robot's name, or a topic of it."""


class KeptTopic(NamedTuple):
    """One row of the list."""

    topic: str
    """as written: /tf, or pose, which is below each robot's namespace"""
    reason: str
    group: str
    asked_for: bool
    """kept only when its group is asked for"""


def load_list(path: Optional[str] = None) -> Tuple[KeptTopic, ...]:
    """The rows of a list of topics.

    Args:
        path: its file; None or empty: the package's own list.

    Raises:
        UsageError: the file cannot be read, or makes no sense. The error says where.
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
    """The rows of a list, checked. `given`: what YAML read."""
    seen: List[str] = []
    for section, groups in _items("the list", given):
        if section not in SECTIONS:
            raise UsageError("no section is called %r; there are %s" % (section, " and ".join(SECTIONS)))
        for group, topics in _items("section %r" % section, groups):
            for topic, reason in _items("group %r" % group, topics):
                if not NAME.fullmatch(topic[topic.startswith("/"):]):
                    raise UsageError("%r in group %r is no name of a topic: give one like pose, p2os/wire or /tf"
                                     % (topic, group))
                if topic in seen:
                    raise UsageError("topic %r is there twice, the second time in group %r" % (topic, group))
                if not isinstance(reason, (str, type(None))):
                    raise UsageError("the reason of %r must be a text, not %r" % (topic, reason))
                seen.append(topic)
                yield KeptTopic(topic, reason or "", group, SECTIONS[section])


def _items(what: str, given: Any) -> Iterator[Tuple[str, Any]]:
    """Keys and values of a mapping. `what`: its name in errors."""
    if not isinstance(given, (dict, type(None))):
        raise UsageError("%s is to have rows 'name: ...', not %r" % (what, given))
    for key, value in (given or {}).items():
        if not isinstance(key, str):
            raise UsageError("%s has a row %r, which is no text: put it in quotes" % (what, key))
        yield key, value


def groups_to_ask_for(rows: Iterable[KeptTopic]) -> Tuple[str, ...]:
    """Names of the groups that are kept only when asked for."""
    return tuple(dict.fromkeys(row.group for row in rows if row.asked_for))


def whole_name(robot: str, topic: str) -> str:
    """The whole name of a topic of a robot; "" is a robot without a namespace."""
    return "/%s/%s" % (robot, topic) if robot else "/" + topic


def topics_of(rows: Sequence[KeptTopic], robots: Sequence[str], also: Sequence[str] = ()) -> Tuple[str, ...]:
    """Whole names of all topics to record.

    Args:
        rows: the list.
        robots: namespaces, without slashes at the ends; "" is a robot without a namespace.
        also: groups that were asked for.

    Raises:
        UsageError: there is no such group.
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
