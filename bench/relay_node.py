#!/usr/bin/python3
"""A rospy node that only relays bytes, as little as one can do. Never drive with it.

It is the floor that bench/driver.py measures the driver against.

    python3 bench/relay_node.py PORT [three]

It publishes one fixed Odometry on `pose` for each SIP_LENGTH bytes that it reads, and writes VEL and RVEL for each
`cmd_vel`. Nothing is parsed, checked, clamped or timed out. With `three` it also publishes a fixed SonarArray on
`sonar` and a fixed transform on `/tf`. The driver publishes these, too, when somebody listens.
"""

import os
import struct
import sys

import rospy
from geometry_msgs.msg import TransformStamped, Twist
from nav_msgs.msg import Odometry
from tf2_msgs.msg import TFMessage

from pioneer_control.msg import SonarArray

SIP_LENGTH = 85
"""Bytes of the SIPs that the bench's robot sends: ARCOS, 16 sonar readings."""
RVEL_0 = bytes.fromhex("FA FB 06 15 3B 00 00 15 3B")


def main():
    port = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
    rospy.init_node("relay")
    messages = {"pose": Odometry()}
    if "three" in sys.argv:
        messages.update({"/tf": TFMessage([TransformStamped()]),
                         "sonar": SonarArray(ranges_count=16, ranges=[1.0] * 16)})
    topics = [(rospy.Publisher(name, type(message), queue_size=10, tcp_nodelay=True), message)
              for name, message in messages.items()]

    def write(twist):
        """Write a whole number of mm/s forward, 0 to 999, and no turn."""
        speed, = struct.unpack(">H", struct.pack("<H", round(twist.linear.x * 1000)))
        os.write(port, struct.pack(">HBHHH", 0xFAFB, 6, 0x0B3B, speed, 0x0B3B + speed & 0xFFFF) + RVEL_0)

    rospy.Subscriber("cmd_vel", Twist, write, queue_size=3, tcp_nodelay=True)      # as the driver
    length = 0
    while not rospy.is_shutdown():
        length += len(os.read(port, 4096))
        while length >= SIP_LENGTH:
            length -= SIP_LENGTH
            for publisher, message in topics:
                publisher.publish(message)


if __name__ == "__main__":
    main()
