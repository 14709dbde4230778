"""A class on the page: a student says a name, gets a robot and its key; the teacher sees who is who."""

from page_server import helm, robot_info, until

QR = "data:image/svg+xml,%3Csvg xmlns='http://www.w3.org/2000/svg' viewBox='-4 -4 10 10'/%3E"


def student(page, joins=True):
    """Open a page as the server of a class shows it to a student."""
    page.open(numbers=(1, 2))
    page.server.say("robots", [dict(robot_info(number), yours=False) for number in (1, 2)])
    page.server.say("mine", {"robot": None, "name": ""})
    page.server.say("join", joins)
    until(lambda: page.js("return document.body.classList.contains('joins')") == joins, "it asks for a name")


def give(page, robot):
    """Say to the page that the student has a robot (none: that it was taken away) and need not say a name (must)."""
    page.server.say("mine", {"robot": robot, "name": "Ada" if robot else ""})
    page.server.say("join", robot is None)


def test_a_student_says_a_name_and_gets_a_robot_with_its_key(page):
    student(page)
    page.shows("my-label", "Type your name")
    assert page.js("return document.activeElement.id") == "my-name"
    page.js("const f = document.getElementById('my-name'); f.value = 'Ada_L'; f.form.requestSubmit()")
    until(lambda: page.server.of("join"), "it joins")
    assert page.server.of("join") == [{"do": "join", "name": "Ada L"}]
    page.server.say("mine", {"robot": 2, "name": "Ada L"})
    page.server.say("program", {"robot": 2, "path": "/robot/2", "key": "k<b>2"})
    page.server.say("join", False)
    page.shows("program", 'Robot("ws://127.0.0.1:%d/robot/2", key="k<b>2")' % page.server.port)
    page.shows("number", "2")
    page.drive()
    assert {robot for robot, _, _ in page.server.drives()} == {2}


def test_a_student_drives_no_other_robot_and_none_after_it_was_taken_away(page):
    student(page)
    give(page, robot=2)
    page.shows("number", "2")
    page.js("document.activeElement.blur()")
    page.choose(1)
    page.down("KeyW")
    page.settle()
    page.settle()
    page.up("KeyW")
    assert page.server.drives() == []
    page.choose(2)
    give(page, robot=None)
    page.shows("my-label", "Type your name")
    page.js("document.activeElement.blur()")
    page.down("KeyW")
    page.settle()
    page.settle()
    page.up("KeyW")
    assert page.server.drives() == []


def test_stop_is_for_the_students_own_robot_also_while_another_is_looked_at(page):
    student(page)
    give(page, robot=2)
    page.shows("stop-which", "robot 2")
    page.js("document.activeElement.blur()")
    page.choose(1)
    assert page.text("stop-which") == "robot 2" and page.text("controls") is None
    page.press("Space")
    page.click("stop")
    until(lambda: len(page.server.of("stop")) == 2, "both are sent")
    assert {order["robot"] for order in page.server.of("stop")} == {2}


def test_a_student_sees_the_own_robot_from_near_and_may_see_all(page):
    student(page)
    assert page.text("stop-which") == "robot 1", "no robot yet: the chosen one"
    give(page, robot=2)
    pressed = "return document.getElementById('follow').getAttribute('aria-pressed')"
    until(lambda: page.js(pressed) == "true", "it follows the own robot")
    page.click("fit")
    until(lambda: page.js(pressed) == "false", "all are seen")


def test_a_teacher_is_told_that_driving_takes_over_and_another_student_sees_no_live_controls(page):
    for teacher_too in (True, False):
        page.open(numbers=(1, 2), teacher=teacher_too)
        page.server.say("helm", helm(1, commander="person", who="Ada", programs="locked out"))
        page.shows("driver-text", "Ada drives")
        look = page.js("return getComputedStyle(document.getElementById('stick')).opacity")
        expected = ("If you drive, you take over.", "1") if teacher_too else ("Not yours: look only.", "0.5")
        assert (page.text("driver-note"), look) == expected


def test_unlock_all_can_be_pressed_only_while_a_robot_is_stopped_and_moves_no_other_button(page):
    page.open(numbers=(1, 2), teacher=True)
    disabled = "return document.getElementById('unlock-all').disabled"
    until(lambda: page.js(disabled) is True, "none is stopped")
    before = page.box("code-open"), page.box("say-text")
    page.server.say("helm", helm(2, locks=["stop"]))
    until(lambda: page.js(disabled) is False, "one is stopped")
    assert (page.box("code-open"), page.box("say-text")) == before
    page.server.say("helm", helm(2))
    until(lambda: page.js(disabled) is True, "none is stopped")


