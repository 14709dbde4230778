"""A real page drives a simulated robot through the real server, and then something dies: how long until the robot is
told to stand, and does anything move afterwards by itself? The tests use it.

Each way to die is a function that does it to a `DrivenPage`. It returns what ends the trouble; None where nothing can.
"""

import contextlib
import math
import os
import pathlib
import selectors
import signal
import socket
import sys
import threading
import time
from typing import Any, Callable, Dict, NamedTuple, Optional

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "integration"))

from page_driver import KEYS, start_browser
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.line import Server
from pioneer_control.simulator.world import load_world
from real_time import until
from web_site import HeardCommands, Site

KEY = "KeyW"
PRESS_AGAIN = 2.0   # s
NOTE_HIDDEN = """document.addEventListener("visibilitychange", () => {
    if (document.hidden) window.hiddenAt = performance.timeOrigin + performance.now();
});"""
PAD = """window.pad = {connected: true, axes: [0, -1], buttons: Array.from({length: 16}, () => ({pressed: false}))};
    navigator.getGamepads = () => [window.pad];"""
HOLD_PAD = """const done = arguments[1];
window.pad.buttons[5].pressed = arguments[0];
requestAnimationFrame(() => requestAnimationFrame(() => done()));"""
RECENT = 0.15       # s: a page that drives said so not longer ago
AFTERWARDS = 1.5    # s of the robot's time in which nothing may move by itself


class Cable:
    """A network between browser and server that can go dark: then nothing passes, and nothing is closed either."""

    def __init__(self, port: int) -> None:
        self.dark = False
        self._port = port
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.port = self._listening.getsockname()[1]
        self._others: Dict[socket.socket, socket.socket] = {}
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listening, selectors.EVENT_READ)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        for each in (*self._others, self._listening):
            each.close()

    def _run(self) -> None:
        while not self._ended.is_set():
            for key, _ in self._selector.select(0.02):
                if self.dark:
                    time.sleep(0.005)   # what waits in the sockets waits on
                elif key.fileobj is self._listening:
                    self._connect()
                elif key.fileobj in self._others:
                    self._pass(key.fileobj)

    def _connect(self) -> None:
        ours, _ = self._listening.accept()
        theirs = socket.create_connection(("127.0.0.1", self._port))
        for one, other in ((ours, theirs), (theirs, ours)):
            one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._others[one] = other
            self._selector.register(one, selectors.EVENT_READ)

    def _pass(self, one: Any) -> None:
        other = self._others[one]
        data = b""
        with contextlib.suppress(OSError):
            data = one.recv(65536)
            if data:
                other.sendall(data)
        if not data:
            for each in (one, other):
                self._selector.unregister(each)
                del self._others[each]
                each.close()


class Death(NamedTuple):
    """What was measured: the time (s) until zero was on the wire, and how many velocities came afterwards."""

    until_zero: float
    moves_afterwards: int


