"""The ROS node ``p2os_driver``: the client's robot, offered to a ROS graph under the names that p2os users know.

====================  ====================================================================================
``node.py``           joins what follows with one robot; docs/driver.md lists what it offers
``parameters.py``     what can be set, its legal range, and the one frozen object it becomes
``publications.py``   out: all publishers, in one table
``conversions.py``    robot state to messages: pure functions, one stamp for all
``prompt.py``         makes messages leave sooner; to be skipped by a reader
``wire_topic.py``     out: every byte of the robot's line
``requests.py``       in: all subscribers and services, in two tables
``commands.py``       incoming messages that are more than a velocity: what is obeyed, what is refused and why
``senders.py``        who sent a command: a player of bags is not obeyed
``reconfigure.py``    in: parameters that change while the driver runs
``notices.py``        what a user is warned of, and how often
``health.py``         what diagnostics say of a robot, by REP 107: pure
``fault_flags.py``    what the robot's own fault flags mean for that
``diagnostics.py``    out: publishes it, once a second and when a level changes
====================  ====================================================================================
"""
