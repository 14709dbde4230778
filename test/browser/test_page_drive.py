"""The page as a deadman's handle: when it drives a robot, and everything that must end that."""

import pytest

from page_server import helm, until


def test_a_held_key_drives_by_drawn_pictures_and_its_release_is_zero_once(page, server):
    page.open()
    page.drive()
    until(lambda: len(server.drives()) >= 12)
    page.up("ArrowUp")
    until(lambda: server.drives()[-1] == (1, 0, 0))
    drives = page.driven()
    assert drives.count((1, 0, 0)) == 1 and drives[-1] == (1, 0, 0)
    assert set(drives[:-1]) == {(1, 1, 0)}
    came = [(message, at) for message, at in server.received if message["do"] == "drive"]
    for message, at in came:
        assert set(message) == {"do", "robot", "forward", "turn", "stamp"}
        assert 0 <= at - server.sent[message["stamp"]] < 1.0
    first, last = came[0][1], came[11][1]
    assert last - first > 0.45, "more than 20 a second"
    assert page.server.drawn, "pictures are acknowledged"


def test_keys_add_up(page, server):
    page.open()
    page.drive("KeyW")
    page.down("ArrowLeft")
    until(lambda: server.drives()[-1] == (1, 1, 1))
    page.down("KeyD")
    until(lambda: server.drives()[-1] == (1, 1, 0))
    page.up("KeyW")
    page.up("ArrowLeft")
    until(lambda: server.drives()[-1] == (1, 0, -1))
    page.up("KeyD")
    until(lambda: server.drives()[-1] == (1, 0, 0))


def test_nothing_is_driven_without_a_hand(page, server):
    page.open()
    assert page.driven() == []


LEAVING = {
    "window": "window.dispatchEvent(new Event('blur'))",
    "pagehide": "window.dispatchEvent(new Event('pagehide'))",
    "freeze": "document.dispatchEvent(new Event('freeze'))",
    "text": "document.getElementById('my-name').focus()",
    "dialog": "document.getElementById('help-open').click()",
}


@pytest.mark.parametrize("way", sorted(LEAVING))
def test_what_takes_the_hand_away_is_zero_at_once_and_the_key_must_be_pressed_anew(page, server, way):
    """The events of the window are stand-ins: a browser without a window never loses the focus."""
    page.open()
    page.drive()
    page.js(LEAVING[way])
    until(lambda: server.drives()[-1] == (1, 0, 0))
    known = len(server.drives())
    if way == "text":
        page.js("document.activeElement.blur()")
    if way == "dialog":
        page.js("document.getElementById('help').close()")
    page.down("ArrowUp", repeat=True)
    assert page.driven(known) == []
    page.up("ArrowUp")
    page.drive()
    page.up("ArrowUp")


def test_a_hidden_tab_does_not_drive(page, server):
    page.open()
    page.drive()
    page.driver.switch_to.new_window("tab")
    until(lambda: server.drives()[-1] == (1, 0, 0))
    known = len(server.drives())
    page.driver.close()
    page.driver.switch_to.window(page.driver.window_handles[0])
    page.down("ArrowUp", repeat=True)
    assert page.driven(known) == []


def test_another_robot_must_be_driven_anew(page, server):
    page.open([1, 2])
    page.drive()
    page.choose(2)
    until(lambda: server.drives()[-1] == (1, 0, 0))
    known = len(server.drives())
    page.down("ArrowUp", repeat=True)
    assert page.driven(known) == []
    page.up("ArrowUp")
    page.drive()
    assert server.drives()[-1] == (2, 1, 0)


def test_stop_ends_driving_until_unlocked_and_pressed_anew(page, server):
    page.open()
    page.drive()
    page.press("Space")
    until(lambda: server.of("stop"))
    known = len(server.drives())
    assert server.drives()[-1] == (1, 0, 0)
    server.say("helm", helm(1, locks=["stop"]))
    page.shows("driver-text", "Stopped until somebody unlocks")
    assert page.driven(known) == []
    page.click("unlock")
    until(lambda: server.of("unlock") == [{"do": "unlock", "robot": 1}])
    server.say("helm", helm(1))
    page.shows("driver-text", "Nobody drives")
    page.down("KeyW")
    assert page.driven(known) == [], "a key is still held since before the stop"
    page.up("KeyW")
    page.up("ArrowUp")
    page.drive()
    assert len(server.of("stop")) == 1


def test_a_lock_of_others_ends_driving_too(page, server):
    page.open()
    page.drive()
    server.states[1]["flags"] = 0x183
    until(lambda: server.drives()[-1] == (1, 0, 0))
    known = len(server.drives())
    server.states[1]["flags"] = 0x83
    assert page.driven(known) == []


def test_one_who_may_only_look_drives_nothing(page, server):
    page.open()
    server.say("robots", [dict(robot, yours=False) for robot in dict(server.greeting)["robots"]])
    page.shows("driver-note", "look")
    page.down("ArrowUp")
    assert page.driven() == []
    assert page.text("take") is None and page.text("motors-switch") is None and page.text("stop")


