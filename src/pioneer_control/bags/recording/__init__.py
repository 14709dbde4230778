"""Recording: ``nodes/record`` and ``launch/record.launch``.

==================  ======================================================================================
``start``           the command: checks what was asked for, and becomes ``rosbag record``
``plan``            what is recorded and where to, that nothing is overwritten, and for how long there is room
``attendant``       runs beside it: publishes the description, says what is missing
``topics``          which topics are kept, and why: config/record.yaml
``description``     what a recording says of itself: versions, nodes, parameters
``when_recording``  lets a program begin when its recorder listens: ``nodes/when_recording``
==================  ======================================================================================
"""
