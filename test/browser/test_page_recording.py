"""Recordings in the page: any moment at once, play, marks; over a socket, and in one file without any."""

import base64
import struct
import zlib

import pytest

from page_server import OUTLINE, WORLD, helm, robot_info, status, until

ROWS = 6000         # ten minutes
DURATION = 600.0


def compressed(rows):
    """Return the columns of rows as a recording has them."""
    data = b"".join(struct.pack("<%di" % len(rows), *(after - before for before, after in zip((0,) + column, column)))
                    for column in zip(*rows))
    return zlib.compress(data)


def run(rows=ROWS):
    """Return a recording of a robot that drives forth and back, and its columns."""
    at = [(100 * i, 1000 + (i % 200) * 10, 1500, 0, 100, 0 if i % 200 else 500, 0x83, 0) + (50,) * 8
          for i in range(rows)]
    info = robot_info(7, name="recorded", outline=OUTLINE)
    messages = [[0.0, {"world": WORLD}], [0.0, {"robots": [info]}], [0.0, {"helm": helm(7, commander="program")}]]
    messages += [[20.0 * leg, {"status": status(7, decision={"doing": "leg %d" % leg, "why": "it began"})}]
                 for leg in range(30)]
    messages += [[300.0, {"said": {"robot": 7, "level": "warn", "text": "half of it"}}]]
    messages.sort(key=lambda each: each[0])
    marks = [{"at": 12.3, "robot": 7, "kind": "fault", "text": "it stalled"},
             {"at": 99.0, "robot": 8, "kind": "event", "text": "another one's"},
             {"at": 450.0, "robot": 7, "kind": "event", "text": "it gripped"}]
    return {"name": "run.bag", "start": 1700000000.0, "duration": DURATION, "messages": messages, "marks": marks,
            "columns": [{"robot": 7, "rows": rows, "sonar": 8}]}, compressed(at)


@pytest.fixture
def recorded(page, server):
    """The page with a recording that came over its socket."""
    recording, columns = run()
    server.say("hello", {"title": "run.bag", "kind": "recording", "teacher": False, "you": ""})
    server.say_recording(recording)
    page.driver.get(server.url)
    page.shows("name", "recorded")
    server.send(b"\x02" + struct.pack("<H", 7) + columns)
    page.shows("Forward", "0.10 m/s")
    return page


def test_a_recording_is_shown_and_nothing_can_be_driven(recorded, server):
    assert recorded.text("mode") == "recording" and recorded.text("doing") == "leg 0"
    assert recorded.text("stop") is None and recorded.text("controls") is None and recorded.text("old") is None
    recorded.down("KeyW")
    recorded.press("KeyL")
    recorded.shows("clock", "0:12.3 of 10:00.0")
    recorded.up("KeyW")
    recorded.press("Space")
    until(lambda: "0:12.3" not in recorded.text("clock"))
    assert server.received == []


def test_keys_on_the_time_line_and_marks(recorded):
    recorded.js("document.getElementById('line').focus()")
    recorded.press("End")
    recorded.shows("clock", "10:00.0 of")
    recorded.shows("doing", "leg 29")
    recorded.shows("log", "half of it")
    recorded.press("Home")
    recorded.shows("doing", "leg 0")
    until(lambda: "half" not in (recorded.text("log") or ""))
    recorded.press("KeyL")
    recorded.shows("clock", "0:12.3")
    recorded.shows("mark-text", "it stalled")
    recorded.press("KeyL")
    recorded.shows("clock", "7:30.0")
    recorded.press("ArrowRight")
    recorded.shows("clock", "7:31.0")
    recorded.js("document.getElementById('mark-previous').click()")
    recorded.shows("clock", "7:30.0")
    recorded.js("document.getElementById('mark-previous').click()")
    recorded.shows("clock", "0:12.3")


def test_the_time_line_is_dragged(recorded):
    x, y, width, height = recorded.box("line")
    recorded.mouse("mousePressed", x + width / 2, y + height / 2)
    recorded.shows("doing", "leg 1")
    recorded.mouse("mouseMoved", x + width - 2, y + height / 2, button="left", buttons=1)
    recorded.shows("clock", "10:00.0")
    recorded.mouse("mouseReleased", x + width - 2, y + height / 2)


def test_the_space_bar_plays_and_pauses(recorded):
    recorded.js("const r = document.getElementById('rate'); r.value = '20×'")
    recorded.press("Space")
    until(lambda: recorded.text("doing") != "leg 0")
    recorded.press("Space")
    assert recorded.js("return document.getElementById('play').ariaLabel").startswith("Play")
    recorded.js("document.getElementById('line').focus()")
    recorded.press("End")
    recorded.press("Space")
    recorded.shows("doing", "leg 0")
    until(lambda: recorded.js("return document.getElementById('play').ariaLabel").startswith("Pause"))


def test_any_moment_of_ten_minutes_is_drawn_at_once(recorded):
    """The least of ten, as other programs run beside this one; measured to the end of the drawing."""
    times = recorded.driver.execute_async_script("""
        const done = arguments[0], line = document.getElementById("line"), times = [];
        const next = count => {
            if (!count) return done(times);
            const began = performance.now();
            line.value = count % 2 ? line.max : 0;
            line.dispatchEvent(new Event("input"));
            requestAnimationFrame(() => { times.push(performance.now() - began); next(count - 1); });
        };
        next(10)""")
    assert min(times) < 50, times


def test_a_gap_in_the_recording_is_told(page, server):
    recording, columns = run(100)
    server.say("hello", {"title": "run.bag", "kind": "recording", "teacher": False, "you": ""})
    server.say_recording(recording)
    page.driver.get(server.url)
    page.shows("name", "recorded")
    server.send(b"\x02" + struct.pack("<H", 7) + columns)
    page.shows("Forward", "0.10 m/s")
    page.press("KeyL")
    page.shows("old", "NO DATA")


def test_one_file_works_by_a_double_click(page, tmp_path):
    from pioneer_control.web.one_file import one_file
    recording, columns = run()
    recording["columns"][0]["data"] = base64.b64encode(columns).decode()
    recording["name"] = "</script><b>run"
    (tmp_path / "run.html").write_text(one_file(recording), encoding="utf-8")
    page.driver.get((tmp_path / "run.html").as_uri())
    page.shows("Forward", "0.10 m/s")
    page.press("KeyL")
    page.shows("clock", "0:12.3")
    assert page.text("title") == "</script><b>run" and page.text("mode") == "recording"
    assert page.driver.get_log("browser") == []


def test_a_module_does_not_load_by_a_double_click(page, tmp_path):
    """So the test above would see a page whose modules were not joined."""
    (tmp_path / "x.js").write_text("document.title = 'loaded'")
    (tmp_path / "page.html").write_text('<script type="module" src="x.js"></script>')
    page.driver.get((tmp_path / "page.html").as_uri())
    assert page.driver.title != "loaded" and page.driver.get_log("browser")


@pytest.mark.parametrize("screen", [(1280, 800, False), (390, 844, True), (844, 390, True)])
def test_the_time_line_has_its_place(recorded, screen):
    recorded.resize(*screen)
    until(lambda: recorded.box("line")[2] > 200)
    x, y, width, height = recorded.box("line")
    assert x >= 0 and x + width <= screen[0] and y + height <= screen[1]
    assert recorded.box("moving")[3] > 90
    assert recorded.js("return document.scrollingElement.scrollWidth <= innerWidth")
