"""The page of a robot that navigates: a click sends it, a drag says where it is; what it knows is drawn and said."""

import base64
import math

import pytest

from page_server import helm, until
from test_page_recording import run
from test_page_view import CONTRASTS, LAYOUT, SCREENS

PLACES = [["kitchen", 5.0, 1.0, 1.57], ["my desk", 2.0, 3.0, 0.0]]
STATE = {"robot": 1, "state": "idle", "reason": "no goal", "sure": True, "unsure": "", "pose": [1.4, 1.5, 0.0],
         "goal": None}


def say(server, robot=1, places=PLACES, **changes):
    """Say what navigation tells of a robot."""
    server.say("places", {"robot": robot, "places": places})
    server.say("navigation", dict(STATE, robot=robot, **changes))


@pytest.fixture
def robot(page, server):
    """The page of a robot that navigates, with its controls."""
    page.open()
    say(server)
    page.shows("travel-state", "No goal")
    return page


def pixel(page, x, y):
    """Return where a place (m) of the map is on the screen, while all of it is shown."""
    left, top, width, height = page.box("moving")
    place = page.module("view.js", """
        const c = new m.Camera(); Object.assign(c, {width: a[0], height: a[1]});
        c.fit([0, 0, 6, 4], document.getElementById("legend").offsetHeight + 9); return c.toScreen([a[2], a[3]])""",
                        width, height, x, y)
    return left + place[0], top + place[1]


def click_at(page, x, y):
    """Press and release the mouse at a pixel."""
    page.mouse("mousePressed", x, y)
    page.mouse("mouseReleased", x, y)


def drag(page, start, end=None):
    """Press the mouse at a place (m), drag it to another, and release it."""
    here, there = pixel(page, *start), pixel(page, *(end or start))
    page.mouse("mousePressed", *here)
    if end:
        page.mouse("mouseMoved", *there, buttons=1, button="left")
    page.mouse("mouseReleased", *there)


def order(server, do):
    """Wait for the one order of a kind. Returns its fields."""
    until(lambda: server.of(do), do)
    (found,) = server.of(do)
    return {key: value for key, value in found.items() if key != "do"}


def near(found, x, y, heading=None, robot=1):
    assert found["robot"] == robot and math.hypot(found["x"] - x, found["y"] - y) < 0.03, found
    if heading is not None:
        assert abs(math.remainder(found["heading"] - heading, math.tau)) < 0.05, found
    return True


def files(page):
    """Return the names of the scripts that the page has loaded."""
    return page.js("return performance.getEntriesByType('resource').map(e => e.name.split('/').pop())")


def test_a_page_without_navigation_loads_nothing_of_it(page, server):
    page.open()
    page.settle()
    assert "navigation.js" not in files(page) and page.js("return document.getElementById('travel')") is None
    say(server)
    page.shows("travel-state", "No goal")
    assert files(page).count("navigation.js") == 1


def test_a_click_still_chooses_until_go_is_pressed_and_then_sends_once(page, server):
    page.open([1, 2])
    say(server)
    page.shows("travel-state", "No goal")
    drag(page, (2.0, 1.5))
    page.shows("number", "2")
    drag(page, (1.4, 1.5))
    page.shows("number", "1")
    assert server.of("go") == []
    page.click("go")
    page.shows("aim", "Click where it is to go")
    drag(page, (3.4, 1.5))
    near(order(server, "go"), 3.4, 1.5, 0.0)
    assert page.text("aim") is None
    drag(page, (2.0, 1.5))
    page.shows("number", "2")
    assert len(server.of("go")) == 1 and server.drives() == []


def test_a_drag_says_how_it_looks_in_the_end(robot, server):
    robot.press("KeyG")
    robot.shows("aim", "Click where it is to go")
    drag(robot, (4.0, 1.0), (4.0, 2.0))
    near(order(server, "go"), 4.0, 1.0, math.pi / 2)


def test_a_drag_says_where_it_is_and_a_click_is_not_enough(robot, server):
    robot.press("KeyH")
    robot.shows("aim", "Press where the robot is")
    drag(robot, (2.0, 2.0))
    robot.shows("said", "Drag from where it is")
    assert server.of("here") == []
    drag(robot, (2.0, 2.0), (1.0, 2.0))
    near(order(server, "here"), 2.0, 2.0, math.pi)
    assert server.of("go") == []


