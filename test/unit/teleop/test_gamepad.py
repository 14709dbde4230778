"""A gamepad's events to wishes. No gamepad is at hand where the tests run: stand-ins replace evdev devices."""

from types import SimpleNamespace

import evdev
import pytest

from pioneer_control.errors import PortError
from pioneer_control.teleop import gamepad as gamepad_module
from pioneer_control.teleop.gamepad import (
    BUS_BLUETOOTH, DEAD_ZONE, EV_ABS, EV_KEY, SILENCE, Axis, Gamepad, StickHand, find)
from pioneer_control.teleop.hand import STAND, Wish

X, Y, SHOULDER, OTHER_SHOULDER, EAST, START = 0, 1, 310, 311, 305, 315
USB = 3


class Device:
    """A stand-in for evdev.InputDevice."""

    def __init__(self, path="/dev/input/event5", bus=USB, axes=(X, Y), keys=(SHOULDER, EAST, START)):
        self.path, self.name, self.info = path, "a pad", SimpleNamespace(bustype=bus)
        self._capabilities = {EV_ABS: [(code, SimpleNamespace(min=-32768, max=32767)) for code in axes],
                              EV_KEY: list(keys)}
        self.events, self.closed = [], False

    def capabilities(self):
        return self._capabilities

    def read_one(self):
        if self.events is None:
            raise OSError(19, "No such device")
        return self.events.pop(0) if self.events else None

    def fileno(self):
        return 99

    def close(self):
        self.closed = True


@pytest.fixture
def hand():
    return StickHand({X: Axis(-32768, 32767), Y: Axis(-32768, 32767)})


def test_nothing_moves_without_the_shoulder_button(hand):
    hand.event(EV_ABS, Y, -32768, 0.0)
    assert hand.wish(0.0) == STAND
    hand.event(EV_KEY, SHOULDER, 1, 0.1)
    assert hand.wish(0.1).forward == pytest.approx(1.0)
    hand.event(EV_KEY, SHOULDER, 0, 0.2)
    assert hand.wish(0.2) == STAND


def test_up_is_forward_and_left_is_counter_clockwise(hand):
    hand.event(EV_KEY, OTHER_SHOULDER, 1, 0.0)
    hand.event(EV_ABS, Y, 32767, 0.0)
    hand.event(EV_ABS, X, -32768, 0.0)
    assert hand.wish(0.0) == pytest.approx(Wish(-1.0, 1.0), abs=1e-3)


def test_either_shoulder_button_is_enough_and_both_must_be_let_go(hand):
    hand.event(EV_ABS, Y, -32768, 0.0)
    for button, value, drives in ((SHOULDER, 1, True), (OTHER_SHOULDER, 1, True), (SHOULDER, 0, True),
                                  (OTHER_SHOULDER, 0, False)):
        hand.event(EV_KEY, button, value, 0.0)
        assert (hand.wish(0.0) != STAND) == drives


def test_an_axis_has_a_dead_zone_and_no_jump_at_its_end():
    axis = Axis(0, 255)
    assert axis.share(128) == axis.share(120) == axis.share(140) == 0.0
    assert axis.share(0) == -1.0 and axis.share(255) == 1.0 and axis.share(400) == 1.0
    assert 0.0 < axis.share(round(127.5 * (1 + DEAD_ZONE) + 2)) < 0.05


def test_an_axis_that_tells_no_range_moves_nothing_strange():
    assert -1.0 <= Axis(0, 0).share(7) <= 1.0


def test_buttons_are_actions_once_for_each_press(hand):
    assert hand.event(EV_KEY, EAST, 1, 0.0) == "stop"
    assert hand.event(EV_KEY, EAST, 2, 0.0) is hand.event(EV_KEY, EAST, 0, 0.0) is None
    assert hand.event(EV_KEY, START, 1, 0.0) == "motors_on"
    assert hand.event(EV_KEY, 999, 1, 0.0) is None


@pytest.mark.parametrize("silent, drives", [(True, False), (False, True)])
def test_a_bluetooth_pad_that_falls_silent_lets_go_and_one_on_a_cable_does_not(silent, drives):
    hand = StickHand({Y: Axis(-32768, 32767)}, silent)
    hand.event(EV_KEY, SHOULDER, 1, 0.0)
    hand.event(EV_ABS, Y, -32768, 0.0)
    assert hand.wish(SILENCE) != STAND
    assert (hand.wish(SILENCE + 0.1) != STAND) == drives
    hand.event(EV_ABS, Y, -32000, 5.0)      # its deadman must be pressed anew
    assert (hand.wish(5.0) != STAND) == drives


def test_a_gamepad_reads_all_that_waits_and_says_when_it_is_gone():
    device = Device(bus=BUS_BLUETOOTH)
    gamepad = Gamepad(device)
    device.events = [SimpleNamespace(type=EV_KEY, code=code, value=1) for code in (SHOULDER, EAST)]
    device.events.append(SimpleNamespace(type=EV_ABS, code=Y, value=-32768))
    assert gamepad.read(0.0) == ["stop"]
    assert gamepad.hand.wish(0.0).forward == 1.0 and gamepad.hand.wish(SILENCE + 0.1) == STAND
    device.events = None
    with pytest.raises(OSError):
        gamepad.read(0.1)


@pytest.fixture
def devices(monkeypatch):
    """Replace evdev by stand-ins: a list of devices, or of errors."""
    made = {}

    def open_device(path):
        if isinstance(made[path], OSError):
            raise made[path]
        return made[path]

    monkeypatch.setattr(evdev, "list_devices", lambda: list(made))
    monkeypatch.setattr(evdev, "InputDevice", open_device)
    return made


def test_the_first_device_that_is_a_gamepad_is_found(devices):
    devices.update({"/dev/input/event0": Device(axes=()), "/dev/input/event1": OSError(13, "Permission denied"),
                    "/dev/input/event2": Device("/dev/input/event2", keys=(30,)),
                    "/dev/input/event3": Device("/dev/input/event3")})
    assert find().name == "a pad (/dev/input/event3)"
    assert devices["/dev/input/event0"].closed and devices["/dev/input/event2"].closed


def test_without_a_gamepad_there_is_none(devices):
    assert find() is None


@pytest.mark.parametrize("device, text", [
    (OSError(13, "Permission denied"), "Permission denied"), (Device(axes=(X,)), "is no gamepad"),
    (Device(keys=(EAST,)), "no shoulder button")])
def test_a_device_that_was_asked_for_and_cannot_be_used_is_an_error(devices, device, text):
    devices["/dev/input/event7"] = device
    with pytest.raises(PortError, match="/dev/input/event7.*" + text):
        find("/dev/input/event7")


def test_the_codes_are_those_of_the_kernel():
    ecodes = evdev.ecodes
    assert (EV_KEY, EV_ABS, BUS_BLUETOOTH) == (ecodes.EV_KEY, ecodes.EV_ABS, ecodes.BUS_BLUETOOTH)
    assert gamepad_module.DEADMEN == {ecodes.BTN_TL, ecodes.BTN_TR}
    assert gamepad_module.AXES == {ecodes.ABS_X: "turn", ecodes.ABS_Y: "forward"}
    assert [gamepad_module.BUTTONS[getattr(ecodes, "BTN_" + name)] for name in (
        "EAST", "START", "SELECT", "SOUTH", "WEST", "NORTH")] == [
        "stop", "motors_on", "motors_off", "close", "open", "open"]