def test_without_new_pictures_nothing_is_driven(page, server):
    page.open()
    page.drive()
    server.silent = True
    until(lambda: "OLD PICTURE" in (page.text("old") or ""))
    known = len(server.drives())
    until(lambda: " s" in page.text("old"))
    assert len(server.drives()) == known
    for message, at in server.received:
        assert at - server.sent[message["stamp"]] < 1.0


FOCUSABLE = """return [...document.querySelectorAll("a, button, input, select, summary, [tabindex]")]
    .filter(e => e.checkVisibility() && e.tabIndex >= 0 && !e.disabled)"""


def test_the_space_bar_is_stop_and_nothing_else(page, server):
    """With the focus on each element that can have it, and repeated as a held key is."""
    page.open([1, 2], teacher=True)
    page.js("window.clicks = 0; addEventListener('click', () => window.clicks++, true)")
    elements = page.js(FOCUSABLE)
    assert len(elements) > 20
    for count, element in enumerate(elements, 1):
        page.js("arguments[0].focus()", element)
        assert page.js("return document.activeElement === arguments[0]", element)
        page.down("Space")
        page.down("Space", repeat=True)
        page.up("Space")
        until(lambda: len(server.of("stop")) == count)
    page.js("document.getElementById('help-open').click(); window.clicks = 0")
    page.press("Space")
    until(lambda: len(server.of("stop")) == len(elements) + 1)
    page.settle()
    assert len(server.of("stop")) == len(elements) + 1
    assert {message["robot"] for message in server.of("stop")} == {1}
    assert page.js("return window.clicks") == 0
    assert page.js("return document.getElementById('help').open")
    assert page.js("return document.getElementById('say-text').value") == ""
    assert {message["do"] for message, _ in server.received} == {"stop"}


def test_other_keys_do_press_buttons(page, server):
    """So the test above would see a click."""
    page.open()
    page.js("window.clicks = 0; addEventListener('click', () => window.clicks++, true);"
            "document.getElementById('motors-switch').focus()")
    page.press("Enter")
    until(lambda: server.of("motors") == [{"do": "motors", "robot": 1, "on": False}])
    assert page.js("return window.clicks") == 1


def test_one_press_on_stop_is_one_stop(page, server):
    page.open()
    page.click("stop")
    until(lambda: server.of("stop"))
    page.settle()
    assert server.of("stop") == [{"do": "stop", "robot": 1}]
    page.js("document.getElementById('stop').focus()")
    page.press("Enter")
    page.settle()
    assert len(server.of("stop")) <= 2


def test_a_stop_without_a_connection_goes_out_with_the_next_one(page, server):
    page.open()
    page.js("""window.Real = WebSocket; window.WebSocket = function() { setTimeout(() => this.onclose({})); }""")
    server.hang_up()
    page.shows("mode", "no connection")
    page.press("Space")
    page.shows("said", "STOP goes out when")
    assert server.of("stop") == []
    page.js("window.WebSocket = window.Real")
    until(lambda: server.of("stop") == [{"do": "stop", "robot": 1}])


def test_a_finger_on_the_stick_drives_while_another_touches(page, server):
    page.resize(390, 844, mobile=True)
    page.open()
    x, y = page.centre("stick")
    radius = page.box("stick")[2] / 2
    page.touch("touchStart", (1, x, y))
    page.touch("touchMove", (1, x, y - radius))
    until(lambda: server.drives() and server.drives()[-1] == (1, pytest.approx(1), 0))
    mx, my = page.centre("moving")
    page.touch("touchStart", (1, x, y - radius), (2, mx, my))
    page.touch("touchMove", (1, x, y - radius), (2, mx + 30, my))
    page.touch("touchMove", (1, x - radius, y))     # without the second finger: it is lifted
    until(lambda: server.drives()[-1] == (1, 0, pytest.approx(1)))
    page.touch("touchEnd")
    until(lambda: server.drives()[-1] == (1, 0, 0))
    known = len(server.drives())
    assert page.driven(known) == []


@pytest.mark.parametrize("event", ["pointercancel", "lostpointercapture"])
def test_a_finger_that_the_system_takes_away_is_gone(page, server, event):
    page.resize(390, 844, mobile=True)
    page.open()
    x, y = page.centre("stick")
    page.js("const s = document.getElementById('stick');"
            "s.addEventListener('pointerdown', e => window.finger = e.pointerId)")
    page.touch("touchStart", (1, x, y - 40))
    page.touch("touchMove", (1, x, y - 42))
    until(lambda: len(server.drives()) > 2)
    if event == "pointercancel":
        page.touch("touchCancel")
    else:
        page.js("document.getElementById('stick').releasePointerCapture(window.finger)")
        page.touch("touchMove", (1, x, y - 45))
    until(lambda: server.drives()[-1] == (1, 0, 0))
    known = len(server.drives())
    assert page.driven(known) == []


