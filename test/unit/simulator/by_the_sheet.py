"""The protocol once more, written from the tables of the protocol sheet alone. It shares nothing with the package.

It makes the bytes of commands, and reads the values of a robot's bytes. It is strict: a missing byte, or a byte that
belongs to no field, is an AssertionError.
"""

import struct
from typing import Any, Dict, List, NamedTuple, Tuple


class Packet(NamedTuple):
    """One packet of a robot: its id and its values by name."""

    id: int
    values: Dict[str, Any]


# Section 1: framing

def checksum(body: bytes) -> int:
    """Return the sum of words, high byte first. An odd last byte is XORed."""
    total = 0
    for at in range(0, len(body) - 1, 2):
        total = (total + (body[at] << 8) + body[at + 1]) & 0xFFFF
    return total ^ body[-1] if len(body) % 2 else total


def framed(body: bytes) -> bytes:
    """Return the packet with this id and data."""
    return b"\xFA\xFB" + bytes([len(body) + 2]) + body + checksum(body).to_bytes(2, "big")


def command(number: int, value: Any = None) -> bytes:
    """Return a command without argument, with an integer (sign in the type byte), or with a string."""
    if value is None:
        return framed(bytes([number]))
    if isinstance(value, bytes):
        return framed(bytes([number, 0x2B, len(value)]) + value)
    return framed(bytes([number, 0x1B if value < 0 else 0x3B]) + abs(value).to_bytes(2, "little"))


def bodies(stream: bytes) -> List[bytes]:
    """Return id and data of every packet of a stream that has nothing but whole packets."""
    found, at = [], 0
    while at < len(stream):
        assert stream[at:at + 2] == b"\xFA\xFB", "no header at %d" % at
        assert len(stream) > at + 2 and stream[at + 2] >= 3, "no count at %d" % at
        end = at + 3 + stream[at + 2]
        assert stream[at + 2] <= 200 and end <= len(stream), "count of %d bytes at %d" % (stream[at + 2], at)
        body = stream[at + 3:end - 2]
        assert checksum(body) == int.from_bytes(stream[end - 2:end], "big"), "checksum at %d" % at
        found.append(body)
        at = end
    return found


# Sections 2.2, 4 and 5: fields. B, H, I unsigned, b, h, i signed, of 1, 2, 4 bytes; z a string with its NUL

SYNC2 = "name z class z subclass z"
SIP_HEAD = "x H y H th h lvel h rvel h battery B stall_low B stall_high B control h flags H compass B"
SIP_TAIL = "analog B digin B digout B battery_x10 H charge_state B rotvel h fault H"
# The last field of a family's SIP. All other families end with fault.
SIP_LAST = {"PSOS": "digout", "P2OS": "digout", "AmigOS": "digout", "AROS": "digout", "AmigoSH": "charge_state"}
PORT_FIRST = ("PSOS", "P2OS", "AmigOS", "uARCS", "MARCOS")      # nobody says it of the last two
CONFIG = (
    "type z subtype z serial z four_mots B rot_vel_top H trans_vel_top H rot_acc_top H trans_acc_top H pwm_max H"
    " name z sip_cycle B host_baud B aux1_baud B has_gripper H front_sonar H rear_sonar B low_battery H rev_count H"
    " watchdog H p2mpacs B stall_val H stall_count H joy_vel H joy_rvel H rot_vel_max H trans_vel_max H"
    " rot_acc H rot_decel H rot_kp H rot_kv H rot_ki H trans_acc H trans_decel H trans_kp H trans_kv H trans_ki H"
    " front_bumps B rear_bumps B charger B sonar_cycle B auto_baud B has_gyro B drift_factor h aux2_baud B"
    " aux3_baud B ticks_mm H"
    " shutdown_volts H version z gyro_cw H gyro_ccw H kinematics_delay B lat_vel_top H lat_acc_top H lat_vel_max H"
    " lat_acc H lat_decel H charge_threshold H"
)
# The last field of a family's CONFIGpac. All other families end with charge_threshold.
CONFIG_LAST = {"P2OS": "trans_ki", "AmigOS": "trans_ki", "AROS": "has_gyro", "AmigoSH": "version"}
PLAIN = {
    0x90: "left i right i",
    0xA0: "status B motion B servo1 B servo2 B servo3 B servo4 B servo5 B servo6 B",
    0xC0: "heading h pitch h roll h mag_x h mag_y h mag_z h temperature h error H cal_h B cal_v B cal_m h",
    0xE0: "has_gripper B state B grasp_time B",
    0xF8: "button1 B button2 B x H y H throttle H",
    0xFF: "",
}


