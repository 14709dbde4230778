"""The ROS node ``p2os_driver``: the client's robot, offered to a ROS graph under the names that p2os users know.

===================  =====================================================================================
``node.py``          open this first: topics, service, parameters and frames are listed in its docstring
``parameters.py``    what can be set, its legal range, and the one frozen object it becomes
``publications.py``  out: all publishers
``conversions.py``   robot state to messages: pure functions, one stamp for all
``requests.py``      in: all subscribers and services
``commands.py``      incoming messages: what is obeyed, what is refused and why
``notices.py``       what a user is warned of, and how often
===================  =====================================================================================
"""
