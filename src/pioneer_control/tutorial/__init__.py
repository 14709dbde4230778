"""The program of the ROS wiki tutorial: the robot wanders without touching anything, and picks up cans.

The files that decide and the files that use ROS topics are separate. Read `wander` first.

Files that do not import ROS:

- `wander`: the rule that decides how to move. From a snapshot and a memory it makes a move and a new memory.
- `wandering`: one wander, from its first sonar message to its last.
- `snapshot`: the data that a decision may use.
- `sights`: joins sonar, pose and stall messages that have the same stamp.
- `clearance`: how far the robot can move before it touches something.
- `echoes`: remembers obstacles that the sonars measured a moment ago.
- `pick`: what the gripper reports mean, and the steps of a pick.
- `sender`: publishes messages in a separate thread.

Files that import ROS:

- `pioneer`: the class `Pioneer`, which ``nodes/rosPioneer2.py`` and programs of users use.
- `reports`: subscribes to the topics of the robot.
- `following`: drives by the decisions of a wander, and says them.
- `getting_ready`: waits for the driver, and says what is missing.
- `commander`: publishes commands to the robot.
- `travel`: sends the robot to places on the map; loaded only where a program navigates.
- `goal_client`: sends goals by actionlib, for `travel`.

The tutorial "Controlling Pioneers using p2os (Python)" on the ROS wiki is by Gautham Das. docs/tutorial.md describes
our changes.
"""