def test_a_student_cannot_unlock_what_the_teacher_stopped_and_is_told_so(page):
    for teacher_too in (True, False):
        page.open(numbers=(1, 2), teacher=teacher_too)
        page.server.say("helm", helm(1, locks=["stop"], teacher=True))
        page.shows("driver-text", "Stopped until somebody unlocks" if teacher_too else "Stopped by the teacher")
        assert page.text("unlock") == ("Unlock" if teacher_too else None)
        assert page.text("controls") is None, "nothing can be driven now"


def test_a_student_may_type_at_once_also_before_there_is_a_robot(page):
    page.open()
    page.server.say("robots", [])
    until(lambda: page.text("panel") is None, "there is no robot")
    give(page, robot=None)
    until(lambda: page.js("return document.activeElement.id") == "my-name", "the field has the focus")


def test_the_line_for_a_program_goes_with_the_robot(page):
    student(page)
    page.server.say("mine", {"robot": 2, "name": "Ada"})
    page.server.say("program", {"robot": 2, "path": "/robot/2", "key": "k2"})
    page.shows("program", "k2")
    page.server.say("mine", {"robot": None, "name": ""})
    until(lambda: page.text("program") is None, "its key is not valid any more")


def test_stop_all_stays_in_sight_when_the_teachers_list_is_scrolled(page):
    page.resize(1280, 600)
    page.open(numbers=tuple(range(1, 31)), teacher=True)
    page.shows("tiles", "30")
    page.js("const list = document.getElementById('list'); list.scrollTop = list.scrollHeight")
    assert page.js("return document.getElementById('list').scrollTop") > 50
    x, y = page.centre("stop-all")
    assert page.js("return document.elementFromPoint(...arguments).id", x, y) == "stop-all"


def test_that_a_picture_is_old_is_read_above_the_legend(page):
    page.open(numbers=(1, 2), teacher=True)
    page.js("document.getElementById('legend').open = true")
    page.js("window.WebSocket = function() { setTimeout(() => this.onclose({})); }")
    page.server.hang_up()
    page.shows("old-words", "OLD PICTURE")
    box = page.box("old-words")
    covered = """const [x, y] = arguments, all = [...document.querySelectorAll('#old p, #legend')];
        for (const each of all) each.style.pointerEvents = 'auto';
        return document.elementFromPoint(x, y).closest('#legend') !== null"""
    assert not page.js(covered, box[0] + 5, box[1] + 5)


def test_the_teacher_sees_who_is_who_and_the_address_and_pauses(page):
    page.open(numbers=(1, 2), teacher=True)
    page.server.say("mine", {"robot": None, "name": ""})
    page.server.say("class", {"address": "http://here:8080/#KEY", "qr": QR, "paused": False, "speed": 1.0,
                              "students": [[1, "Ada <b>", "here"], [2, "Bob", "away"]], "worlds": ["classroom"],
                              "tasks": []})
    until(lambda: page.js("return !document.getElementById('class').hidden"), "the class is shown")
    page.server.say("program", {"robot": 1, "path": "/robot/1", "key": "secret"})
    page.settle()
    assert "secret" not in page.js("return document.body.textContent"), "this page may be projected"
    page.click("code-open")
    page.shows("class-address", "http://here:8080/#KEY")
    wide, high = page.box("code")[2:]
    assert (wide, high) == (1280, 800), "for a projector"
    page.down("KeyW")
    assert page.driven() == [], "nobody sees the robot"
    page.up("KeyW")
    until(lambda: page.box("class-code")[3] > 400, "the code is large")
    page.js("document.querySelector('#code button').click()")
    page.js("document.getElementById('class').open = true")
    page.shows("tiles", "Ada <b> · 12.6 V")
    page.shows("tiles", "Bob, away")
    until(lambda: page.js("const c = document.getElementById('class-code'); return c.complete && c.naturalWidth"), "QR")
    page.click("pause")
    page.js("document.querySelector('[name=reset][value=all]').click()")
    until(lambda: page.server.of("reset"), "both are sent")
    assert page.server.of("pause") == [{"do": "pause", "on": True}]
    assert page.server.of("reset") == [{"do": "reset", "robot": "all"}]
    page.drive()        # a teacher drives any robot


def teacher(page, **changes):
    """Open a page as the server of a class shows it to the teacher, with the part of the class open."""
    page.open(numbers=(1, 2), teacher=True)
    page.server.say("mine", {"robot": None, "name": ""})
    page.server.say("class", dict({"address": "http://here:8080/#KEY", "qr": QR, "paused": False, "speed": 1.0,
                                   "students": [[2, "Bob", "here"]], "worlds": ["classroom"],
                                   "tasks": [["square", "Drive a square"], ["goal", "Reach the goal"]]}, **changes))
    page.js("document.getElementById('class').open = true")
    page.shows("tiles", "Bob")
    assert "Ada" not in page.text("tiles")


