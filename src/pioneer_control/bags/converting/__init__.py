"""Bags of p2os, and older ones of this package, with standard messages: ``nodes/convert_bag``.

============  =====================================================================================
``convert``   the command: reads one bag and writes another
``messages``  what becomes of each message; arrays of sonar ranges, as what each transducer heard and when
============  =====================================================================================
"""