class Reader:
    """Takes one field after the other from the front of the data."""

    def __init__(self, data: bytes):
        self.data = data

    def fields(self, table: str, last: str = "") -> Dict[str, Any]:
        """Return the values of a table, up to its field `last`."""
        words = table.split()
        values = {}
        for name, kind in zip(words[::2], words[1::2]):
            values[name] = self.one(kind)
            if name == last:
                break
        return values

    def one(self, kind: str) -> Any:
        """Return one value."""
        if kind == "z":
            text, nul, self.data = self.data.partition(b"\0")
            assert nul, "a string without end"
            return text.decode("ascii")
        size = struct.calcsize("<" + kind)
        assert len(self.data) >= size, "%d bytes missing" % (size - len(self.data))
        value, = struct.unpack("<" + kind, self.data[:size])
        self.data = self.data[size:]
        return value

    def many(self, count: int, kind: str) -> Tuple[int, ...]:
        """Return so many values of a kind."""
        return tuple(self.one(kind) for _ in range(count))

    def bytes(self, count: int) -> bytes:
        """Return so many bytes, unchanged."""
        assert len(self.data) >= count
        taken, self.data = self.data[:count], self.data[count:]
        return taken


def decode(body: bytes, family: str) -> Packet:
    """Return the values of a packet, to the last byte."""
    number, reader = body[0], Reader(body[1:])
    if number in (0, 1):
        values = {}
    elif number == 2:
        values = reader.fields(SYNC2)
    elif number in (0x32, 0x33):
        values = reader.fields(SIP_HEAD)
        values["sonar"] = [(reader.one("B"), reader.one("H")) for _ in range(reader.one("B"))]
        values.update(reader.fields("port B grip B" if family in PORT_FIRST else "grip B port B"))
        values.update(reader.fields(SIP_TAIL, SIP_LAST.get(family, "fault")))
    elif number == 0x20:
        values = reader.fields(CONFIG, CONFIG_LAST.get(family, "charge_threshold"))
    elif number == 0xF0:
        kinds = (("inputs", "B"), ("outputs", "B"), ("analog", "H"))
        values = {name: reader.many(reader.one("B"), kind) for name, kind in kinds}
    elif number == 0x98:
        values = {"readings": [(reader.one("H"), reader.one("B")) for _ in range(reader.one("B"))]}
    elif number == 0xFA:
        count, size = reader.one("B"), reader.one("B")
        assert size == 5
        values = {"batteries": [reader.many(5, "B") for _ in range(count)]}
    elif number == 0xA1:
        values = {"version": reader.one("z"), "joints": [reader.many(6, "B") for _ in range(reader.one("B"))]}
    elif number == 0xD0 and len(body) == 26:
        assert reader.bytes(25) == bytes(25)
        values = {}
    elif number == 0xD0:
        values = {
            "sound": reader.one("B"), "on": reader.one("B"), "name": reader.bytes(16),
            "offset": reader.one("I"), "length": reader.one("I"),
        }
    elif number == 0x60:
        values = reader.fields("x h y h th h total H first H")
        values["readings"] = [(reader.one("H"), 0) for _ in range(reader.one("B"))]
    elif number == 0x61:
        values = reader.fields("total H first H")
        values["readings"] = [(reader.one("H"), reader.one("B"), reader.one("H"))[:2] for _ in range(reader.one("B"))]
        values.update(reader.fields("laser B flags B"))
    elif number in (0xB0, 0xB8, 0xC8):
        values = {"bytes": reader.bytes(len(reader.data))}
        assert values["bytes"]
    else:
        assert number in PLAIN, "no such packet: %02X" % number
        values = reader.fields(PLAIN[number])
    assert reader.data == b"", "%d bytes left over in %02X" % (len(reader.data), number)
    return Packet(number, values)


def decode_all(stream: bytes, family: str) -> List[Packet]:
    """Return the values of every packet of a stream."""
    return [decode(body, family) for body in bodies(stream)]
