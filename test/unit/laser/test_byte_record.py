"""The record of all bytes on the line of a laser."""

import re

import pytest

from pioneer_control.errors import ParameterError
from pioneer_control.laser.byte_record import ByteRecord


class Echo:
    """A port that returns what was written to it."""

    def __init__(self, url, baud):
        self.opened, self.data = (url, baud), b""

    def read(self, timeout):
        data, self.data = self.data, b""
        return data

    def write(self, data):
        self.data += data


def test_all_bytes_are_in_the_file_with_their_times(tmp_path):
    path = tmp_path / "laser.txt"
    record = ByteRecord(str(path))
    port = record.opener(Echo)("/dev/x", 9600)
    assert port.opened == ("/dev/x", 9600)
    port.write(b"\x02\x00\xAB")
    assert port.read(0.0) == b"\x02\x00\xAB" and port.read(0.0) == b""
    record.close()
    assert re.fullmatch(r"\d\.\d{6} > 02 00 AB\n\d\.\d{6} < 02 00 AB\n", path.read_text())


def test_a_file_that_cannot_be_written(tmp_path):
    with pytest.raises(ParameterError, match="~record: .* cannot be written: Is a directory"):
        ByteRecord(str(tmp_path))


def test_a_full_disk_does_no_harm():
    record = ByteRecord("/dev/full")
    record.write(True, b"\x02")
    record.close()
