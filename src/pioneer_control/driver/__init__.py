"""The ROS node ``p2os_driver``: it connects to a robot, and offers topics and services, named as in the package p2os.

=========================  ============================================================================="""
