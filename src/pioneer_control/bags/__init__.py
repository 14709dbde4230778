"""Runs kept and looked at: what ``rosbag record`` wrote, read back and drawn.

============  =====================================================================================
``reader``    the messages of a bag in bounded memory, front to back, whole or damaged; the format is in ``records``
``run``       what one robot did: a :class:`~pioneer_control.bags.run.Run` of numpy arrays, read from a bag
``gather``    how: it takes the messages one by one and keeps what is worth keeping
``draw``      a ``Run`` becomes one page, several are compared on one: ``python3 -m pioneer_control.bags.draw RUN.bag``.
              The pages are ``page`` and ``side_by_side``; on them ``from_above``, ``strips``, ``incidents``; figures: ``compare``
``wire``      every byte of a robot's line as text: ``python3 -m pioneer_control.bags.wire RUN.bag``
``convert``   bags of p2os, with its messages' new names and standard ones beside them (``nodes/convert_bag``); ``writer`` writes them
``recorder``  a program begins when its recorder listens (``nodes/when_recording``)
============  =====================================================================================

Recording is ``nodes/record``: ``recording_topics`` says what and why, ``recording_start`` checks and becomes ``rosbag record``, and ``recording_attendant``
stands beside it: it publishes a ``recording_description`` and watches the disk (``recording_disk``).

Bringing back is ``nodes/replay``: ``replay`` puts commands aside and looks, ``rerun`` lets a program hear the bag (``rerun_compare``: does it command the
same again?), ``redrive`` tells another robot what the recorded one was told (``redrive_schedule``: when); both use ``replay_stage``.

Recording and playing back are ``launch/record.launch`` and ``launch/replay.launch``; docs/record-and-replay.md has the one-liners.
"""
