"""A new bag of what a re-run or a re-drive hears and says."""

import contextlib
import io
import os
import threading
import time
from typing import Any, Callable, Counter, Dict, List, Optional, Tuple

import rospy

from ...errors import UsageError
from ..command_line import say
from ..writer import BagWriter


class TopicRecorder(contextlib.AbstractContextManager):
    """Writes messages of topics, and others that it is given, into a new bag.

    ``with`` closes the bag at the end. It says where the bag is if that was not reached.

    Args:
        path: of the bag.
        now: the time that a message gets.

    Attributes:
        path: of the bag.
        newest: the newest message of each topic.
        counts: how many messages of each topic are written.
        heard_at: when the last message came; s, of the monotonic clock.

    Raises:
        UsageError: there is such a file already, or it cannot be written.
    """

    def __init__(self, path: str, now: Callable[[], rospy.Time]) -> None:
        if os.path.exists(path):
            raise UsageError("%s is there already: name another output" % path)
        try:
            self._writer: Optional[BagWriter] = BagWriter(path)
        except OSError as error:
            raise UsageError("%s cannot be written: %s" % (path, error.strerror or error)) from None
        self._connections: Dict[Tuple[str, Optional[str]], int] = {}     # by topic and publisher
        self.path, self._now = path, now
        self.newest: Dict[str, Any] = {}
        self.counts: Counter[str] = Counter()
        self.heard_at = time.monotonic()
        self._lock = threading.Lock()
        self._subscribers: List[rospy.Subscriber] = []

    def record(self, topic: str, kind: type = rospy.AnyMsg, written_as: str = "") -> None:
        """Write every message of a topic from now on, under another name where one is given."""
        self._subscribers.append(rospy.Subscriber(topic, kind, self.write, written_as or topic))

    def write(self, message: Any, topic: str) -> None:
        """Write a message with the present time; one that was heard, with what its connection said of it."""
        header = getattr(message, "_connection_header", None) or dict(
            type=message._type, md5sum=message._md5sum, message_definition=message._full_text)
        data = io.BytesIO()
        message.serialize(data)
        sender = topic, header.get("callerid")
        with self._lock:
            if self._writer is None:
                return
            if sender not in self._connections:
                self._connections[sender] = self._writer.connect(topic, dict(header, topic=topic))
            self._writer.write(self._connections[sender], data.getvalue(), self._now().to_nsec())
            self.newest[topic] = message
            self.counts[topic] += 1
            self.heard_at = time.monotonic()

    def __exit__(self, kind: Any, *about: Any) -> None:
        """Close the bag, and remove it where nothing is in it. What comes later is dropped."""
        if kind is not None and self.counts:
            say("What happened until it ended is in %s" % self.path)
        for subscriber in self._subscribers:
            subscriber.unregister()
        with self._lock:
            if self._writer is not None:
                self._writer.close()
            self._writer = None
        if not self.counts:
            os.remove(self.path)