def test_the_map_stands_still_while_it_aims(robot, server):
    before = pixel(robot, 3.0, 2.0)
    robot.press("KeyG")
    drag(robot, (4.0, 1.0), (4.0, 2.0))
    order(server, "go")
    assert robot.js("return getComputedStyle(document.getElementById('moving')).cursor") == "grab"
    robot.press("KeyG")
    drag(robot, (3.0, 2.0))
    until(lambda: len(server.of("go")) == 2)
    near(server.of("go")[1], 3.0, 2.0)
    assert pixel(robot, 3.0, 2.0) == before


def test_escape_and_another_press_and_another_robot_end_the_aiming(page, server):
    page.open([1, 2])
    say(server)
    say(server, 2)
    page.shows("travel-state", "No goal")
    for leave in (lambda: page.cdp("Input.dispatchKeyEvent", type="keyDown", code="Escape", key="Escape"),
                  lambda: page.press("KeyG"), lambda: page.choose(2 if page.text("number") == "1" else 1)):
        page.press("KeyG")
        page.shows("aim", "Click where")
        leave()
        until(lambda: page.text("aim") is None)
    drag(page, (3.4, 3.5))
    page.settle()
    assert server.of("go") == []


def test_fingers(page, server):
    page.resize(390, 844, mobile=True)
    page.open()
    say(server)
    page.shows("travel-state", "No goal")
    page.click("go")
    page.shows("aim", "Click where it is to go")
    x, y = page.centre("moving")
    page.touch("touchStart", (1, x, y))
    page.touch("touchStart", (1, x, y), (2, x + 40, y))
    page.touch("touchMove", (1, x, y - 30), (2, x + 80, y))
    page.touch("touchEnd")
    page.settle()
    assert server.of("go") == [], "two fingers are no click"
    page.touch("touchStart", (3, x, y))
    page.touch("touchMove", (3, x, y - 40))
    page.touch("touchEnd")
    assert abs(order(server, "go")["heading"] - math.pi / 2) < 0.05


def test_a_place_is_chosen_by_its_sign_and_from_the_list(robot, server):
    robot.press("KeyG")
    drag(robot, (5.0, 1.0))
    near(order(server, "go"), 5.0, 1.0, 1.57)
    robot.js("document.getElementById('travel-more').open = true")
    robot.js("document.getElementById('places').value = 'my desk'")
    robot.js("document.querySelector('#travel form:nth-of-type(1) button').click()")
    until(lambda: len(server.of("go")) == 2)
    near(server.of("go")[1], 2.0, 3.0, 0.0)


def test_a_click_on_the_name_of_a_place_means_the_place(robot, server):
    x, y = pixel(robot, 5.0, 1.0)
    for number, (right, up) in enumerate(((0, 20), (-22, 24), (22, 16))):
        robot.press("KeyG")
        robot.shows("aim", "Click where")
        click_at(robot, x + right, y - up)
        until(lambda: len(server.of("go")) == number + 1)
        near(server.of("go")[-1], 5.0, 1.0, 1.57)
    robot.press("KeyG")
    robot.shows("aim", "Click where")
    click_at(robot, x, y - 40)
    until(lambda: len(server.of("go")) == 4)
    assert server.of("go")[-1]["y"] > 1.2, "above the name it is the floor that is meant"


def test_help_and_legend_tell_of_navigation(robot):
    told = robot.js("return document.getElementById('help').textContent")
    assert "give up the click" in told
    assert "black strokes: where it may be" in robot.js("return document.getElementById('legend').textContent")


def test_numbers_by_the_keyboard_alone(robot, server):
    robot.js("document.getElementById('travel-more').open = true; document.getElementById('to-x').focus()")
    for field, digits in (("to-x", "2.5"), ("to-y", "-1"), ("to-turn", "90")):
        robot.js("document.getElementById(arguments[0]).focus()", field)
        robot.cdp("Input.insertText", text=digits)
    robot.press("Enter")
    near(order(server, "go"), 2.5, -1.0, math.pi / 2)
    robot.js("document.querySelector('#travel form:nth-of-type(2) button[value=here]').click()")
    near(order(server, "here"), 2.5, -1.0, math.pi / 2)
    assert server.drives() == []


