"""Where the robot is, what the map is, and how the robot gets to a goal. Open ``values`` first.

``values``   what the robot senses and is told; ``firings``: when each sonar fired; ``senses``: both
             from the topics of a robot
``map_files`` loads maps with their named places

Everything here is pure: maps, what the robot sensed, and time go in; poses, maps, plans and velocities come out. There
is no ROS, no clock and no thread but in ``node``.

Lengths are in metres, angles in radians, counter-clockwise positive; times in seconds (REP 103). Poses are in the map
frame unless the name says ``odometry``.
"""
