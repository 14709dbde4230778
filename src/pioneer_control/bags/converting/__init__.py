"""Convert bags of p2os, and older bags of this package, to bags with standard messages: ``nodes/convert_bag``.

============  =================================================
``convert``   the command: reads one bag and writes another one
``messages``  converts each message; reads new echoes from arrays of sonar ranges
============  =================================================
"""
