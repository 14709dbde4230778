"""Bringing a run back: ``nodes/replay`` and ``launch/replay.launch``. None of the ways moves what was there before.

====================  =============================================================================
``replay``            the command, and its first way: to look, with all commands put aside
``rerun``             a program hears the bag again ...
``rerun_compare``     ... and does it command the same?
``redrive``           another robot is told what the recorded one was told ...
``redrive_schedule``  ... and when
``told``              what both begin with: what a robot of the bag was told, and by whom
``stage``             what both stand on: the bag they keep, programs they start, who is there already
====================  =============================================================================
"""
