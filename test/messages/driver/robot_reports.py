"""States for the tests of the driver's messages: from worked packets, and one made by hand.

Source: protocol sheet 4.5, 5.
"""

import io
import math

import nav_msgs.msg
import rospy

from pioneer_control import client, p2os
from pioneer_control.client.identity import identify
from pioneer_control.client.odometry import Odometry
from pioneer_control.client.state import StateReader
from pioneer_control.driver import conversions, prompt
from pioneer_control.driver.parameters import DriverParameters
from pioneer_control.msg import SonarArray
from pioneer_control.p2os import Flags
from pioneer_control.robots import find_model

DRIVING = "FAFB2833D204C8FF0002BE00D20080000200020700000203DC05049808210500F00080000020000000260D"
STALLED = "FAFB2532F87F0A0000F8000000007E010100F8200000010088136201FFCF05FD000100000800AF70"
OLD = "FAFB1B3200000000000000000000820000000000000000000000FFFF337E"
GYRO = "FAFB109804000278FE0178FF01780102788BF6"
IO = "FAFB15F004F000000F01050500000002FF03FF072C01F443"
GRIPPER_SWITCHES = "FAFB06E002B30A930C"

STAMP = rospy.Time(12, 340000000)
STATE = client.RobotState(
    time=100.0, sent_time=99.96, x=1.5, y=-0.25, heading=math.pi / 2, linear=0.2, angular=-0.1,
    wheel_velocities=(0.22, 0.18), wheel_angles=(3.0, -2.0), x_counts=1500, y_counts=-250, motors_enabled=True,
    stop_button=False, left_stall=False, right_stall=False, front_bumpers=(), rear_bumpers=(), battery_voltage=12.8,
    sonar=(
        client.SonarRange(1.5, 99.9), client.SonarRange(5.0, 99.0), client.SonarRange(0.8, 97.9), None,
        client.SonarRange(5.4, 100.0)),
    sonar_enabled=True, gripper=None, digital_in=0xF0, digital_out=0, analog_port=5, analog_voltage=2.5,
    flags=Flags(7), fault_flags=None, compass=None, charge_state=None, temperature=None, state_of_charge=None,
)
READING = client.GripperReading(*[False] * 12)


def identity_of(subtype="p3dx-sh", name="fake", gripper=None, **config):
    """Return the identity of a robot with these values in CONFIGpac, or without a CONFIGpac."""
    reply = p2os.SyncReply(name, "Pioneer", subtype)
    said = p2os.Config(type="Pioneer", subtype=subtype, serial="", **config) if config else None
    return identify(reply, find_model(subtype), said, has_gripper=gripper)


def packet_of(text, grip_state_first=True):
    """Return a packet from its bytes as hex."""
    frame, = p2os.FrameDecoder().feed(bytes.fromhex(text))
    return p2os.decode_packet(frame, grip_state_first)


def state_of(text, identity=None):
    """Return the state of a robot that sent this SIP."""
    identity = identity or identity_of()
    odometry = Odometry(identity.model.dist_mm_per_unit, identity.model.angle_units_per_rev)
    sip, reader = packet_of(text, identity.model.grip_state_first), StateReader(identity, odometry)
    return reader.read(sip, 100.0, 100.0)


def received(message, kind):
    """Return this message as a subscriber receives it."""
    return kind().deserialize(written(message, message.header.seq if hasattr(message, "header") else 0))


def written(message, count):
    """Return the bytes that a subscriber gets for a message that is the ``count``-th of its topic."""
    if isinstance(message, prompt.PromptMessage):
        message.header.seq = count
        return message.serialized()
    buffer = io.BytesIO()
    rospy.msg.serialize_message(buffer, count, message)
    return buffer.getvalue()[4:]    # behind its length


def odometry_of(motion, stamp=STAMP, odom_frame="odom", base_link_frame="base_link", parameters=DriverParameters()):
    """Return the Odometry that a subscriber to `pose` receives."""
    message = prompt.PoseMessage(odom_frame, base_link_frame, conversions.covariances(parameters))
    return received(message.of(motion, stamp), nav_msgs.msg.Odometry)


def sonar_array_of(state, stamp=STAMP, base_link_frame="base_link"):
    """Return the SonarArray that a subscriber to `sonar` receives."""
    return received(conversions.sonar(state, stamp, base_link_frame), SonarArray)
