"""Where the robot is, what the map is, and how the robot gets to a goal. Open ``values`` first.

``values``           what the robot senses and is told; ``firings``: when each sonar fired; ``senses``:
                     both from the topics of a robot; ``steady_time``: a time that never goes back;
                     ``steady_odometry``: a pose by the wheels that never jumps
``pilot``            all of it for one robot: the front for the node and for benches
``node``             the ROS node, a folder; it also reads the files of maps
``tuned``            all numbers that were tuned, and what each does

Where it is:

``localisation``     the front: a packet or a scan goes in, the pose and how sure it is come out
``pose_cloud``       the cloud of poses where it may be
``pose_search``      finds poses anywhere on the map that explain the last readings
``certainty``        whether the pose may be trusted
``measurement``      how well a pose explains readings; ``expected_ranges``: what a map lets expect
``laser_field``      the same for the scans of a laser; ``laser_rays``: where its rays begin, and look
``recent_readings``  readings with the place of their sensor; ``looks``: what a turn on the spot tells anew
``wheel_calibration``  how the wheels err, learnt while it drives
``unseen_motion``    what it may have driven while nobody heard of it

How it gets to a goal:

``navigator``        the front: drives one robot to goals, stands when something is not well, and says why
``planning``         the floor that a robot may use, and the way to a goal; ``frames``: points between frames
``steering``         the next velocity
``obstacles``        what was heard lately, and is on no map
``standing_obstacles``  where something stood that is on no map, after the robot has gone on
``suspected_walls``  where a wall may go on that it does not hear, while it makes a map
``aside``            where it goes for a while when it has no way on
``lateness``         how much later than usual it reacts: it is slower then
``swept_outlines``   the floor that the robot covers until it stands
``chassis``          the robot: how far its moves go until they touch something, and where its sonar looks

A map where there is none:

``mapping``          the front: a packet goes in, the pose comes out, and the map at any moment
``sonar_grid``       echoes become cells that are free or occupied
``stretch``          a metre of path and what was heard on it; ``wheel_motion``: without the errors of the wheels
``scan_match``       finds where a stretch lies on the map
``wall_directions``  tells the heading by walls that are square to each other
``pose_graph``       moves all stretches to where they agree best
``exploring``        where to go next, until all that can be reached is known

In the words of the field: `pose_cloud` is a particle filter, `pose_search` global localisation, `certainty` has a CUSUM
test, `planning` a navigation function (Dijkstra's), `steering` a dynamic window; `sonar_grid` is an occupancy grid, a
`stretch` a submap, `pose_graph` closes loops, `wall_directions` assumes a Manhattan world where it hears one, and an
end of the map is a frontier.

Everything here is pure: maps, what the robot sensed, and time go in; poses, maps, plans and velocities come out. There
is no ROS, no clock and no thread but in the folder ``node``.

Lengths are in metres, angles in radians, counter-clockwise positive; times in seconds (REP 103). Poses are in the map
frame unless the name says ``odometry``.
"""
