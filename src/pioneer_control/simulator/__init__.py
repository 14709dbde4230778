"""The robot's side: a world, a body with sonar and gripper in it, the firmware that speaks P2OS for them, and a server of it.

Read from the floor up: ``world`` (by name or from a file: ``loading``), ``body``, ``sonar``, ``gripper``, ``hardware`` (all of one robot, in steps),
``firmware`` (what it obeys: ``handlers``, what it says: ``reports``), ``simulation`` (several robots), ``wired`` (with their lines: ``wire``, and what
goes wrong: ``faults``), ``server`` (in real time: ``lines``). Only ``node`` knows ROS; nothing here knows the client.
"""
