"""The robot's side: a world, a body with sonar and gripper in it, the firmware that speaks P2OS for them, and a server of it.

Read from the floor up: ``world`` (and ``loading``, ``generated``, ``worlds/*.yaml``), ``body``, ``sonar``, ``gripper``, ``firmware`` (one robot),
``simulation`` (several), ``wired`` (with their lines: ``wire``, and what goes wrong: ``faults``), ``server`` (in real time: ``lines``).
Only ``node`` knows ROS; nothing here knows the client.
"""
