"""The browser in the hands of a test: keys, touches and the mouse as the system gives them, and what the page shows."""

import contextlib
import os

from selenium import webdriver
from selenium.common.exceptions import InvalidArgumentException
from selenium.webdriver.chrome.service import Service

from page_server import LIMIT, PageServer, helm, robot_info, status, until, WORLD

KEYS = {"ArrowUp": ("ArrowUp", 38), "ArrowLeft": ("ArrowLeft", 37), "ArrowRight": ("ArrowRight", 39),
        "KeyW": ("w", 87), "KeyD": ("d", 68), "KeyS": ("s", 83),
        "KeyF": ("f", 70), "KeyG": ("g", 71), "KeyH": ("h", 72),
        "KeyL": ("l", 76), "Digit0": ("0", 48), "Equal": ("+", 187), "Space": (" ", 32),
        "Enter": ("Enter", 13), "End": ("End", 35), "Home": ("Home", 36), "Tab": ("Tab", 9)}


def start_browser():
    """Start Chromium, with its own profile."""
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    arguments = ["--headless=new", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
                 "--force-color-profile=srgb", "--disable-background-networking", "--disable-component-update"]
    for argument in arguments + (["--no-sandbox"] if os.geteuid() == 0 else []):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
    driver.set_script_timeout(LIMIT)
    return driver


class Page:
    """One page of the room in the browser."""

    def __init__(self, driver, server: PageServer):
        self.driver, self.server = driver, server
        self.resize(1280, 800)

    def resize(self, width, height, mobile=False):
        """Change the size of the screen; a mobile one has fingers."""
        self.cdp("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=mobile)
        self.cdp("Emulation.setTouchEmulationEnabled", enabled=mobile)

    def cdp(self, command, **arguments):
        """Run a command of the DevTools protocol."""
        return self.driver.execute_cdp_cmd(command, arguments)

    def go(self, path):
        """Open something of the server."""
        self.driver.get("http://127.0.0.1:%d/%s" % (self.server.port, path))

    def open(self, numbers=(1,), world=WORLD, **hello):
        """Say what a live server says of some robots, open the page, and wait until it drew them."""
        say, server = self.server.say, self.server
        say("hello", dict({"title": "room", "kind": "live", "teacher": False, "you": ""}, **hello))
        say("robots", [robot_info(number) for number in numbers])
        say("world", world)
        for number in numbers:
            say("status", status(number))
            say("helm", helm(number))
            server.states[number] = dict(x=800 + 600 * number, y=1500, ranges=[251] * 8, gripper=0x23)
        self.driver.get(server.url)
        self.settle()

    def leave(self):
        """Leave no page, no tab, no finger and nothing kept behind."""
        with contextlib.suppress(InvalidArgumentException):      # no finger was on it
            self.touch("touchCancel")
        self.cdp("Emulation.setEmulatedMedia", features=[])
        for handle in self.driver.window_handles[1:]:
            self.driver.switch_to.window(handle)
            self.driver.close()
        self.driver.switch_to.window(self.driver.window_handles[0])
        self.js("try { localStorage.clear(); sessionStorage.clear(); } catch (error) { }")
        self.driver.get("about:blank")
        for kind in ("browser", "performance"):
            self.driver.get_log(kind)

    def settle(self):
        """Wait until the page drew something that was sent after now."""
        known = len(self.server.sent)
        until(lambda: set(self.server.drawn) & set(list(self.server.sent)[known + 1:]), "a new picture drawn")

    def js(self, script, *arguments):
        """Run a script in the page. Returns what it returns."""
        return self.driver.execute_script(script, *arguments)

    def module(self, name, body, *arguments):
        """Import a module and run a body, in which `m` is the module and `a` has the arguments."""
        found = self.driver.execute_async_script("""
            const a = [...arguments], done = a.pop();
            import("/%s").then(async m => { %s }).then(value => done([value]), error => done(String(error.stack)));
            """ % (name, body), *arguments)
        assert isinstance(found, list), found
        return found[0]

    def text(self, element):
        """Return the text of an element that can be seen; None if it cannot."""
        return self.js("const e = document.getElementById(arguments[0]);"
                       "return e && e.checkVisibility() ? e.innerText.trim() : null", element)

    def shows(self, element, words):
        """Wait until an element shows some words."""
        until(lambda: words in (self.text(element) or ""), "%s with %r, not %r" % (element, words, self.text(element)))

    def down(self, code, repeat=False):
        """Press a key, or repeat it."""
        key, number = KEYS[code]
        text = {"text": key} if len(key) == 1 else {"text": "\r"} if key == "Enter" else {}
        self.cdp("Input.dispatchKeyEvent", type="keyDown", code=code, key=key, windowsVirtualKeyCode=number,
                 autoRepeat=repeat, **text)

    def up(self, code):
        """Release a key."""
        key, number = KEYS[code]
        self.cdp("Input.dispatchKeyEvent", type="keyUp", code=code, key=key, windowsVirtualKeyCode=number)

    def press(self, code):
        """Press and release a key."""
        self.down(code)
        self.up(code)

    def choose(self, number):
        """Choose a robot by its tile, with the keyboard."""
        self.js("document.querySelector(`#tiles button[value='${arguments[0]}']`).focus()", number)
        self.press("Enter")
        self.shows("number", str(number))

    def box(self, element):
        """Return x, y, width, height of an element on the screen."""
        return self.js("const b = document.getElementById(arguments[0]).getBoundingClientRect();"
                       "return [b.x, b.y, b.width, b.height]", element)

    def centre(self, element):
        """Return the middle of an element."""
        x, y, width, height = self.box(element)
        return x + width / 2, y + height / 2

    def mouse(self, kind, x, y, **more):
        """Move the mouse, or press (`mousePressed`) or release its button."""
        self.cdp("Input.dispatchMouseEvent", type=kind, x=x, y=y,
                 **dict({"button": "none" if kind == "mouseMoved" and not more else "left", "clickCount": 1}, **more))

    def click(self, element):
        """Click the middle of an element, after scrolling to it."""
        self.js("document.getElementById(arguments[0]).scrollIntoView({block: 'nearest'})", element)
        x, y = self.centre(element)
        self.mouse("mousePressed", x, y)
        self.mouse("mouseReleased", x, y)

    def touch(self, kind, *points):
        """Touch the screen: `touchStart`, `touchMove` or `touchEnd`, with the fingers (id, x, y) that are on it."""
        self.cdp("Input.dispatchTouchEvent", type=kind, touchPoints=[{"id": i, "x": x, "y": y} for i, x, y in points])

    def drive(self, code="ArrowUp"):
        """Hold a key until the page drives."""
        known = len(self.server.drives())
        self.down(code)
        until(lambda: len(self.server.drives()) >= known + 3, "drive messages")

    def driven(self, since=0):
        """Return what was driven since so many messages, after some more pictures."""
        self.settle()
        self.settle()
        return self.server.drives()[since:]
