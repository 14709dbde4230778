"""What the page shows: the first picture, how old it is, names, layouts, contrast; and what it never does."""

import json
import re

import pytest

from page_server import WORLD, helm, robot_info, status, until

SCREENS = {"desk": (1280, 800, False), "phone": (390, 844, True), "phone lying": (844, 390, True)}
LONG = "turning back to the left around the corner of the table"


def painted(page):
    """Return the share of the moving canvas that is not empty."""
    return page.js("""
        const c = document.getElementById("moving"), data = c.getContext("2d").getImageData(0, 0, c.width,
            c.height).data;
        let count = 0;
        for (let i = 3; i < data.length; i += 4) count += data[i] > 0;
        return count / data.length * 4""")


def test_the_first_picture(page, server):
    page.open()
    until(lambda: painted(page) > 0.001)
    assert page.text("title") == "room" and page.text("mode") == "live"
    assert page.text("name") == "sim_0001" and page.text("Battery") == "12.6 V · 80 %"
    assert page.text("list") is None
    until(lambda: page.text("age-text").endswith(" s old"))
    assert page.driver.current_url == "http://127.0.0.1:%d/" % server.port, "the key is out of the address"
    assert server.keys[0]["key"] == "secret" and 16 <= len(server.keys[0]["visitor"]) <= 64


def test_no_robot_is_no_picture(page, server):
    server.say("hello", {"title": "room", "kind": "live", "teacher": False, "you": ""})
    server.say("robots", [])
    page.driver.get(server.url)
    page.shows("mode", "live")
    assert painted(page) == 0
    assert page.text("name") == "no robot yet" and page.text("stop")


def test_words_of_a_robot(page, server):
    page.open()
    server.states[1].update(flags=0x83 | 4 | 16 | 32, linear=250, angular=-500, gripper=0x85)
    server.say("status", status(1, decision={"doing": "turning right", "why": "sonar 5 sees 0.4 m"},
                                faults=[{"level": "error", "task": "Stall", "text": "the right wheel is stalled"}],
                                battery={"volts": 11.2, "charge": None, "level": "warn"}))
    page.shows("doing", "turning right")
    page.shows("why", "because sonar 5 sees 0.4 m")
    page.shows("faults", "Stall: the right wheel is stalled")
    until(lambda: page.text("Forward") == "0.25 m/s")
    assert page.text("Turn") == "29 °/s right"
    assert page.text("Wheels") == "right stalled" and page.text("Bumpers, button") == "front bumper, STOP button"
    assert page.text("Battery") == "11.2 V · low"
    assert page.text("Gripper") == "closed, holds something"
    server.say("status", status(1, link="the cable was pulled"))
    page.shows("faults", "No link: the cable was pulled")


def test_what_the_server_says_is_shown(page, server):
    page.open()
    server.say("said", {"robot": 1, "level": "error", "text": "Bo drives it"})
    page.shows("said", "Bo drives it")
    page.shows("log", "1: Bo drives it")


def test_an_old_picture_is_called_old(page, server):
    page.open()
    assert page.text("old") is None
    server.silent = True
    until(lambda: re.match(r"OLD PICTURE: [1-9]\d*\.\d+ s", page.text("old") or ""), "older than a second")
    assert "s old" in page.text("age-text")
    server.silent = False
    until(lambda: page.text("old") is None)


def test_a_picture_that_was_old_when_it_was_sent_is_old(page, server):
    page.open()
    server.states[1]["age"] = 3000
    page.shows("old", "OLD PICTURE: 3.")


def test_without_a_connection_the_picture_gets_old_until_there_is_one(page, server):
    page.open()
    server.silent = True
    server.hang_up()
    page.shows("old", "OLD PICTURE")
    until(lambda: len(server.keys) == 2)
    assert server.keys[0] == server.keys[1]
    page.shows("mode", "live")
    assert page.text("old")
    server.silent = False
    until(lambda: page.text("old") is None)


def test_a_wrong_key_is_told(page, server):
    server.refuse = (4401, "the key is wrong: open its whole address")
    page.driver.get(server.url)
    page.shows("notice", "its whole address")
    assert page.text("mode") == "no key"


