"""How many bytes of an answer are requested, by what came of it. The robot waits until all of them are there."""

import pytest

from pioneer_control.ptz import AuxCamera, Cabling, CameraSession, CameraSettings
from pioneer_control.p2os import SerialAux, encode_command

ACCEPTED = bytes.fromhex("FE 30 30 30 30 EF")


def asking(cabling=Cabling.TWO_WAY):
    """Return a session that waits for where its camera looks."""
    session = CameraSession(CameraSettings(cabling=cabling))
    session.line_up(0.0)
    session.receive(ACCEPTED, 0.1)                                      # of the control
    session.receive(bytes.fromhex("FE 30 30 30 30 30 30 30 30 30 EF"), 0.2)     # its long status: all is done already
    for _ in range(3):
        session.receive(ACCEPTED, 0.3)                                  # of speeds and range
    assert session.take_output()[-1].data[4] == 0x63
    return session


@pytest.mark.parametrize("heard, missing", [
    ("", 6), ("FE 30 30", 3), ("FE 30 30 30 30 37", 8), ("00 FE 30 30 30 30", 9), ("00 FE 30 30 31 30", 1),
    ("FE 30 30 30 31 37", 8), ("FE 30 30 30", 2),
    ("00 00 00 FE 30 30", 3), ("FE 30 30 30 30 37 45 37 30 38 30 42 32", 1),
])
def test_the_bytes_that_are_missing(heard, missing):
    session = asking()
    session.receive(bytes.fromhex(heard), 0.4)
    assert session.answer_missing == missing and not session.has_output


def test_nothing_is_missing_of_a_camera_that_never_answers():
    session = CameraSession(CameraSettings(cabling=Cabling.ONE_WAY))
    session.line_up(0.0)
    assert session.answer_missing == 0 and not session.take_output()[0].is_answered


def test_the_rest_is_requested_once():
    session = CameraSession(CameraSettings())
    camera = AuxCamera(session, 1)
    camera.connected(None, 0.0)
    assert camera.take_commands()[-1] == encode_command("GETAUX", 6)
    camera.packet(SerialAux(1, ACCEPTED), 0.1)
    assert camera.take_commands()[-1] == encode_command("GETAUX", 6)        # for its long status, which has 11
    camera.packet(SerialAux(2, ACCEPTED), 0.2)
    camera.packet("another packet", 0.2)
    assert camera.take_commands() == []
    camera.packet(SerialAux(1, bytes.fromhex("00 00 00 FE 30 30")), 0.3)
    assert camera.take_commands() == [encode_command("GETAUX", 3)]
    camera.packet(SerialAux(1, bytes.fromhex("30 30 30")), 0.4)
    assert session.answer_missing == 5 and camera.take_commands() == []     # two for one answer are enough
    camera.tick(1.2)
    assert camera.take_commands()[0] == encode_command("GETAUX", 0)         # asked again