class DrivenPage:
    """A robot, a server, a network and a browser whose page drives. Use it in a ``with`` block.

    Args:
        folder: for the logs of the server.
    """

    def __init__(self, folder: pathlib.Path) -> None:
        self._on_exit = contextlib.ExitStack()
        firmware = Firmware(find_model("p3dx-sh"), load_world("empty"))
        self.heard = HeardCommands(firmware)
        self.robot = self._on_exit.enter_context(Server(firmware, tcp=0))
        self.site = self._on_exit.enter_context(Site(folder, self.robot.url, page=None))
        self.cable = Cable(self.site.port)
        self._on_exit.callback(self.cable.close)
        self.driver = start_browser()
        self._on_exit.callback(self._quit)
        self.has_pad = False
        """Whether the hand holds the shoulder button of a gamepad, and not a key."""
        self.browser = self._browser()

    def __enter__(self) -> "DrivenPage":
        return self

    def __exit__(self, *_: object) -> None:
        self._on_exit.close()

    def drive(self) -> None:
        """Open the page, hold a key, and wait until the robot is told to drive again and again.

        A press that is refused, because the picture was old just then, is let go and made again, as a person does.
        """
        self.driver.get("http://127.0.0.1:%d/#%s" % (self.cable.port, self.site.key))
        until(lambda: self._age() is not None, "the page shows a robot")
        self._press()

    def _press(self) -> None:
        pressed = -math.inf

        def drives() -> bool:
            nonlocal pressed
            if time.monotonic() > pressed + PRESS_AGAIN and not self._drives():
                self.hold(False)
                self.hold(True)
                pressed = time.monotonic()
            return len(self.heard.moves(pressed)) > 5 and self._drives()

        until(drives, "the robot is told to drive")

    def _drives(self) -> bool:
        moves = self.heard.moves(0.0)
        return bool(moves) and self.zero_since(moves[-1]) is None

    def dies(self, way: "Way", lasting: float = 0.0) -> Death:
        """Let something die while the page drives, and measure. What can end, ends after ``lasting`` s."""
        if way in BEFOREHAND:
            BEFOREHAND[way](self)
            self._press()
        while not self.heard.moves(time.monotonic() - RECENT) or not self._drives():
            self._press()           # a late event of the browser, which has just shown this tab, let go of the key
        at = time.monotonic()
        restore = way(self)
        zero = until(lambda: self.zero_since(at), "zero on the wire")
        if way is hidden_tab:       # a busy browser hides a tab some time after it was told to
            self.driver.switch_to.window(self.driver.window_handles[0])
            hidden = self.driver.execute_script("return window.hiddenAt") / 1000
            at = max(at, hidden - (time.time() - time.monotonic()))
        if restore is not None:
            time.sleep(lasting)
            restore()
        end = self.robot.simulation.time + AFTERWARDS
        until(lambda: self.robot.simulation.time > end, "some time of the robot")
        return Death(zero - at, len(self.heard.moves(zero)))

    def show_tab(self, number: int) -> None:
        """Bring a tab to the front."""
        self.driver.switch_to.window(self.driver.window_handles[number])
        self.driver.execute_cdp_cmd("Page.bringToFront", {})

    def hold(self, on: bool) -> None:
        """Hold the key or the button with which this page is driven, or let go."""
        if self.has_pad:
            self.driver.execute_async_script(HOLD_PAD, on)
        else:
            self.key("keyDown" if on else "keyUp")

    def key(self, kind: str) -> None:
        """Press (`keyDown`) or release (`keyUp`) the key."""
        key, number = KEYS[KEY]
        text = {"text": key} if kind == "keyDown" else {}
        self.driver.execute_cdp_cmd("Input.dispatchKeyEvent", dict(
            type=kind, code=KEY, key=key, windowsVirtualKeyCode=number, **text))

    def renderers(self):
        """Return the ids of all processes of this browser that show pages."""
        return [pid for pid in self._tree(self.browser) if "--type=renderer" in _command(pid)]

    def zero_since(self, at: float) -> Optional[float]:
        """Return when zero was first on the wire since a time, with no velocity behind it; None if it was not yet."""
        moves = self.heard.moves(at)
        stops = [stop for stop in self.heard.stops(at) if not moves or stop > moves[-1]]
        return stops[0] if stops else None

    def _age(self) -> Optional[str]:
        return self.driver.execute_script("const e = document.getElementById('age');"
                                          "return e && /\\d/.test(e.textContent) ? e.textContent : null")

    def _browser(self) -> int:
        service = self.driver.service.process.pid
        return next(pid for pid in self._tree(service) if "--type=" not in _command(pid) and "chromedriver" not in
                    _command(pid))

    def _tree(self, pid: int):
        found = [pid]
        for child in _children(pid):
            found += self._tree(child)
        return found

    def _quit(self) -> None:
        """End the browser, however it is."""
        for pid in reversed(self._tree(self.driver.service.process.pid)):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        self.driver.service.process.wait()


def _children(pid: int):
    with contextlib.suppress(OSError):
        for task in pathlib.Path("/proc/%d/task" % pid).iterdir():
            yield from map(int, (task / "children").read_text().split())


