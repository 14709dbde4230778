"""The ROS node of navigation.

``navigation_node``  the node: one robot's pilot, its goals and its services
``hearing``          what the robot's driver tells; ``telling``: what navigation tells
``laser_watch``      its scans, and whether they are of use
``tf_watch``         who else says where the robot is
``goal_server``      goals, as move_base takes them
``map_files``        loads maps with their named places; ``map_saver`` saves the map that a robot makes
``place_keeper``     the named places of the map
``plan_maker``       plans without driving
``parameters``       the parameters of the node
``locate_bag``       a program: where a robot was, from a bag; ``bag_laser``: where its laser sat
``messages``         values as ROS messages, and back; ``status``: the diagnostics
"""
