"""Record robots in bags with ``nodes/record`` and ``launch/record.launch``.

==================  ======================================================================================
``start``           the command: checks its arguments, then replaces itself by ``rosbag record``
``plan``            decides what to record in which file, checks that nothing is overwritten
``attendant``       a node beside ``rosbag record``: publishes the description, warns of missing topics
``topics``          reads the list of the topics to record: config/record.yaml
``description``     the description in a recording: versions, nodes, parameters
``when_recording``  starts a program when its recorder has subscribed: ``nodes/when_recording``
==================  ======================================================================================
"""
