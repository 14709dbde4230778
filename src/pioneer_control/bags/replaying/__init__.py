"""Bringing a run back: ``nodes/replay`` and ``launch/replay.launch``. None of the ways moves what was there before.

====================  =======================================================================================
``replay``            the command, and its first way: to look, with all commands put aside
``rerun``             a program hears the bag again ...
``rerun_compare``     ... and does it command the same?
``redrive``           a simulated robot is told what the recorded one was told ...
``redrive_schedule``  ... and when
``commands``          what a robot of the bag was told and by which nodes, and how rosbag plays it all aside
``programs``          programs that they start and end, what the master knows, and the new bag that they write
====================  =======================================================================================
"""