def test_a_number_that_is_none_is_not_sent(robot, server):
    robot.js("""document.getElementById('travel-more').open = true;
        document.querySelector('#travel form:nth-of-type(2) button').click()""")
    robot.settle()
    assert server.of("go") == []


def test_a_place_gets_a_name_and_loses_it(robot, server):
    robot.js("document.getElementById('travel-more').open = true; document.getElementById('place-name').focus()")
    robot.cdp("Input.insertText", text="coffee_corner")
    robot.press("Enter")
    assert order(server, "save_place") == {"robot": 1, "name": "coffee corner"}
    robot.js("document.getElementById('places').value = 'kitchen'")
    robot.js("document.querySelector('#travel button[value=forget_place]').click()")
    assert order(server, "forget_place") == {"robot": 1, "name": "kitchen"}


def test_space_is_stop_also_while_it_aims_and_in_its_fields(robot, server):
    robot.press("KeyG")
    robot.press("Space")
    until(lambda: len(server.of("stop")) == 1)
    robot.js("document.getElementById('travel-more').open = true; document.getElementById('place-name').focus()")
    robot.press("Space")
    until(lambda: len(server.of("stop")) == 2)
    assert server.of("go") == server.of("save_place") == []


def test_words_of_what_it_does(robot, server):
    say(server, state="driving", reason="2.1 m to go", goal=[5.0, 1.0, 1.57])
    robot.shows("travel-state", "Drives: kitchen")
    robot.shows("travel-why", "2.1 m to go")
    robot.shows("travel-sure", "It knows where it is.")
    say(server, state="waiting", reason="a wheel is stalled", sure=False, goal=[5.0, 1.0, 1.57],
        unsure="I do not know where I am: it looks the same in two places")
    robot.shows("travel-state", "Waits")
    robot.shows("travel-why", "a wheel is stalled")
    robot.shows("travel-sure", "I do not know where I am: it looks the same in two places")
    robot.click("cancel")
    assert order(server, "cancel") == {"robot": 1}
    say(server, state="failed", reason="a closed door")
    robot.shows("travel-state", "Gave up")
    assert robot.text("cancel") is None
    say(server, state="silent", reason="nothing has come from it for 3 s: does it run?", sure=False)
    robot.shows("travel-state", "Silent")
    assert robot.text("go") is None and robot.text("here") is None


def test_what_is_not_yours_cannot_be_sent(robot, server):
    robot.press("KeyG")
    robot.shows("aim", "Click where")
    server.say("helm", helm(1, locks=["stop"]))
    until(lambda: robot.text("go") is None)
    assert robot.text("aim") is None, "a lock ends the aiming"
    server.say("helm", helm(1))
    until(lambda: robot.text("go"))
    server.say("helm", helm(1, commander="person", who="Bo"))
    until(lambda: robot.text("go") is None)
    server.say("helm", helm(1, programs="locked out"))
    until(lambda: robot.text("go"))
    robot.press("KeyG")
    robot.shows("said", "Let programs drive")
    assert robot.text("aim") is None
    drag(robot, (3.4, 3.5))
    robot.settle()
    assert server.of("go") == server.of("here") == []


def test_without_a_connection_nothing_is_sent_later(robot, server):
    robot.press("KeyG")
    robot.shows("aim", "Click where")
    server.refuse = (4429, "wait")
    server.hang_up()
    until(lambda: robot.text("mode") != "live")
    drag(robot, (3.4, 1.5))
    robot.shows("said", "nothing was sent")
    server.refuse = None
    until(lambda: robot.text("mode") == "live")
    robot.settle()
    assert server.of("go") == []


LAYER = """
    const c = document.querySelectorAll("main canvas")[2];
    const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
    let count = 0;
    for (let i = 3; i < d.length; i += 4) count += d[i] > 0;
    return count"""


