"""Replay a recorded run: ``nodes/replay`` and ``launch/replay.launch``. No replay moves a robot that was there before.

====================  ==============================================================================================
``replay``            the command, and its way ``look``: play the bag, but put all commands under ``recorded/``
``rerun``             the way ``rerun``: play the bag to a program, and record the commands of the program
``rerun_compare``     compares the commands of that program with the recorded commands
``redrive``           the way ``redrive``: send the recorded commands to a simulated robot, and compare the paths
``redrive_schedule``  when the re-drive sends which command
``commands``          reads the commands in a bag, and makes the command line of ``rosbag play``
``programs``          what a re-run and a re-drive share: programs that they start, the ROS master, the new bag
====================  ==============================================================================================
"""
