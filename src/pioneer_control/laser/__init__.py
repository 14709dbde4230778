"""The computer's side of a SICK LMS2xx laser: finds it, configures it, and hears its scans. `lms2xx` is its protocol.

================  ==============================================================
``settings``      what a user asks of a laser, checked
``conversation``  what is said to a laser, and in which order
``session``       carries that out: bytes and time in, bytes and events out
================  ==============================================================
"""
