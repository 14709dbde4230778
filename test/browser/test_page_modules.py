"""Modules of the page, each on its own in the browser: bytes, hand, camera, clock and connection."""

import struct
import zlib

import pytest

ONE_FRAME = bytes.fromhex(
    "01"                # frames
    "0700"              # robot 7
    "40e20100"          # stamp 123456
    "1900"              # age 25 ms
    "e8030000"          # x 1 m
    "0cfeffff"          # y -0.5 m
    "0040"              # a quarter of a turn
    "fa00"              # 0.25 m/s
    "18fc"              # -1 rad/s
    "0b01"              # link, motors, left stall, locked
    "85"                # gripper: fitted, closed, something between the paddles
    "04" "32fafbff")    # 1 m, 5 m, no echo, not heard
FRAME = {"robot": 7, "stamp": 123456, "age": 0.025, "x": 1, "y": -0.5, "heading": 1.5707963, "linear": 0.25,
         "angular": -1, "flags": 0x10b, "gripper": 0x85}


def test_a_frame_is_read(module):
    frames = module("frames.js", """
        const bytes = Uint8Array.from(a[0]);
        return m.decodeFrames(bytes.buffer).map(f => ({...f, ranges: f.ranges.map(String)}))""",
                    list(ONE_FRAME + ONE_FRAME[1:]))
    assert len(frames) == 2 and frames[0] == frames[1]
    assert frames[0].pop("ranges") == ["1", "5", "Infinity", "NaN"]
    assert frames[0] == pytest.approx(FRAME)


def test_a_frame_that_is_cut_short_is_refused(module):
    body = """try { m.decodeFrames(Uint8Array.from(a[0]).buffer); return "" } catch (error) { return error.name }"""
    assert module("frames.js", body, list(ONE_FRAME[:-1])) == "RangeError"
    assert module("frames.js", body, list(ONE_FRAME)) == ""


def columns(rows, sonar):
    """Return columns as a recording has them, not compressed."""
    data = b""
    for column in zip(*rows):
        data += struct.pack("<%di" % len(rows), *(after - before for before, after in zip((0,) + column, column)))
    assert len(rows[0]) == 8 + sonar
    return data


ROWS = [(0, 10, 20, 65000, 0, 0, 3, 0, 50, 251), (100, -1500, 20, 66000, 250, -100, 259, 5, 255, 250)]


def test_columns_are_read(module):
    found = module("frames.js", """
        const c = m.decodeColumns(Uint8Array.from(a[0]).buffer, 2, 2), f = m.frameAt(c, 1, 7);
        return [[...c.time], [...c.heading], [...c.flags], {...f,
            ranges: f.ranges.map(String)}]""", list(columns(ROWS, 2)))
    assert found[:3] == [[0, 100], [65000, 66000], [3, 259]]
    assert found[3].pop("ranges") == ["NaN", "5"]
    assert found[3] == pytest.approx({"robot": 7, "stamp": 100, "age": 0, "x": -1.5, "y": 0.02, "heading": 6.3277,
                                      "linear": 0.25, "angular": -0.1, "flags": 259, "gripper": 5}, abs=1e-4)


def test_columns_of_another_length_are_refused(module):
    body = """
        try { m.decodeColumns(Uint8Array.from(a[0]).buffer, 2, 3); return '' } catch (error) { return error.message }"""
    assert "length" in module("frames.js", body, list(columns(ROWS, 2)))


# --- Hand ---

