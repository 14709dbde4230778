"""The wiki tutorial's robot: it wanders without touching anything, and picks up cans.

Deciding and talking are kept apart. Open `wander` first.

Pure, without ROS:

- `wander`: the rule. A snapshot and a memory go in, a move and a memory come out.
- `wandering`: one wander, from its first sonar message to its last.
- `snapshot`: what a decision may look at.
- `sights`: joins what the robot reported of one moment.
- `clearance`: how far a body can go before it touches something.
- `echoes`: what the sonars saw a moment ago.
- `pick`: what the gripper's reports mean, and the steps of a pick.
- `sender`: publishes from a thread of its own.

With ROS:

- `pioneer`: the class `Pioneer`, which ``nodes/rosPioneer2.py`` and programs of users use.
- `reports`: what the robot tells.
- `commander`: what the robot is told.

The tutorial "Controlling Pioneers using p2os (Python)" on the ROS wiki is by Gautham Das; docs/tutorial.md tells what
was changed.
"""
