"""Who may talk to the server, and which files it has."""

import pytest

from pioneer_control.web.guard import is_our_host, is_our_origin, is_teachers, page_files

NAMES = ["localhost", "lab", "lab.local"]


@pytest.mark.parametrize("host", [
    "localhost", "localhost:8080", "LocalHost:8080", "localhost.:8080", "127.0.0.1", "127.0.0.1:8080", "[::1]:8080",
    "[::1]", "192.168.1.5:80", "lab:8080", "lab.local"])
def test_our_hosts(host):
    assert is_our_host(host, NAMES)


@pytest.mark.parametrize("host", [
    "", ":8080", "evil.example", "evil.example:8080", "localhost.evil.example", "127.0.0.1.evil.example:8080", "1",
    "127.1", "localhost:", "localhost:x", "local host", "[localhost]:1.2", "[evil.example]", "0x7f.0.0.1"])
def test_foreign_hosts(host):
    assert not is_our_host(host, NAMES)


@pytest.mark.parametrize("origin, ours", [
    (None, True), ("http://lab:8080", True), ("http://lab", False), ("https://lab:8080", False), ("null", False),
    ("", False), ("http://lab:8081", False), ("http://LAB:8080", False), ("http://evil.example", False),
    ("http://lab:8080/", False), ("http://lab:8080.evil.example", False)])
def test_origins(origin, ours):
    assert is_our_origin(origin, "http", "lab:8080") is ours


@pytest.mark.parametrize("key, found", [
    ("teacher", True), ("visitor", False), ("", None), ("Teacher", None), ("teacher ", None), ("té", None),
    ("\ud800", None)])
def test_keys(key, found):
    assert is_teachers(key, {"teacher": True, "visitor": False}) is found


def test_files_of_the_page(tmp_path):
    page = tmp_path / "page"
    (page / "parts").mkdir(parents=True)
    (tmp_path / "secret.js").write_text("secret")
    for name in ("index.html", "app.js", "parts/map.js", "look.css", "icon.svg", "notes.txt", "app.js.bak", ".hidden"):
        (page / name).write_text(name)
    (page / "link.js").symlink_to(tmp_path / "secret.js")
    files = page_files(page)
    assert set(files) == {"/", "/index.html", "/app.js", "/parts/map.js", "/look.css", "/icon.svg"}
    assert files["/"].mime_type == "text/html; charset=utf-8"
    assert files["/app.js"].mime_type == "text/javascript; charset=utf-8"
    assert files["/look.css"] == ("text/css; charset=utf-8", b"look.css")


def test_no_page(tmp_path):
    assert page_files(tmp_path) == page_files(tmp_path / "missing") == {}