HANDS = {
    "a key": ("h.press('KeyW', false, 0)", [1, 0]),
    "two keys": ("h.press('KeyW', false, 0); h.press('ArrowRight', false, 0)", [1, -1]),
    "against each other": ("h.press('KeyW', false, 0); h.press('KeyS', false, 0)", [0, 0]),
    "another key": ("h.press('KeyQ', false, 0)", None),
    "a repeat": ("h.press('KeyW', true, 0)", None),
    "released": ("h.press('KeyW', false, 0); h.release('KeyW')", None),
    "a stick": ("h.put('stick', [0.5, -0.25])", [0.5, -0.25]),
    "stick and key": ("h.put('stick', [0.5, -0.25]); h.press('KeyW', false, 0)", [1, -0.25]),
    "dropped": ("h.press('KeyW', false, 0); h.drop()", None),
    "dropped, one of two released": (
        "h.press('KeyW', false, 0); h.press('KeyA', false, 0); h.drop(); h.release('KeyW')", None),
    "dropped, then another": ("h.press('KeyW', false, 0); h.drop(); h.press('KeyA', false, 0)", None),
    "dropped, all released, pressed": (
        "h.press('KeyW', false, 0); h.drop(); h.release('KeyW'); h.press('KeyW', false, 1)", [1, 0]),
    "left, repeated": ("h.press('KeyW', false, 0); h.leave(); h.back(50); h.press('KeyW', false, 100)", None),
    "left, repeated long": ("h.press('KeyW', false, 0); h.leave(); h.back(50);"
                            "for (let t = 100; t < 9000; t += 500) h.press('KeyW', false, t)", None),
    "left, pressed much later": (
        "h.press('KeyW', false, 0); h.leave(); h.back(50); h.press('KeyW', false, 1100)", [1, 0]),
    "left, released, pressed": ("h.press('KeyW', false, 0); h.leave(); h.back(50); h.release('KeyW');"
                                "h.press('KeyW', false, 100)", [1, 0]),
    "left, another key": ("h.press('KeyW', false, 0); h.leave(); h.back(50); h.press('KeyA', false, 100)", [0, 1]),
    "a pad that is dropped and still held": ("h.put('pad', [1, 0]); h.drop(); h.put('pad', [1, 0])", None),
    "a pad that is dropped, released, held": (
        "h.put('pad', [1, 0]); h.drop(); h.put('pad', null); h.put('pad', [1, 0])", [1, 0]),
}


@pytest.mark.parametrize("case", sorted(HANDS))
def test_what_a_hand_wants(module, case):
    script, wants = HANDS[case]
    assert module("hand.js", "const h = new m.Hand(); %s; return h.wants()" % script) == wants


@pytest.mark.parametrize("dx, dy, wanted", [(0, 0, [0, 0]), (0.05, 0.05, [0, 0]), (0, -1, [1, 0]), (0, 9, [-1, 0]),
                                            (1, 0, [0, -1]), (-0.55, 0, [0, 0.5]), (3, -4, [0.8, -0.6])])
def test_where_a_stick_is(module, dx, dy, wanted):
    assert module("hand.js", "return m.stickAt(a[0], a[1])", dx, dy) == pytest.approx(wanted)


DEADMAN = """
    const sent = [], d = new m.Deadman(message => sent.push([message.robot, message.forward, message.turn,
        message.stamp]));
    %s; return sent"""


@pytest.mark.parametrize("script, sent", [
    ("d.drawn([1, 0], 7, 500, 1000, 1010)", [[7, 1, 0, 500]]),
    ("d.drawn([1, 0], 7, 500, 1000, 1401)", []),                                       # an old picture
    ("d.drawn([1, 0], 7, 500, 1000, 1010); d.drawn([1, 0], 7, 501, 1050, 1055)", [[7, 1, 0, 500]]),     # too soon
    ("d.drawn([1, 0], 7, 500, 1000, 1010); d.drawn([1, 0], 7, 501, 1050, 1060)", [[7, 1, 0, 500], [7, 1, 0, 501]]),
    ("d.drawn([1, 0], 7, 500, 1000, 1010); d.drawn(null, 7, 501, 1000, 1020); d.drawn(null, 7, 502, 1000, 1090)",
     [[7, 1, 0, 500], [7, 0, 0, 501]]),                                                # zero at once, and once
    ("d.drawn([1, 0], 7, 500, 1000, 1010); d.letGo(); d.letGo()", [[7, 1, 0, 500], [7, 0, 0, 500]]),
    ("d.drawn([1, 0], 7, 500, 1000, 1010); d.drawn([1, 0], 8, 501, 1000, 1100)",
     [[7, 1, 0, 500], [7, 0, 0, 500], [8, 1, 0, 501]]),                                # another robot
    ("d.drawn(null, 7, 500, 1000, 1010); d.letGo()", []),
])
def test_when_a_robot_is_told(module, script, sent):
    assert module("hand.js", DEADMAN % script) == sent


