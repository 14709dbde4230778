"""The wiki tutorial's robot: it wanders without touching anything, and picks up cans.

Deciding and talking are kept apart. Pure, without ROS: `wander` (one snapshot and a memory in, one command and a memory out), its
helpers `clearance` and `echoes`, `pick` (what the gripper's reports mean), and `snapshot` (what a decision may look at).
Only `pioneer` talks ROS: the class `Pioneer` that ``nodes/rosPioneer2.py`` uses. Open `wander` first.

The tutorial "Controlling Pioneers using p2os (Python)" on the ROS wiki is by Gautham Das; docs/tutorial.md tells what was changed.
"""
