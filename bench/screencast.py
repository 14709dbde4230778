"""What a browser really showed, and when: the pictures of its screencast, in which each drawing left a mark.

The page's own clock says when its drawing ended. The screencast says when the whole picture of the browser was ready
to be shown. The mark is the time stamp of the newest frame that was drawn, as black and white squares in a corner.
"""

import base64
import io
import json
import threading
import time
from typing import Any, Dict, List, Tuple

import websocket
from PIL import Image

BITS, SQUARE = 20, 8    # of a mark: squares, and their side in pixels
HAS_PICTURE = "const e = document.getElementById('age'); return Boolean(e && /\\d/.test(e.textContent))"
"""Whether the page has drawn a robot: it says then how old its picture is."""

# In the page: notes by the computer's clock when each frame was drawn, at the end of the first picture after it came.
# `drawn` gets the arrival of the robot's packet by the owner's clock (ms) and the end of the drawing by the computer's.
NOTE_DRAWN = """
(() => {
    const came = [], {get, set} = Object.getOwnPropertyDescriptor(WebSocket.prototype, "onmessage");
    let squares = null;
    window.drawn = [];
    function mark(stamp) {
        if (!squares) {
            squares = document.createElement("canvas");
            [squares.width, squares.height] = [%(bits)d * %(square)d, %(square)d];
            squares.style = "position: fixed; left: 0; top: 0; z-index: 999";
            document.body.append(squares);
        }
        const pen = squares.getContext("2d");
        for (let bit = 0; bit < %(bits)d; bit++) {
            pen.fillStyle = stamp >> bit & 1 ? "#fff" : "#000";
            pen.fillRect(bit * %(square)d, 0, %(square)d, %(square)d);
        }
    }
    Object.defineProperty(WebSocket.prototype, "onmessage", {get, set(take) {
        set.call(this, event => {
            if (event.data instanceof ArrayBuffer && new Uint8Array(event.data)[0] === 1) {
                const view = new DataView(event.data);
                for (let at = 1; at < view.byteLength; at += 26 + view.getUint8(at + 25)) {
                    const age = view.getUint16(at + 6, true);
                    if (age < 50) came.push(view.getUint32(at + 2, true) - age);    // older: it repeats an old state
                }
            }
            take.call(this, event);
        });
    }});
    const request = window.requestAnimationFrame;
    window.requestAnimationFrame = draw => request.call(window, time => {
        draw(time);
        const at = performance.timeOrigin + performance.now();
        if (window.marking && came.length) mark(Math.max(...came));
        while (came.length) window.drawn.push([came.shift(), at]);
    });
})();
""" % {"bits": BITS, "square": SQUARE}


def note_drawn(driver: Any) -> None:
    """Let all pages that this browser opens from now on note what they draw."""
    driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": NOTE_DRAWN})


def drawn_delays(driver: Any) -> List[float]:
    """Return the time (s) from the arrival of a packet to the end of its drawing, for all that was drawn since the last
    call.
    """
    offset_ms = 1000 * (time.time() - time.monotonic())
    drawn = driver.execute_script("const all = window.drawn; window.drawn = []; return all")
    return [((at - offset_ms - came) % 2 ** 32) / 1000 for came, at in drawn]


def shown_delays(driver: Any, seconds: float) -> List[float]:
    """Return the time (s) from the arrival of a packet until a picture of the browser showed it."""
    driver.execute_script("window.marking = true")
    offset = time.time() - time.monotonic()
    first: Dict[int, float] = {}
    for at, picture in pictures(driver, seconds):
        colours = Image.open(io.BytesIO(picture)).convert("L")
        mark = sum((colours.getpixel((bit * SQUARE + SQUARE // 2, SQUARE // 2)) > 127) << bit for bit in range(BITS))
        first.setdefault(mark, at - offset)
    driver.execute_script("window.marking = false")
    turn = 2 ** BITS / 1000
    delays = [(at - mark / 1000) % turn for mark, at in first.items()]
    return [delay for delay in delays if delay < turn / 2][1:]      # the first was drawn before the cast began


def pictures(driver: Any, seconds: float) -> List[Tuple[float, bytes]]:
    """Return the pictures that the browser showed in so many seconds, each with its time by the computer's clock."""
    address = driver.capabilities["goog:chromeOptions"]["debuggerAddress"]
    line = websocket.create_connection("ws://%s/devtools/page/%s" % (address, driver.current_window_handle),
                                       suppress_origin=True, timeout=5)
    found: List[Tuple[float, bytes]] = []
    ending = threading.Timer(seconds, lambda: line.send(json.dumps({"id": 2, "method": "Page.stopScreencast"})))
    line.send(json.dumps({"id": 1, "method": "Page.startScreencast", "params": {"format": "jpeg", "quality": 80}}))
    ending.start()
    while True:
        message = json.loads(line.recv())
        if message.get("id") == 2:
            line.close()
            return found
        if message.get("method") == "Page.screencastFrame":
            cast = message["params"]
            line.send(json.dumps({"id": 3, "method": "Page.screencastFrameAck",
                                  "params": {"sessionId": cast["sessionId"]}}))
            found.append((cast["metadata"]["timestamp"], base64.b64decode(cast["data"])))