def test_names_are_never_markup(page, server):
    page.open([1, 2])
    evil = "<img src=x onerror=alert(1)><b>bad"
    server.say("robots", [robot_info(1, name=evil, model=evil), robot_info(2, name=evil)])
    server.say("status", status(1, decision={"doing": evil, "why": evil}, link=evil,
                                faults=[{"level": "warn", "task": evil, "text": evil}]))
    server.say("helm", helm(1, commander="person", who=evil))
    server.say("said", {"robot": 1, "level": "info", "text": evil})
    server.say("hello", {"title": evil, "kind": "live", "teacher": False, "you": evil})
    for element in ("name", "doing", "faults", "log", "title"):
        page.shows(element, evil)
    markup = "body img:not(#class-code), body b b, #name b, #faults b"
    assert page.js("return document.querySelectorAll(arguments[0]).length", markup) == 0


def test_the_robot_is_chosen_by_keys_list_and_map(page, server):
    page.open([1, 2, 3])
    page.choose(3)
    page.js("document.querySelector('#tiles li:nth-child(2) button').click()")
    page.shows("number", "2")
    assert page.js("return [...document.querySelectorAll('#tiles button')].map(b => b.ariaPressed)") == [
        "false", "true", "false"]
    left, top, width, height = page.box("moving")
    place = page.module("view.js", """
        const c = new m.Camera(); Object.assign(c, {width: a[0], height: a[1]}); c.fit([0, 0, 6, 4]);
        return c.toScreen([1.4, 1.5])""", width, height)
    x, y = left + place[0], top + place[1]
    page.mouse("mousePressed", x, y)
    page.mouse("mouseReleased", x, y)
    page.shows("number", "1")


def test_a_robot_that_goes_is_not_chosen_any_more(page, server):
    page.open([1, 2])
    server.say("robots", [robot_info(2)])
    page.shows("number", "2")
    until(lambda: page.text("list") is None)


