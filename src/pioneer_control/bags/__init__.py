"""Record runs of robots in bags, read them, draw them, play them back and convert them.

docs/record-and-replay.md lists the commands.

=========================  ================================================================================
``records``                the format of bags
``reader``                 reads the messages of a whole or damaged bag, in bounded memory
``plain_messages``         message objects without ROS
``writer``                 writes a bag
``recorded_run``           the class `recorded_run.Run`: what one robot did, as numpy arrays
``run``                    reads a Run from a bag
``collectors``             keep the data of the messages that ``run`` reads
``navigation_collectors``  the same for what navigation said
``compare``                measures a track, and how far two tracks are apart
``draw``                   draws a run on one page, or compares several runs: ``nodes/draw_run``
``pages/``                 the layout of these pages
``wire``                   writes the bytes of a serial line as text: ``python3 -m pioneer_control.bags.wire RUN.bag``
``command_line``           what the commands share: options, names of bags, a progress bar
``recording/``             records bags: ``nodes/record``
``replaying/``             plays bags back to viewers, to programs or to a simulated robot: ``nodes/replay``
``converting/``            converts old bags to messages of this package and standard ones: ``nodes/convert_bag``
=========================  ================================================================================
"""
