"""The P2OS protocol: turns bytes into typed packets, and packets into bytes. No I/O, no clock, no ROS.

A packet, byte by byte (VEL -200: drive backwards at 200 mm/s)::

    FA FB      header, the same in both directions
    06         count: six bytes follow
    0B         id: to the robot, command 11 is VEL; from the robot it would be a packet type
    1B         argument type: negative integer (3B positive integer, 2B string)
    C8 00      200, low byte first: the magnitude; the sign is in the argument type
    D3 1B      checksum of id and data, high byte first

::

    bytes --FrameDecoder--> Frame --decode_packet--> Sip, Config, ...     on the computer's side
                                  --decode_command--> ReceivedCommand     on the robot's side
    encode_command("VEL", -200) --> bytes <-- encode_packet(Sip(...))

======================  =======================================================================
``framing``             where packets begin and end, and the checksum
``commands``            the table of commands to the robot
``simulator_commands``  the table of those that only simulated robots know
``sip``                 the table of the standard SIP, which the robot sends ten times a second
``config``              the table of CONFIGpac, which describes the robot
``packets``             the tables of all other packets from the robot
``flags``               names of bits and numbers
``explain``             explains bytes in words
``recording``           reads, writes and explains the record of a line
======================  =======================================================================

The file `wire_fields` beside this folder reads and writes packets by their tables.

``python3 -m pioneer_control.p2os FA FB 06 ...`` explains these bytes. With ``--record FILE`` it explains a record.
"""

from ..wire_fields import wrapped
from .commands import (BAUD_RATES, COMMANDS, SYNC0, SYNC1, SYNC2, UNKNOWN_TO, Argument, Command, ReceivedCommand,
                       decode_command, encode_command, knows, two_bytes)
from .config import Config
from .flags import (GRIPPER_VALUES, ChargeState, DigitalIn, FaultFlags, Flags, Flags3, GripperCommand, GripperSwitches,
                    GripState, StallBits)
from .framing import PARTIAL_TIMEOUT, DecoderCounts, Frame, FrameDecoder, checksum, encode_frame
from .packets import (IO, TCM2, Arm, ArmInfo, ArmJoint, Battery, BatteryInfo, Encoder, Gripper, Gyro, GyroReading,
                      Joystick, LaserReading, MalformedPacket, Playlist, Reset, SerialAux,
                      SimulatedLaser, SimulatedLaserExtended, SyncEcho, SyncReply, UnknownPacket,
                      decode_packet, encode_packet)
from .simulator_commands import (SIMULATOR_COMMANDS, OrderArgument, SimulatorCommand, SimulatorOrder,
                                 decode_simulator_command, encode_simulator_command)
from .sip import COUNT_RANGE, MOVING, STOPPED, Sip, SonarReading

__all__ = [
    "PARTIAL_TIMEOUT", "DecoderCounts", "Frame", "FrameDecoder", "checksum", "encode_frame",
    "BAUD_RATES", "COMMANDS", "UNKNOWN_TO", "Command", "Argument", "encode_command", "decode_command",
    "ReceivedCommand", "knows", "two_bytes", "SYNC0", "SYNC1", "SYNC2",
    "SIMULATOR_COMMANDS", "SimulatorCommand", "OrderArgument", "SimulatorOrder", "encode_simulator_command",
    "decode_simulator_command", "SimulatedLaser", "SimulatedLaserExtended", "LaserReading",
    "decode_packet", "encode_packet", "UnknownPacket", "MalformedPacket",
    "SyncEcho", "SyncReply", "Config", "Sip", "SonarReading", "STOPPED", "MOVING", "COUNT_RANGE",
    "wrapped",
    "Encoder", "SerialAux", "Gripper", "IO", "Gyro", "GyroReading", "Joystick", "TCM2", "Playlist", "Arm", "ArmInfo",
    "ArmJoint", "BatteryInfo", "Battery", "Reset",
    "Flags", "FaultFlags", "Flags3", "StallBits", "GripState", "GripperSwitches", "GripperCommand", "GRIPPER_VALUES",
    "DigitalIn", "ChargeState",
]
