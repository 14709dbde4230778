"""The web server against those who mean it no good, and those who are slow: refused, closed, and nobody else notices.
"""

import http.client
import json
import socket
import time

import pytest
import websocket

from web_site import Viewer, site_with_robot, wait_closed
from real_time import LIMIT, until


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    with site_with_robot(tmp_path_factory.mktemp("site")) as (running, _, _):
        yield running


@pytest.fixture(autouse=True)
def others_notice_nothing(site):
    """A good viewer sees the picture before and after, from the same server, and the log has no word about it."""
    with Viewer(site, visitor="goodviewer0123456") as good:
        good.picture()
        pid = site.server_pid()
        yield
        stamp = good.frames[1].stamp
        until(lambda: good.frames[1].stamp != stamp, "the picture goes on")
        assert site.server_pid() == pid and good.closed is None
    assert site.key not in site.errors and "WebSocket" not in site.errors and "Traceback" not in site.errors


def get(site, path="/", method="GET", **headers):
    """Send one HTTP request just as it is. Returns the answer, with its body as ``text``."""
    connection = http.client.HTTPConnection("127.0.0.1", site.port, timeout=LIMIT)
    connection.putrequest(method, path, skip_host="Host" in headers, skip_accept_encoding=True)
    for name, value in headers.items():
        connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    answer.text = answer.read().decode()
    connection.close()
    return answer


def refused(site, **options):
    """Try to open a WebSocket. Returns the HTTP status with which it is refused."""
    with pytest.raises(websocket.WebSocketBadStatusException) as caught:
        websocket.create_connection(site.base.replace("http", "ws") + "page", timeout=LIMIT, **options)
    return caught.value.status_code


# Files

def test_the_page_and_its_headers(site):
    answer = get(site)
    assert answer.status == 200 and "<title>page" in answer.text
    assert answer.headers["Content-Type"] == "text/html; charset=utf-8"
    assert answer.headers["Content-Security-Policy"].startswith("default-src 'none'; script-src 'self'")
    assert answer.headers["X-Content-Type-Options"] == "nosniff" and answer.headers["Referrer-Policy"] == "no-referrer"
    script = get(site, "/app.js")
    assert script.status == 200 and script.headers["Content-Type"] == "text/javascript; charset=utf-8"
    head = get(site, "/app.js", "HEAD")
    assert head.status == 200 and head.text == "" and int(head.headers["Content-Length"]) == len(script.text)
    again = get(site, "/app.js", **{"If-None-Match": script.headers["Etag"]})
    assert again.status == 304


@pytest.mark.parametrize("path", [
    "/../secret.txt", "/..%2fsecret.txt", "/%2e%2e/secret.txt", "//etc/passwd", "/page/../../secret.txt", "/etc/passwd",
    "/app.js/", "/app.js%00.html", "/.", "/..", "/static/", "/\\..\\secret.txt", "/index.html/../../secret.txt",
    "http://127.0.0.1/../secret.txt"])
def test_no_other_file_of_the_machine(site, path):
    answer = get(site, path)
    assert answer.status == 404 and "secret" not in answer.text and "root:" not in answer.text
    assert answer.headers["Content-Security-Policy"]


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "BREW"])
def test_only_get_and_head(site, method):
    assert get(site, "/", method, **{"Content-Length": "0"}).status == 405


@pytest.mark.parametrize("path", ["/", "/app.js", "/page", "/missing"])
def test_a_foreign_host_gets_nothing(site, path):
    for host in ("evil.example", "evil.example:%d" % site.port, "127.0.0.1.evil.example"):
        answer = get(site, path, Host=host)
        assert answer.status == 421 and "page" not in answer.text
    assert get(site, "/", Host="localhost:%d" % site.port).status == 200


# Who may come

def test_a_foreign_origin_is_refused(site):
    for origin in ("http://evil.example", "null", "http://127.0.0.1", "https://127.0.0.1:%d" % site.port,
                   "http://localhost:%d" % site.port):
        assert refused(site, origin=origin) == 403


def test_a_foreign_host_opens_no_websocket(site):
    assert refused(site, host="evil.example") == 421
    assert refused(site, host="evil.example", origin="http://evil.example") == 421


def test_a_program_without_origin_needs_the_key_too(site):
    with Viewer(site, suppress_origin=True) as viewer:
        viewer.picture()
    with Viewer(site, key="wrong", suppress_origin=True) as viewer:
        assert wait_closed(viewer)[0] == 4401


@pytest.mark.parametrize("key", ["", "wrong", "é", "x" * 3000])
def test_without_the_key_not_a_word(site, key):
    with Viewer(site, key=key) as viewer:
        code, reason = wait_closed(viewer)
        assert code == 4401 and "address" in reason and viewer.texts == [] and viewer.frames == {}


def test_the_key_does_not_belong_into_the_address(site):
    with pytest.raises(websocket.WebSocketBadStatusException, match="400"):
        websocket.create_connection(site.base.replace("http", "ws") + "page?key=" + site.key, timeout=LIMIT)
    assert get(site, "/page?key=" + site.key).status == 400
    assert get(site, "/?key=" + site.key).status == 200     # the page; the key means nothing there