@pytest.mark.parametrize("kind, value", [
    ("plan", {"points": [[1.4, 1.5], [3.0, 1.0], [5.0, 1.0]]}),
    ("cloud", {"poses": [[1.4 + 0.01 * n, 1.5, 0.1 * n] for n in range(60)]}),
    ("places", {"places": PLACES}),
    ("navigation", dict(STATE, goal=[5.0, 1.0, 0.0])),
    ("goals", {"1": [5.0, 1.0]})])
def test_it_is_drawn_and_gone_again(page, server, kind, value):
    page.open()
    say(server, places=[])
    page.shows("travel-state", "No goal")
    assert page.js(LAYER) == 0
    server.say(kind, value if kind == "goals" else dict(value, robot=1))
    until(lambda: page.js(LAYER) > 30, kind)
    empty = {"plan": {"points": []}, "cloud": {"poses": []}, "places": {"places": []}, "navigation": STATE, "goals": {}}
    server.say(kind, empty[kind] if kind == "goals" else dict(empty[kind], robot=1))
    until(lambda: page.js(LAYER) == 0, kind + " gone")


def test_names_of_places_are_never_markup(page, server):
    page.open()
    evil = "<img src=x onerror=alert(1)>"
    say(server, places=[[evil, 2.0, 2.0, 0.0]], reason=evil, goal=[2.0, 2.0, 0.0], state="driving")
    page.shows("travel-state", evil)
    page.shows("travel-why", evil)
    assert page.js("return document.querySelectorAll('body img:not(#class-code)').length") == 0


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width, height, mobile", [(1280, 800, False), (390, 844, True)])
def test_it_can_be_read_and_reached(page, server, scheme, width, height, mobile):
    page.resize(width, height, mobile)
    page.cdp("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
    page.open()
    say(server, state="waiting", reason="a wheel is stalled", sure=False, unsure="all looks alike", goal=[5, 1, 0])
    page.shows("travel-state", "Waits")
    page.js("document.getElementById('travel-more').open = true")
    page.settle()
    seen, found = page.js(CONTRASTS)
    assert seen > 20 and found == []
    inside = page.js("""
        const all = [...document.querySelectorAll("#tools button, #travel *")];
        return all.filter(e => e.checkVisibility()).map(e => e.getBoundingClientRect()).every(
            b => b.left >= 0 && b.right <= innerWidth)""")
    assert inside
    assert page.js("return [...document.querySelectorAll('#travel input, #travel select')].every(e => e.labels.length"
                   " || e.ariaLabel)")


@pytest.mark.parametrize("screen", sorted(SCREENS))
def test_its_buttons_lie_over_nothing_else(page, server, screen):
    """A teacher's list of robots leaves little room for the map on a telephone that lies."""
    page.resize(*SCREENS[screen])
    page.open(range(1, 8), teacher=True)
    say(server)
    page.shows("go", "Go")
    server.say("said", {"robot": 1, "level": "error", "text": "Bo drives it: only the teacher may take it"})
    page.shows("said", "Bo")
    assert page.js(LAYOUT) == []
    page.click("go")
    page.shows("aim", "Click where")
    assert page.js(LAYOUT) == []


def test_a_recording_in_one_file_shows_it_and_has_nothing_to_send_it(page, tmp_path):
    from pioneer_control.web.one_file import one_file

    recording, columns = run(rows=100)
    recording["columns"][0]["data"] = base64.b64encode(columns).decode()
    recording["messages"] += [[0.0, {"places": {"robot": 7, "places": PLACES}}],
                              [0.0, {"navigation": dict(STATE, robot=7, state="driving", goal=[5.0, 1.0, 0.0])}]]
    recording["messages"].sort(key=lambda each: each[0])
    (tmp_path / "run.html").write_text(one_file(recording), encoding="utf-8")
    page.driver.get((tmp_path / "run.html").as_uri())
    page.shows("travel-state", "Drives: kitchen")
    until(lambda: page.js(LAYER) > 100)
    for element in ("go", "here", "cancel", "travel-more"):
        assert page.text(element) is None
    assert [entry["message"] for entry in page.driver.get_log("browser") if entry["level"] == "SEVERE"] == []
