"""Bringing a run back: ``nodes/replay`` and ``launch/replay.launch``. None of the ways moves what was there before.

=====================  =======================================================================================
``replay``             the command, and its first way: to look, with all commands put aside
``rerun``              a program hears the bag again ...
``rerun_compare``      ... and does it command the same?
``redrive``            a simulated robot is told what the recorded one was told ...
``redrive_schedule``   ... and when
``recorded_commands``  what a robot of the bag was told, and by which nodes
``topic_recorder``     the new bag that a re-run and a re-drive write
``programs``           programs that they start and end, and what the master knows
``playback``           how rosbag plays a bag without commanding anything
=====================  =======================================================================================
"""