def test_on_a_phone_a_student_sees_what_is_typed_and_then_that_the_robot_is_theirs(page):
    page.resize(390, 844, mobile=True)
    student(page)
    page.shows("my-send", "Join")
    for element, least in (("my-name", 250), ("my-label", 100), ("my-send", 40)):
        left, top, width, height = page.box(element)
        assert width >= least and left >= 0 and left + width <= 390 and top >= 0 and top + height <= 844, element
    give(page, robot=2)
    page.shows("name", "Your robot")


def test_on_a_phone_the_teachers_map_keeps_its_room_while_class_is_open(page):
    page.resize(390, 844, mobile=True)
    teacher(page)
    page.settle()
    assert page.box("moving")[3] > 200
    assert page.js("return document.scrollingElement.scrollHeight <= innerHeight")
    assert page.driver.get_log("browser") == []


def choose(page, select, value):
    """Choose in a list as a person does."""
    page.js("const s = document.getElementById(arguments[0]); s.value = arguments[1];"
            "s.dispatchEvent(new Event('change', {bubbles: true}))", select, value)


def test_the_teacher_sets_the_speed_of_time_and_frees_a_robot(page):
    teacher(page, speed=2.0)
    assert page.js("return document.getElementById('speed').value") == "2"
    choose(page, "speed", "0.5")
    page.choose(2)
    page.js("document.querySelector('[name=free]').click()")
    until(lambda: page.server.of("free"), "both are sent")
    assert page.server.of("speed") == [{"do": "speed", "speed": 0.5}]
    assert page.server.of("free") == [{"do": "free", "robot": 2}]


def test_the_teacher_hands_out_faults_and_ends_them(page):
    teacher(page)
    for words, button in (("loss_0.2", "fault to chosen"), ("stop_button", "fault to all"), (" ", "fault to all")):
        page.js("document.getElementById('fault').value = arguments[0];"
                "[...document.querySelectorAll('#desk button')].find(b => b.textContent === arguments[1]).click()",
                words, button)
    page.server.say("faults", ["loss 0.2 robot 1", "stop_button"])
    page.shows("faults-on", "loss 0.2 robot 1\nstop_button")
    page.js("document.querySelector('[name=clear_faults]').click()")
    until(lambda: page.server.of("clear_faults") == [{"do": "clear_faults"}], "it ends all faults")
    assert page.server.of("fault") == [{"do": "fault", "robot": 1, "words": "loss 0.2"},
                                       {"do": "fault", "robot": "all", "words": "stop_button"}]


RANKING = [{"robot": 2, "who": "Bob", "points": 87.5, "note": "3 of 4 corners"},
           {"robot": 1, "who": "Ada <b>", "points": 50.0, "note": ""},
           {"robot": 3, "who": "", "points": 50.0, "note": ""}]
TASK = {"name": "square", "title": "Drive a square", "text": "Drive round the four marks.", "state": "running",
        "clock": 72.3, "limit": 120.0, "ranking": RANKING}


def test_the_teacher_chooses_starts_and_ends_a_task(page):
    teacher(page)
    assert page.text("task") is None
    assert page.js("return [...document.getElementById('tasks').options].map(o => o.textContent)") == [
        "no task", "Drive a square", "Reach the goal"]
    choose(page, "tasks", "square")
    until(lambda: page.server.of("task"), "it chooses")
    page.server.say("task", dict(TASK, state="ready", clock=0.0, ranking=[]))
    page.shows("task-title", "Task: Drive a square")
    page.shows("task-clock", "ready: 0:00.0 of 2:00.0")
    assert page.js("return document.getElementById('tasks').value") == "square"
    for order in ("begin_task", "end_task"):
        page.js("document.querySelector('[name=' + arguments[0] + ']').click()", order)
    choose(page, "tasks", "")
    until(lambda: len(page.server.of("task")) == 2, "all are sent")
    assert page.server.of("task") == [{"do": "task", "name": "square"}, {"do": "task", "name": ""}]
    assert page.server.of("begin_task") == [{"do": "begin_task"}] and page.server.of("end_task") == [{"do": "end_task"}]


OWN_LINES = """return [...document.querySelectorAll("#ranking li")]
    .filter(item => item.style.color).map(item => item.textContent)"""


def test_a_student_sees_the_task_the_own_place_and_the_ranking(page):
    student(page)
    page.server.say("task", TASK)
    page.shows("task-text", "Drive round the four marks.")
    assert page.js(OWN_LINES) == [], "no robot yet"
    page.server.say("mine", {"robot": 1, "name": "Ada <b>"})
    until(lambda: page.js(OWN_LINES) == ["2. Ada <b> (1): 50 points"], "the own line has a colour")
    page.shows("task-clock", "running: 1:12.3 of 2:00.0")
    assert page.text("ranking") == (
        "1. Bob (2): 87.5 points, 3 of 4 corners\n2. Ada <b> (1): 50 points\n2. robot (3): 50 points")
    assert page.text("class") is None
    page.server.say("task", None)
    until(lambda: page.text("task") is None, "no task")