@pytest.mark.parametrize("action", ["wheel", "Equal", "drag", "pinch", "zoom-in"])
def test_the_view_moves_and_shows_all_again(page, server, action):
    page.resize(1280, 800, mobile=action == "pinch")
    page.open()
    floor = "return document.getElementById('floor').toDataURL()"
    whole = page.js(floor)
    x, y = page.centre("moving")
    if action == "wheel":
        page.cdp("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=-300)
    elif action == "drag":
        page.mouse("mousePressed", x, y)
        page.mouse("mouseMoved", x + 60, y + 20, button="left", buttons=1)
        page.mouse("mouseReleased", x + 60, y + 20)
    elif action == "pinch":
        page.touch("touchStart", (1, x - 50, y), (2, x + 50, y))
        page.touch("touchMove", (1, x - 90, y), (2, x + 90, y))
        page.touch("touchEnd")
    elif action == "zoom-in":
        page.click(action)
    else:
        page.press(action)
    until(lambda: page.js(floor) != whole)
    page.press("Digit0")
    until(lambda: page.js(floor) == whole)


def test_the_view_follows_the_robot(page, server):
    page.open()
    page.press("KeyF")
    until(lambda: page.js("return document.getElementById('follow').ariaPressed") == "true")
    page.settle()
    floor = "return document.getElementById('floor').toDataURL()"
    before = page.js(floor)
    server.states[1]["x"] += 500
    until(lambda: page.js(floor) != before)
    x, y = page.centre("moving")
    page.mouse("mousePressed", x, y)
    page.mouse("mouseMoved", x + 60, y + 20, button="left", buttons=1)
    page.mouse("mouseReleased", x + 60, y + 20)
    until(lambda: page.js("return document.getElementById('follow').ariaPressed") == "false")


# --- What the page never does ---

def requests_elsewhere(messages, allowed):
    """Return the addresses in a log of the network that do not begin with what is allowed."""
    found = []
    for message in messages:
        if message["method"] in ("Network.requestWillBeSent", "Network.webSocketCreated"):
            url = message["params"].get("request", message["params"]).get("url", "")
            if not url.startswith(allowed):
                found.append(url)
    return found


def test_the_page_asks_nobody_else_and_breaks_no_rule_of_its_policy(page, server):
    page.driver.get_log("performance")
    page.open([1, 2], teacher=True)
    page.js("document.getElementById('help-open').click()")
    page.settle()
    messages = [json.loads(entry["message"])["message"] for entry in page.driver.get_log("performance")]
    ours = tuple("%s127.0.0.1:%d/" % (scheme, server.port) for scheme in ("http://", "ws://")) + ("data:", "about:")
    assert any(message["method"] == "Network.requestWillBeSent" for message in messages)
    assert requests_elsewhere(messages, ours) == []
    assert page.driver.get_log("browser") == []


def test_a_request_to_somebody_else_is_seen():
    sent = {"method": "Network.requestWillBeSent", "params": {"request": {"url": "https://example.org/font"}}}
    assert requests_elsewhere([sent], ("http://127.0.0.1:1/",)) == ["https://example.org/font"]


def test_a_breach_of_the_policy_is_seen(page, server):
    page.open()
    page.js("const s = document.createElement('script'); s.textContent = '1'; document.body.append(s)")
    until(lambda: [entry for entry in page.driver.get_log("browser") if "Content Security Policy" in entry["message"]])


# --- Can it be used by everybody? ---

UNNAMED = ("button", "textbox", "combobox", "slider", "link", "image", "navigation", "main", "dialog")


def unnamed(page):
    """Return the roles of what has no name for a screen reader."""
    nodes = page.cdp("Accessibility.getFullAXTree")["nodes"]
    return [node["role"]["value"] for node in nodes if not node.get("ignored") and
            node["role"]["value"] in UNNAMED and not node.get("name", {}).get("value", "").strip()]


def test_everything_has_a_name(page, server):
    page.open([1, 2], teacher=True)
    assert unnamed(page) == []
    page.js("document.getElementById('help-open').click()")
    assert unnamed(page) == []


def test_what_has_no_name_is_seen(page, server):
    page.open()
    page.js("document.getElementById('moving').removeAttribute('aria-label')")
    assert unnamed(page) == ["image"]


CONTRASTS = """
    const rgb = text => text.match(/[\\d.]+/g).map(Number), channel = c => c <= 10 ? c / 3294
        : ((c / 255 + 0.055) / 1.055) ** 2.4;
    const light = c => 0.2126 * channel(c[0]) + 0.7152 * channel(c[1]) + 0.0722 * channel(c[2]), found = [];
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    let seen = 0;
    for (let node; node = walker.nextNode();) {
        const element = node.parentElement;
        if (!node.textContent.trim() || !element.checkVisibility()
            || element.closest("script, style, option")) continue;
        let ground = element;
        while (ground && (rgb(getComputedStyle(ground).backgroundColor)[3] ?? 1) === 0) ground = ground.parentElement;
        const style = getComputedStyle(element), one = light(rgb(style.color));
        const other = light(rgb(getComputedStyle(ground || document.body).backgroundColor));
        const ratio = (Math.max(one, other) + 0.05) / (Math.min(one, other) + 0.05);
        seen++;
        if (ratio < 4.5) found.push([element.id || element.className, node.textContent.trim(),
            Math.round(100 * ratio) / 100]);
    }
    return [seen, found]"""


def all_states(page, server):
    """Show robots in every state, faults and messages."""
    page.open(range(1, 8), teacher=True, you="Ada")
    server.states[2]["flags"] = 0x82
    server.states[3]["flags"] = 0x81
    server.states[4]["flags"] = 0x8b
    server.say("helm", helm(5, commander="person", who="Bo"))
    server.say("helm", helm(6, commander="program", programs="driving"))
    server.say("helm", helm(1, locks=["stop"]))
    server.say("status", status(1, decision={"doing": LONG, "why": "sonar 5 sees 0.4 m"}, faults=[
        {"level": level, "task": "Stall", "text": "the left wheel is stalled: something holds it"}
        for level in ("warn", "error")],
        battery={"volts": 11.0, "charge": 0.1, "level": "error"}))
    server.say("said", {"robot": 1, "level": "error", "text": "Bo drives it: only the teacher may take it"})
    server.say("goals", {"1": [3, 2]})
    page.shows("faults", "Stall")
    page.shows("said", "Bo")


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_every_text_stands_out_from_its_ground(page, server, theme):
    all_states(page, server)
    page.cdp("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": theme}])
    page.js("""document.getElementById("help").showModal();
        for (const part of document.querySelectorAll("details, [hidden]")) [part.hidden, part.open] = [false, true]""")
    scheme = "return getComputedStyle(document.body).colorScheme"
    until(lambda: page.js(scheme) == {"dark": "dark", "light": "normal"}[theme])
    seen, found = page.js(CONTRASTS)
    assert seen > 80 and found == []


