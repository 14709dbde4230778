"""The ROS node ``p2os_driver``: the client's robot, offered to a ROS graph under the names that p2os users know.

===================  =====================================================================================
``node.py``          joins what follows with one robot; docs/driver.md lists what it offers
``parameters.py``    what can be set, its legal range, and the one frozen object it becomes
``publications.py``  out: all publishers
``conversions.py``   robot state to messages: pure functions, one stamp for all
``ranges.py``        ... and what the sonar heard
``prompt_*.py``      what must not wait: messages that are written in one go, and a connection that sends them at once
``requests.py``      in: all subscribers and services
``commands.py``      incoming messages: what is obeyed, what is refused and why
``reconfigure.py``   in: parameters that change while the driver runs
``notices.py``       what a user is warned of, and how often
``health.py``        what diagnostics say of a robot, by REP 107: pure
``diagnostics.py``   out: publishes it, once a second and when a level changes
===================  =====================================================================================
"""
