"""Tasks for robots that the simulator scores itself, from the true state of its world. No ROS.

``tasks.yaml`` has the tasks: what to do, how long it may take, which rule gives the points; ``arenas`` the floor of
each.

``task``     one task with its arena; reads the table and the arenas
``floor``    which floor of an arena a robot can get to, and how long the ways are
``scores``   the rules: samples of what a robot does come in, points and a note come out
``arena``    one world of many floors: the base world and a copy of each arena for each robot
``referee``  which task is chosen, who has begun, how many points each robot has

Only `__main__`, which runs a program at a task, uses sockets and processes.
"""

from .arena import Grounds
from .referee import Referee
from .task import Task, load_tasks

__all__ = ["Grounds", "Referee", "Task", "load_tasks"]
