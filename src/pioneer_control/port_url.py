"""The URL of a robot's port, and the key that may stand at its end: ``ws://host:8080/robot/7#key=KEY``.

Whoever knows the key of a robot can drive it. So show a URL only without its key.
"""

from typing import Optional, Tuple
from urllib.parse import unquote

WEB_SOCKET = ("ws://", "wss://")


def is_web_socket(url: str) -> bool:
    """Return whether a URL is that of a WebSocket."""
    return url.lower().startswith(WEB_SOCKET)


def split_key(url: str) -> Tuple[str, Optional[str]]:
    """Return a URL without its key, and the key; None if it has no key. %-escapes in the key become characters.

    All that follows # in the URL of a WebSocket is taken away, because it is nothing but a key or a mistyped one.
    """
    shown, _, fragment = url.partition("#")
    for part in fragment.split("&"):
        name, _, value = part.partition("=")
        if name.lower() == "key":
            return shown, unquote(value)
    return (shown if is_web_socket(url) else url), None


def without_key(url: str) -> str:
    """Return a URL as it may be shown to everybody: without its key."""
    return split_key(url)[0]