PADS = """window.pad = {connected: true, axes: [0, -1], buttons: Array.from({length: 16}, () => ({pressed: false}))};
    navigator.getGamepads = () => [null, window.pad]"""


def test_a_gamepad_drives_while_its_shoulder_button_is_held(page, server):
    """The gamepad is a stand-in: `navigator.getGamepads` is replaced."""
    page.open()
    page.js(PADS)
    assert page.driven() == []
    page.js("pad.buttons[5].pressed = true")
    until(lambda: server.drives() and server.drives()[-1] == (1, 1, 0))
    page.js("pad.buttons[5].pressed = false")
    until(lambda: server.drives()[-1] == (1, 0, 0))
    page.js("pad.buttons[5].pressed = true")
    until(lambda: server.drives()[-1] == (1, 1, 0))
    page.js("pad.connected = false; window.dispatchEvent(new Event('gamepaddisconnected'))")
    until(lambda: server.drives()[-1] == (1, 0, 0))
    known = len(server.drives())
    page.js("pad.connected = true; pad.buttons[5].pressed = false")
    assert page.driven(known) == []
    page.js("pad.buttons[5].pressed = true")
    until(lambda: server.drives()[-1] == (1, 1, 0))
    page.js("pad.buttons[1].pressed = true")
    until(lambda: server.of("stop"))
    until(lambda: server.drives()[-1] == (1, 0, 0))
    known = len(server.drives())
    assert page.driven(known) == [] and len(server.of("stop")) == 1


BUTTONS = {
    "slower": {"do": "limit", "robot": 1, "linear": 0.15}, "faster": {"do": "limit", "robot": 1, "linear": 0.25},
    "take": {"do": "take", "robot": 1}, "motors-switch": {"do": "motors", "robot": 1, "on": False},
}


@pytest.mark.parametrize("button", sorted(BUTTONS))
def test_a_button_says_one_thing(page, server, button):
    page.open()
    server.say("helm", helm(1, commander="program", programs="driving"))
    page.shows("driver-text", "A program drives")
    page.click(button)
    until(lambda: server.received)
    page.settle()
    assert [message for message, _ in server.received] == [BUTTONS[button]]


def test_the_helm_is_given_back(page, server):
    page.open()
    server.say("helm", helm(1, commander="person", you=True, who="Ada", programs="locked out"))
    page.shows("driver-text", "You drive")
    page.click("release")
    until(lambda: server.of("release") == [{"do": "release", "robot": 1}])
    server.say("helm", helm(1, commander="person", who="Bo", programs="locked out"))
    page.shows("driver-text", "Bo drives")


def test_a_gripper_has_its_buttons_only_where_it_is_fitted(page, server):
    page.open()
    page.js("[...document.querySelectorAll('#grip button')].find(b => b.innerText === 'close').click()")
    until(lambda: server.of("gripper") == [{"do": "gripper", "robot": 1, "command": "close"}])
    server.states[1]["gripper"] = 0
    until(lambda: page.text("grip") is None)


def test_a_teacher_stops_all_and_speaks_to_all(page, server):
    page.open([1, 2, 3], teacher=True)
    page.click("stop-all")
    until(lambda: server.of("stop") == [{"do": "stop", "robot": "all"}])
    page.js("const f = document.getElementById('say-text'); f.value = 'look_at_3'; f.form.requestSubmit()")
    until(lambda: server.of("say") == [{"do": "say", "text": "look at 3"}])


def test_a_pupil_has_no_such_buttons(page, server):
    page.open([1, 2])
    assert page.text("stop-all") is None
    page.js("const f = document.getElementById('my-name'); f.value = 'Ada_L'; f.form.requestSubmit()")
    until(lambda: server.of("name") == [{"do": "name", "name": "Ada L"}])


@pytest.mark.parametrize("screen", [(1280, 800, False), (390, 844, True)])
def test_who_looks_at_motors_that_are_off_sees_the_button_that_switches_them_on(page, server, screen):
    page.resize(*screen)
    page.open()
    server.states[1]["flags"] = 0x81
    page.shows("driver-note", "Switch motors on to drive")
    button, dock = page.box("motors-switch"), page.box("dock")
    assert button[1] + button[3] <= dock[1], "above the dock, without scrolling"
    page.click("motors-switch")
    until(lambda: server.of("motors") == [{"do": "motors", "robot": 1, "on": True}])
    server.states[1]["flags"] = 0x83
    until(lambda: page.text("driver-note") is None)


def test_a_run_that_ended_is_told_and_its_controls_look_dead(page, server):
    page.open()
    opacity = "return getComputedStyle(document.getElementById('panel')).opacity"
    assert page.js(opacity) == "1"
    page.js("window.WebSocket = function() { setTimeout(() => this.onclose({})); }")
    server.hang_up()
    page.shows("notice", "the run has ended")
    assert page.js(opacity) == "0.5"