def test_a_pale_text_is_seen(page, server):
    page.open()
    page.js("document.styleSheets[0].insertRule('#driver-text{color:#bbb !important}')")
    assert [name for name, _, _ in page.js(CONTRASTS)[1]] == ["driver-text"]


LAYOUT = """
    const problems = [], wide = innerWidth, high = innerHeight;
    const seen = element => {      // its box, as far as nothing that scrolls hides it
        let {left, top, right, bottom} = element.getBoundingClientRect();
        for (let up = element.parentElement; up; up = up.parentElement) {
            if (getComputedStyle(up).overflow === "visible") continue;
            const box = up.getBoundingClientRect();
            [left, top, right, bottom] = [Math.max(left, box.left), Math.max(top, box.top), Math.min(right, box.right),
                Math.min(bottom, box.bottom)];
        }
        return {element, left, top, right, bottom};
    };
    const name = element => element.id || element.className || element.textContent;
    const all = [...document.querySelectorAll(`button, input, select, #stick, h1, #mode, #age, #helm p, #decision p, dd,
            #old p, #said`)]
        .filter(e => e.checkVisibility()).map(seen).filter(b => b.right - b.left > 1 && b.bottom - b.top > 1);
    for (const [i, a] of all.entries()) for (const b of all.slice(i + 1))
        if (Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom,
            b.bottom) - Math.max(a.top, b.top) > 1
            && !a.element.contains(b.element) && !b.element.contains(a.element))
            problems.push(name(a.element) + " lies over " + name(b.element));
    const {scrollWidth, scrollHeight} = document.scrollingElement;
    if (scrollWidth > wide || scrollHeight > high) problems.push("the page scrolls");
    for (const id of ["panel", "list", "time"]) {
        const e = document.getElementById(id);
        if (e.checkVisibility() && e.scrollWidth > e.clientWidth + 1) problems.push(id + " scrolls sideways");
    }
    for (const id of ["stop", "stick"]) {
        const box = document.getElementById(id).getBoundingClientRect();
        if (box.left < 0 || box.top < 0 || box.right > wide || box.bottom > high || box.width < 80 || box.height < 60)
            problems.push(id + " is not wholly on the screen, or small: " + JSON.stringify(box));
    }
    const stage = document.getElementById("moving").getBoundingClientRect();
    if (stage.width * stage.height < 0.19 * wide * high)
        problems.push("the map is small: " + stage.width + " x " + stage.height);
    return problems"""


@pytest.mark.parametrize("screen", sorted(SCREENS))
@pytest.mark.parametrize("teacher", [False, True])
def test_nothing_lies_over_anything_else(page, server, screen, teacher):
    page.resize(*SCREENS[screen])
    all_states(page, server)
    if not teacher:
        server.say("hello", {"title": "A room with a very long name, longer than a telephone is wide", "kind": "live",
                             "teacher": False, "you": "Ada"})
        until(lambda: page.text("teacher") is None)
    assert page.js(LAYOUT) == []
    server.silent = True
    page.shows("old", "OLD PICTURE")
    assert page.js(LAYOUT) == []
    page.js("const p = document.getElementById('panel'); p.scrollTop = p.scrollHeight")
    assert page.js(LAYOUT) == []


BREAK = """
    const real = CanvasRenderingContext2D.prototype.clearRect;
    CanvasRenderingContext2D.prototype.clearRect = () => { throw new Error("broken"); };
    window.mend = () => CanvasRenderingContext2D.prototype.clearRect = real"""


def test_a_picture_that_cannot_be_drawn_is_told_and_ends_neither_driving_for_ever_nor_what_the_server_sends(page):
    page.open()
    page.drive()
    page.js(BREAK)
    page.shows("old", "NO PICTURE")
    until(lambda: page.server.drives()[-1] == (1, 0, 0), "nobody drives by what is not drawn")
    page.settle()
    page.js("window.mend()")
    until(lambda: page.text("old") is None, "it draws again")
    known = len(page.server.drives())
    assert page.driven(known) == [], "the key must be pressed anew"


