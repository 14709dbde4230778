"""Runs kept, brought back and looked at. docs/record-and-replay.md has the one-liners.

================  ====================================================================================
``records``       the format of bags
``reader``        the messages of a bag in bounded memory, front to back, whole or damaged
``writer``        writes a bag
``recorded_run``  what one robot did, as numpy arrays: a `recorded_run.Run`
``run``           reads it from a bag; ``collectors`` keep what is kept of its messages
``compare``       figures of a run, and how far two lie apart
``draw``          a run becomes one page, several are compared on one: ``nodes/draw_run``
``pages/``        these pages
``wire``          the bytes of a robot's line as text: ``python3 -m pioneer_control.bags.wire RUN.bag``
``command_line``  what commands have in common: options, names of bags, a bar of progress
``recording/``    makes bags: ``nodes/record``
``replaying/``    brings them back, to look, to programs, to a simulated robot: ``nodes/replay``
``converting/``   gives old ones this package's messages and standard ones: ``nodes/convert_bag``
================  ====================================================================================
"""