def _command(pid: int) -> str:
    with contextlib.suppress(OSError):
        return pathlib.Path("/proc/%d/cmdline" % pid).read_bytes().replace(b"\0", b" ").decode(errors="replace")
    return ""


Way = Callable[[DrivenPage], Optional[Callable[[], None]]]


def _signal(pids, number) -> None:
    for pid in pids:
        with contextlib.suppress(ProcessLookupError):       # a browser ends some of its processes by itself
            os.kill(pid, number)


def release(page: DrivenPage) -> None:
    """The key is let go."""
    page.key("keyUp")


def kill_renderer(page: DrivenPage) -> None:
    """kill -9 of the processes that show pages."""
    _signal(page.renderers(), signal.SIGKILL)


def stop_renderer(page: DrivenPage) -> Callable[[], None]:
    """SIGSTOP of the processes that show pages, as when a computer sleeps."""
    pids = page.renderers()
    _signal(pids, signal.SIGSTOP)
    return lambda: _signal(pids, signal.SIGCONT)


def kill_browser(page: DrivenPage) -> None:
    """kill -9 of the browser."""
    _signal([page.browser], signal.SIGKILL)


def stop_browser(page: DrivenPage) -> Callable[[], None]:
    """SIGSTOP of the whole browser, as when a laptop is closed."""
    pids = page._tree(page.browser)
    _signal(pids, signal.SIGSTOP)
    return lambda: _signal(pids, signal.SIGCONT)


def kill_server(page: DrivenPage) -> None:
    """kill -9 of the web server."""
    _signal([page.site.server_pid()], signal.SIGKILL)


def stop_server(page: DrivenPage) -> Callable[[], None]:
    """SIGSTOP of the web server, and back with its queue of old orders. After a while its owner takes another one."""
    pid = page.site.server_pid()
    _signal([pid], signal.SIGSTOP)

    return lambda: _signal([pid], signal.SIGCONT)


def dark_network(page: DrivenPage) -> Callable[[], None]:
    """Nothing passes any more, and nothing is closed. Then all passes that waited."""
    page.cable.dark = True

    def light() -> None:
        page.cable.dark = False

    return light


def hidden_tab(page: DrivenPage) -> None:
    """Another tab comes to the front."""
    page.show_tab(1)


def open_tab(page: DrivenPage) -> None:
    """Open the other tab: that takes long, and the page drives meanwhile."""
    page.driver.switch_to.new_window("tab")
    page.show_tab(0)
    page.driver.execute_script(NOTE_HIDDEN)


def take_gamepad(page: DrivenPage) -> None:
    """Drive with a gamepad, which is a stand-in: the page is told of one that is not there."""
    page.hold(False)
    page.driver.execute_script(PAD)
    page.has_pad = True


def unplug_gamepad(page: DrivenPage) -> None:
    """The gamepad is gone, with its button held."""
    page.driver.execute_script("pad.connected = false; navigator.getGamepads = () => [null];"
                               "window.dispatchEvent(new Event('gamepaddisconnected'))")


def close_page(page: DrivenPage) -> None:
    """The tab is closed."""
    page.driver.execute_script("setTimeout(() => location.replace('about:blank'), 0)")


def freeze_page(page: DrivenPage) -> None:
    """The browser freezes the page, as it does with tabs that nobody sees."""
    page.driver.execute_cdp_cmd("Page.setWebLifecycleState", {"state": "frozen"})


def busy_page(page: DrivenPage) -> None:
    """The page's thread is busy for two seconds."""
    page.driver.execute_script("setTimeout(() => { const end = Date.now() + 2000; while (Date.now() < end); }, 0)")


WAYS: Dict[str, Way] = {each.__name__: each for each in (
    release, kill_renderer, stop_renderer, kill_browser, stop_browser, kill_server, stop_server, dark_network,
    hidden_tab, close_page, freeze_page, busy_page, unplug_gamepad)}
BEFOREHAND: Dict[Way, Callable[[DrivenPage], None]] = {hidden_tab: open_tab, unplug_gamepad: take_gamepad}
"""What has to be done before, while nothing is measured yet."""
