"""Wheels for laptops: what is in them is what the metadata says, and nothing of ROS, simulator or page."""

import base64
import csv
import hashlib
import io
import zipfile

from pioneer_control import __version__
from pioneer_control.web.wheels import all_wheels, make_wheel, own_wheel, package_files


def archive(wheel):
    return zipfile.ZipFile(io.BytesIO(wheel.contents))


def test_our_wheel():
    wheel = own_wheel()
    assert wheel.name == "pioneer_control-%s-py3-none-any.whl" % __version__ and wheel.project == "pioneer-control"
    names = archive(wheel).namelist()
    assert {"pioneer_control/client/robot.py", "pioneer_control/robots/models.yaml", "pioneer_control/p2os/sip.py",
            "pioneer_control/__init__.py"} <= set(names)
    rooms = {name.split("/")[1] for name in names if name.count("/") > 1}
    assert rooms == {"p2os", "robots", "client"} and not [name for name in names if name.endswith(".pyc")]
    metadata = archive(wheel).read("pioneer_control-%s.dist-info/METADATA" % __version__).decode()
    assert "Requires-Dist: PyYAML" in metadata and "Requires-Dist: websocket-client" in metadata
    assert own_wheel() == wheel     # the same bytes each time


def test_the_record_of_every_wheel_is_true():
    wheels = all_wheels()
    assert {wheel.project for wheel in wheels} == {"pioneer-control", "pyyaml", "websocket-client"}
    for wheel in wheels:
        files = archive(wheel)
        record, = [name for name in files.namelist() if name.endswith("/RECORD")]
        rows = {row[0]: row for row in csv.reader(files.read(record).decode().splitlines())}
        assert set(rows) == set(files.namelist())
        for name, (_, digest, size) in rows.items():
            if name != record:
                data = files.read(name)
                made = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
                assert (digest, size) == ("sha256=" + made, str(len(data)))


def test_libraries_have_their_licences_and_nothing_compiled():
    for wheel in all_wheels()[1:]:
        names = archive(wheel).namelist()
        assert any(name.endswith("/LICENSE") for name in names) and not [name for name in names if ".so" in name]


def test_the_index():
    files = package_files([make_wheel("A_b.c", "1.0", {"a.py": b""}, "<a>")])
    assert set(files) == {"/A_b_c-1.0-py3-none-any.whl", "/packages/A_b_c-1.0-py3-none-any.whl",
                          "/packages/a-b-c/A_b_c-1.0-py3-none-any.whl", "/packages/", "/packages/a-b-c/"}
    assert b'<a href="A_b_c-1.0-py3-none-any.whl">' in files["/packages/"].contents