def test_what_could_not_be_drawn_does_not_count_as_drawn_in_a_turn_without_news(page):
    page.open()
    page.js(BREAK)
    page.shows("old", "NO PICTURE")
    page.server.silent = True
    page.js("""window.seen = new Set();
        new MutationObserver(() => window.seen.add(document.getElementById("old-words").textContent))
            .observe(document.getElementById("old"), {attributes: true, childList: true, subtree: true});
        window.turns = 0; const count = () => ++window.turns < 60 && requestAnimationFrame(count); count();
        window.press = setInterval(() => dispatchEvent(new KeyboardEvent("keydown", {key: "x"})), 20)""")
    until(lambda: page.js("return window.turns") >= 60, "the page had many turns")
    seen = page.js("clearInterval(window.press); const seen = [...window.seen]; window.mend(); return seen")
    assert set(seen) <= {"NO PICTURE"}, "what is drawn after the mend does not count"


def test_a_turn_before_the_page_knows_its_size_draws_all_the_same(page):
    """On a busy computer the first news come before the browser has told how large the view is."""
    late = page.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": """
        const Prompt = ResizeObserver;
        ResizeObserver = class {
            constructor(tell) { this.tell = tell; }
            observe(what) { setTimeout(() => new Prompt(this.tell).observe(what), 1000); }
        };"""})
    try:
        page.open()
        page.settle()
        assert page.driver.get_log("browser") == []
    finally:
        page.driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", late)


def test_a_map_without_room_is_drawn_all_the_same(page):
    page.open()
    page.resize(1280, 90)
    page.settle()
    assert page.driver.get_log("browser") == []
    page.resize(1280, 800)


def test_what_lies_over_another_is_seen(page, server):
    page.open()
    assert page.js(LAYOUT) == []
    page.js("document.getElementById('zoom-in').style.transform = 'translateX(30px)'")
    assert page.js(LAYOUT) == ["zoom-in lies over zoom-out"]
    page.js("document.getElementById('stop').style.transform = 'translateY(300px)'")
    assert any("not wholly" in problem for problem in page.js(LAYOUT))


def test_the_focus_can_be_seen(page, server):
    page.open()
    page.press("Tab")
    assert page.js("return getComputedStyle(document.activeElement).outlineWidth") == "3px"


def test_the_system_chooses_light_or_dark(page, server):
    for theme in ("dark", "light"):
        page.cdp("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": theme}])
        page.go("")
        light = page.js("return getComputedStyle(document.body).backgroundColor") == "rgb(236, 239, 241)"
        assert light == (theme == "light")


def test_the_map_turns_dark_with_the_system_while_it_is_shown(page, server):
    page.cdp("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "light"}])
    page.open()
    floor = """const canvas = document.getElementById("floor"), {width, height} = canvas;
        return [...canvas.getContext("2d").getImageData(width / 2, height / 2, 1, 1).data]"""
    light = page.js(floor)
    page.cdp("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    until(lambda: page.js(floor) != light, "the floor is drawn anew")


def test_a_map_of_cells_is_drawn(page, server):
    page.open(world={"name": "grid", "bounds": [0, 0, 2, 1], "grid": {
        "resolution": 1.0, "origin": [0, 0, 0], "width": 2, "height": 1, "cells": "AQI="}})
    assert colours_of(page)[colour(page, "wall")] > 10000


def colour(page, name):
    """Return the red, green and blue of a colour of the style sheet, as in `colours_of`."""
    text = page.module("map.js", "return m.colours()[a[0]]", name)
    return ",".join(str(int(text[i:i + 2], 16)) for i in (1, 3, 5))


def colours_of(page):
    """Return how many pixels of the floor have each colour."""
    return page.js("""
        const c = document.getElementById("floor"), d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
        const found = {};
        for (let i = 0; i < d.length; i += 4) {
            const k = [d[i], d[i + 1], d[i + 2]].join(); found[k] = (found[k] || 0) + 1; }
        return found""")


def test_marked_places_are_drawn(page, server):
    page.open(world=dict(WORLD, places=[{"name": "goal", "centre": [5, 1], "size": [2, 1.5]},
                                        {"name": "dock", "centre": [1, 1], "diameter": 1}]))
    border = colour(page, "goal")
    assert colours_of(page).get(border, 0) > 300
    server.say("world", WORLD)
    until(lambda: border not in colours_of(page), "no place, no border")