@pytest.mark.parametrize("words", [
    "", "hello", "[]", '{"key": 1, "visitor": "aaaaaaaaaaaaaaaa"}', '{"key": "k"}', '{"do": "stop", "robot": "all"}',
    "[" * 4000, '{"key": "k", "key": "k", "visitor": "aaaaaaaaaaaaaaaa"}'])
def test_first_words_that_make_no_sense(site, words):
    connection = websocket.create_connection(site.base.replace("http", "ws") + "page", timeout=LIMIT)
    connection.send(words)
    code, data = connection.recv_data()
    assert code == websocket.ABNF.OPCODE_CLOSE and data[:2] == (4400).to_bytes(2, "big") and data[2:]
    connection.shutdown()


def test_the_61st_viewer_is_told_why(site):
    viewers = []
    try:
        for number in range(59):        # one looks on already
            viewers.append(Viewer(site, visitor="crowd%012d" % number))
        until(lambda: all(viewer.frames for viewer in viewers), "59 more see the picture")
        with Viewer(site) as late:
            code, reason = wait_closed(late)
            assert code == 4429 and "60" in reason
        viewers.pop().__exit__()
        with Viewer(site) as later:
            later.picture()
    finally:
        for viewer in viewers:
            viewer.__exit__()


# What they send

@pytest.mark.parametrize("text", [
    "nonsense", '{"do": "ping", "at": NaN}', '{"do": "say", "text": "%s"}' % ("x" * 4090)])
def test_a_message_that_makes_no_sense_closes(site, text):
    with Viewer(site) as viewer:
        viewer.picture()
        viewer.socket.send(text)
        code, reason = wait_closed(viewer)
        assert code == 4400 and reason


def test_a_huge_message_closes(site):
    with Viewer(site) as viewer:
        viewer.picture()
        try:
            viewer.socket.send("x" * 10000000)
        except OSError:
            pass
        until(lambda: viewer.closed or not viewer._thread.is_alive(), "the connection is closed")


def test_binary_closes(site):
    with Viewer(site) as viewer:
        viewer.picture()
        viewer.socket.send_binary(b"\x01\x02\x03")
        assert wait_closed(viewer)[0] == 4400


def test_a_wrong_order_is_answered_and_does_nothing(site):
    with Viewer(site) as viewer:
        viewer.picture()
        viewer.send(do="gripper", robot=1, command="explode")
        until(lambda: viewer.said('command is "explode"; legal: open, close'), "the reason")
        viewer.send(do="fly")
        until(lambda: viewer.said('do is "fly"'), "the reason")
        viewer.send(do="ping", at=2.5)
        until(lambda: viewer.of("pong") == [2.5], "the answer")


def test_a_flood_closes(site):
    with Viewer(site, draws=False) as viewer:
        viewer.picture()
        for _ in range(300):
            try:
                viewer.send(do="ping", at=1)
            except (OSError, websocket.WebSocketException):
                break
        code, reason = wait_closed(viewer)
        assert code == 4429 and "100" in reason


def test_names_and_the_teachers_words(site):
    with Viewer(site, visitor="ada0123456789abcdef") as ada, Viewer(site) as other:
        ada.picture()
        other.picture()
        ada.do("name", name="Ada <b>")
        ada.do("say", text="come here")
        until(lambda: other.said("Ada <b>: come here"), "the words")
    with Viewer(site, visitor="ada0123456789abcdef") as ada:
        until(lambda: ada.newest("hello"), "hello")
        assert ada.newest("hello")["you"] == "Ada <b>"


def test_half_frames_and_half_requests_hold_nobody_up(site):
    sockets = []
    host = b"Host: 127.0.0.1\r\n"
    for data in (b"GET /", b"GET /page HTTP/1.1\r\n" + host + b"Upgrade: websocket\r\n", b"\x16\x03\x01\x02\0\x01",
                 b"GET / HTTP/1.1\r\n" + host + b"X: y\r\n" * 10000, b"\0" * 100000):
        sockets.append(socket.create_connection(("127.0.0.1", site.port), timeout=LIMIT))
        sockets[-1].sendall(data)
    viewer = websocket.create_connection(site.base.replace("http", "ws") + "page", timeout=LIMIT)
    viewer.send(json.dumps({"key": site.key, "visitor": "half0123456789abcd"}))
    viewer.sock.sendall(b"\x81\xfe\x0f\xff\0\0\0\0half a frame")        # a text of 4095 bytes begins
    sockets.append(viewer.sock)
    assert get(site).status == 200
    for each in sockets:
        each.close()


# Those who are slow

def test_who_does_not_draw_gets_no_more_frames_until_it_does(site):
    with Viewer(site, draws=False) as viewer:
        viewer.picture()
        until(lambda: time.monotonic_ns() and viewer.messages >= 5, "some frames")
        count = None
        while count != viewer.messages:         # until none came for a second
            count = viewer.messages
            time.sleep(1.0)
        old = viewer.frames[1].stamp
        viewer.do("drawn", stamp=old)
        until(lambda: viewer.frames[1].stamp != old, "the newest")
        assert (viewer.frames[1].stamp - old) % 2 ** 32 > 800
