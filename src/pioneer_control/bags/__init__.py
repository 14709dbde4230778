"""Runs kept, brought back and looked at. docs/record-and-replay.md has the one-liners.

===============  =====================================================================================
``records``      the format of bags
``reader``       the messages of a bag in bounded memory, front to back, whole or damaged; ``writer`` writes them
``run``          what one robot did: a :class:`~pioneer_control.bags.run.Run` of numpy arrays, read from a bag
``gather``       how: it takes the messages one by one; ``keepers`` keep of each kind what is worth keeping
``compare``      figures of a run, and how far two lie apart
``draw``         a ``Run`` becomes one page, several are compared on one: ``nodes/draw_run``; the pages are in ``pages/``
``wire``         every byte of a robot's line as text: ``python3 -m pioneer_control.bags.wire RUN.bag``
``names``        of bags, and of their parts
``progress``     how far a long bag is read, on a terminal
``recording/``   makes bags: ``nodes/record``
``replaying/``   brings them back, to look, to programs, to another robot: ``nodes/replay``
``converting/``  gives old ones this package's messages and standard ones: ``nodes/convert_bag``
===============  =====================================================================================
"""