def test_gamepads(module):
    body = """
        const pad = (axes, ...pressed) =>
            ({axes, buttons: [...Array(8).keys()].map(i => ({pressed: pressed.includes(i)}))});
        return [m.readPads([null, pad([0, -1])]), m.readPads([pad([0, 1]), pad([0, -1], 4)]), m.readPads([pad([0, 0],
            1)]),
            m.readPads([]), m.readPads([{...pad([0, -1], 4), connected: false}])]"""
    assert module("hand.js", body) == [
        {"any": True, "stick": None, "stop": False}, {"any": True, "stick": [1, 0], "stop": False},
        {"any": True, "stick": None, "stop": True}, {"any": False, "stick": None, "stop": False},
        {"any": False, "stick": None, "stop": False}]


# --- Camera ---

CAMERA = "const c = new m.Camera(); Object.assign(c, {width: 800, height: 600}); c.fit([0, 0, 4, 2]); %s"


def test_the_camera_goes_there_and_back(module):
    assert module("view.js", CAMERA % "return c.toWorld(c.toScreen([1.25, -3]))") == pytest.approx([1.25, -3])
    x1, y1, x2, y2 = module("view.js", CAMERA % "return [...c.toScreen([0, 0]), ...c.toScreen([4, 2])]")
    assert 0 < x1 < x2 < 800 and 600 > y1 > y2 > 0


def test_zooming_keeps_the_place_under_the_pixel(module):
    body = CAMERA % "const at = c.toWorld([100, 50]); c.zoom(2, [100, 50]); return [at, c.toWorld([100, 50])]"
    before, after = module("view.js", body)
    assert before == pytest.approx(after)


def test_while_following_zooming_keeps_the_middle(module):
    body = CAMERA % "c.follows = true; const {x, y} = c; c.zoom(2, [9, 9]); return [c.x - x, c.y - y]"
    assert module("view.js", body) == [0, 0]


def test_dragging_moves_the_place_under_the_finger(module):
    body = CAMERA % "const at = c.toWorld([300, 200]); c.drag(40, -30); return [...at, ...c.toWorld([340, 170])]"
    found = module("view.js", body)
    assert found[:2] == pytest.approx(found[2:])


def test_zoom_has_ends(module):
    body = CAMERA % "c.zoom(1e9); const near = c.scale; c.zoom(1e-9); return [near, c.scale]"
    assert module("view.js", body) == [800, 3]


@pytest.mark.parametrize("scale, pixels, length", [(100, 120, 1), (50, 120, 2), (20, 120, 5), (300, 100, 0.2),
                                                   (3, 120, 20)])
def test_the_scale_bar_has_a_round_length(module, scale, pixels, length):
    assert module("view.js", "return m.roundLength(a[0], a[1])", scale, pixels) == pytest.approx(length)


# --- Clock and connection ---

def test_a_frame_that_was_held_up_counts_as_old(module):
    body = """const c = new m.Clock(); c.rounds.push(8, 4, 20);
        return [c.sent(1000, 5010), c.sent(1050, 5060), c.sent(1100, 5410), c.sent(1150, 5160)]"""
    assert module("source.js", body) == pytest.approx([5008, 5058, 5108, 5158], abs=0.5)


def test_the_stamp_may_begin_anew(module):
    body = "const c = new m.Clock(); return [c.sent(2 ** 32 - 10, 1000), c.sent(40, 1050), c.sent(90, 1350)]"
    assert module("source.js", body) == pytest.approx([1000, 1050, 1100], abs=0.5)


LIVE = """
    const sockets = [], waits = [], states = [];
    window.WebSocket = function() { sockets.push(this); this.sent = []; this.readyState = 1;
        this.send = text => this.sent.push(JSON.parse(text)); this.close = () => 0; };
    window.setTimeout = (action, ms) => { waits.push(ms); window.again = action; };
    window.setInterval = action => window.ticked = action;
    const live = new m.Live("ws://x/page", {key: "k"}, {text: () => 0, frames: () => 0,
        state: name => states.push(name)});
    const last = () => sockets[sockets.length - 1], hear = data => last().onmessage({data});
    last().onopen();
    %s"""


@pytest.mark.parametrize("code, waits, state", [
    (4400, [], "refused"), (4401, [], "no key"), (4408, [300], "no connection"),
    (4429, [5000], "no connection"), (4409, [5000], "no connection"), (1006, [300], "no connection")])
def test_after_a_connection_ended(module, code, waits, state):
    body = LIVE % "last().onclose({code: a[0], reason: 'because'}); return [waits, states]"
    assert module("source.js", body, code) == [waits, ["connecting", state]]


