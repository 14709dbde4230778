"""The nine messages that p2os has too, each with a value in every field, under any package's name."""

import io

import bag_factory as make

OLD_PACKAGES = ("p2os_driver", "p2os_msgs")
HEADER = {"header.seq": 7, "header.stamp.secs": 1234, "header.stamp.nsecs": 5, "header.frame_id": "sonar"}
GRIP = dict(state=2, dir=-1, inner_beam=True, outer_beam=True, left_contact=True, right_contact=True)
LIFT = dict(state=1, dir=1, position=0.5)

# A value for every field, none of them what an untouched message holds.
VALUES = {
    "SonarArray": dict(HEADER, ranges_count=3, ranges=[0.5, 5.0, 1.25]),
    "GripperState": {**{"grip.%s" % name: value for name, value in GRIP.items()},
                     **{"lift.%s" % name: value for name, value in LIFT.items()}},
    "GripState": GRIP,
    "LiftState": LIFT,
    "MotorState": dict(state=1),
    "BatteryState": dict(HEADER, voltage=12.5),
    "DIO": dict(count=8, bits=165),
    "AIO": dict(voltages_count=1, voltages=[2.5]),
    "PTZState": dict(pan=10, tilt=-5, zoom=100, relative=True),
}  # fmt: skip


def old_message(name, package):
    """Return a message of a package with a value in every field."""
    message = make.message_class(name, package)()
    for path, value in VALUES[name].items():
        *steps, last = path.split(".")
        part = message
        for step in steps:
            part = getattr(part, step)
        setattr(part, last, value)
    return message


def serialized(message):
    """Return the bytes of a message, as they are on the line and in a bag."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()
