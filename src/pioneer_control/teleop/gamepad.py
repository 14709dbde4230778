"""A gamepad in /dev/input: its events to what the hand wants. Only `find` and `Gamepad` touch the device.

The robot drives only while a shoulder button is held: it is the deadman. A gamepad that is unplugged is an error of
the device, and means stand. One on a radio link of its own may fall silent without an error; python3-evdev tells a
Bluetooth device by its bus, and for such a device a long silence lets go of the deadman, too.
"""

import math
import os
from typing import Any, Dict, List, Optional, Tuple

from ..errors import PortError
from .hand import STAND, Wish

EV_KEY, EV_ABS = 1, 3
BUS_BLUETOOTH = 5
AXES = {0: "turn", 1: "forward"}
"""The axes of the left stick: ABS_X and ABS_Y. Right and down are their positive ends."""
DEADMEN = {310, 311}
"""BTN_TL and BTN_TR, the shoulder buttons."""
BUTTONS = {305: "stop", 315: "motors_on", 314: "motors_off", 304: "close", 308: "open", 307: "open"}
"""BTN_EAST, BTN_START, BTN_SELECT, BTN_SOUTH, and BTN_WEST or BTN_NORTH: the names of actions."""
DEAD_ZONE = 0.15
"""The share of the way of a stick in which it counts as centred."""
SILENCE = 1.0
"""Time (s) without an event after which the deadman of a Bluetooth gamepad is let go."""


class Axis:
    """One axis of a stick: its least and greatest value."""

    def __init__(self, least: int, greatest: int) -> None:
        self._middle, self._reach = (least + greatest) / 2, max(1.0, (greatest - least) / 2)

    def share(self, value: int) -> float:
        """Return the place of the stick from -1 to 1, 0 within the dead zone, without a jump at its end."""
        share = max(-1.0, min(1.0, (value - self._middle) / self._reach))
        return math.copysign(max(0.0, abs(share) - DEAD_ZONE) / (1 - DEAD_ZONE), share)


class StickHand:
    """The hand on a gamepad: events in, wishes and actions out. Pure.

    Args:
        axes: the axes of the left stick by their code: see AXES.
        may_fall_silent: whether the gamepad may be gone without an error of the device.
    """

    def __init__(self, axes: Dict[int, Axis], may_fall_silent: bool = False) -> None:
        self._axes = axes
        self._may_fall_silent = may_fall_silent
        self._shares = {"forward": 0.0, "turn": 0.0}
        self._held: Dict[int, bool] = {}
        self._heard_at = -math.inf

    def event(self, kind: int, code: int, value: int, now: float) -> Optional[str]:
        """Take one event of the device. Return the name of an action when a button was pressed that has one."""
        self._heard_at = now
        if kind == EV_ABS and code in AXES and code in self._axes:
            self._shares[AXES[code]] = -self._axes[code].share(value)
        elif kind == EV_KEY and code in DEADMEN:
            self._held[code] = bool(value)
        elif kind == EV_KEY and value == 1:
            return BUTTONS.get(code)
        return None

    def wish(self, now: float) -> Wish:
        """Return what the hand wants now: to stand, unless a shoulder button is held."""
        if self._may_fall_silent and now - self._heard_at > SILENCE:
            self._held = {}
        return Wish(**self._shares) if any(self._held.values()) else STAND

    def let_go(self) -> None:
        """Forget the deadman, until it is pressed anew."""
        self._held = {}


class Gamepad:
    """A gamepad that is read without waiting.

    Args:
        device: an evdev.InputDevice.

    Attributes:
        name: what the device calls itself.
        hand: what the hand wants.
    """

    def __init__(self, device: Any) -> None:
        self._device = device
        self.name = "%s (%s)" % (device.name, device.path)
        axes = {code: Axis(info.min, info.max) for code, info in device.capabilities().get(EV_ABS, [])}
        self.hand = StickHand(axes, device.info.bustype == BUS_BLUETOOTH)

    def fileno(self) -> int:
        """Return the file descriptor, to wait for events."""
        return int(self._device.fileno())

    def read(self, now: float) -> List[str]:
        """Take all events that wait. Return the names of the actions whose buttons were pressed.

        Raises OSError when the device is gone.
        """
        actions: List[str] = []
        while True:
            event = self._device.read_one()
            if event is None:
                return actions
            action = self.hand.event(event.type, event.code, event.value, now)
            if action is not None:
                actions.append(action)

    def close(self) -> None:
        """Let the device go."""
        self._device.close()


def find(path: str = "") -> Optional[Gamepad]:
    """Open the gamepad at a path, or the first one that this user may read; None when there is none.

    Raises:
        PortError: a path was given, and there is no gamepad that may be read.
    """
    import evdev    # from Debian: python3-evdev. needed only with a gamepad

    for found in [path] if path else sorted(evdev.list_devices()):
        try:
            device = evdev.InputDevice(found)
        except OSError as error:
            if not path:
                continue
            raise PortError("%s: %s. Which there are: ls -l /dev/input/by-id; the group input may read them"
                            % (path, os.strerror(error.errno or 0))) from error
        if _is_gamepad(device.capabilities()):
            return Gamepad(device)
        device.close()
    if path:
        raise PortError("%s is no gamepad: it has no stick, or no shoulder button" % path)
    return None


def _is_gamepad(capabilities: Dict[int, List[Any]]) -> bool:
    axes: List[Tuple[int, Any]] = capabilities.get(EV_ABS, [])
    return {code for code, _ in axes} >= set(AXES) and bool(DEADMEN & set(capabilities.get(EV_KEY, [])))
