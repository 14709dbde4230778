"""Recording: ``nodes/record`` and ``launch/record.launch``.

===============  ==================================================================================
``topics``       what is kept, and why: config/record.yaml
``start``        checks what was asked for, and becomes ``rosbag record``
``attendant``    stands beside it: publishes the description, watches the disk
``description``  what a recording says of itself: versions, nodes, parameters
``disk``         for how long there is room
``recorder``     lets a program begin when its recorder listens: ``nodes/when_recording``
===============  ==================================================================================
"""