def test_tries_come_less_often_until_one_succeeds(module):
    body = LIVE % """
        for (let i = 0; i < 5; i++) { last().onclose({code: 1006}); again(); }
        last().onopen(); hear('{"hello": {}}'); last().onclose({code: 1006}); return waits"""
    assert module("source.js", body) == [300, 600, 1200, 2000, 2000, 300]


def test_a_silent_network_is_given_up(module):
    body = LIVE % """
        hear('{"hello": {}}'); live.heard -= a[0]; ticked(); return [states.pop(), last().sent.length]"""
    assert module("source.js", body, 5001) == ["no connection", 2]
    assert module("source.js", body, 1000) == ["live", 3]


def test_pictures_are_acknowledged_at_most_ten_times_a_second_and_the_last_always(module):
    body = LIVE % """
        const frame = stamp => { const b = new Uint8Array(27); b[0] = 1; b[3] = stamp; hear(b.buffer); };
        hear('{"hello": {}}');
        live.drawn(1000); frame(1); live.drawn(1100); frame(2); live.drawn(1150); frame(3); live.drawn(1199);
            live.drawn(1200);
        live.drawn(1400); return last().sent.filter(each => each.do === "drawn").map(each => each.stamp)"""
    assert module("source.js", body) == [1, 3]


def test_nothing_is_said_before_the_server_greets(module):
    assert module("source.js", LIVE % "return [live.send({do: 'stop'}), last().sent]") == [False, [{"key": "k"}]]


# --- Recording and model ---

def test_what_is_compressed_is_unpacked(module):
    body = """
        const {Model} = await import("/model.js");
        const r = new m.Recording({duration: 1, messages: [], columns: [{robot: 7, rows: 2, sonar: 2}]}, new Model());
        await r.unpack(7, Uint8Array.from(a[0])); return [...r.unpacked.get(7).x]"""
    assert module("recording.js", body, list(zlib.compress(columns(ROWS, 2)))) == [10, -1500]


def test_the_pose_in_the_map_begins_where_the_odometry_begins(module):
    body = """
        const model = new m.Model(); model.take("robots", [{robot: 7}]); model.take("origins", {7: [2, 1,
            Math.PI / 2]});
        model.robot(7).take({x: 1, y: 0, heading: 0.5, ranges: []}, 0); return model.pose(model.robot(7))"""
    assert module("model.js", body) == pytest.approx([2, 2, 2.0708], abs=1e-4)


def test_an_echo_is_where_the_sonar_looks(module):
    body = """
        const canvas = document.createElement("canvas"), camera = {x: 0, y: 0, scale: 10}, seen = [];
        const info = {sonar: [[0.1, 0.2, Math.PI / 2], null, [0, 0, 0], [0, 0, 0]]};
        const frame = {ranges: [2, 3, Infinity, NaN]};
        const picture = new m.MapPicture(canvas, canvas, camera), ratio = 10 * devicePixelRatio, pose = [1, 1, Math.PI];
        document.body.append(canvas);
        picture.dress();
        picture.contexts[1].fillRect = function(x, y, width, height) {
            const at = this.getTransform().transformPoint({x: x + width / 2, y: y + height / 2});
            seen.push([at.x / ratio - camera.width / 20, camera.height / 20 - at.y / ratio]);
        };
        picture.onCanvas(1, () => {
            for (const mine of [true, false]) picture.drawEchoes({robot: {info, frame}, mine, pose});
        });
        return seen"""
    assert module("map.js", body) == [pytest.approx([0.9, -1.2])], "the chosen robot has cones instead"


def test_a_robot_that_was_carried_begins_a_new_trail(module):
    body = """
        const model = new m.Model(); model.take("robots", [{robot: 1}]); const robot = model.robot(1);
        for (const x of [0, 0.1, 0.11, 0.2, 5, 5.1]) robot.take({x, y: 0}, 0);
        return robot.trail"""
    assert module("model.js", body) == [[5, 0], [5.1, 0]]


def test_robots_that_go_are_forgotten_and_others_kept(module):
    body = """
        const model = new m.Model(); model.take("robots", [{robot: 2}, {robot: 1}]); const one = model.robot(1);
        model.take("robots", [{robot: 1}, {robot: 3}]); model.take("status", {robot: 9});
        return [model.list.map(each => each.number), one === model.robot(1)]"""
    assert module("model.js", body) == [[1, 3], True]
