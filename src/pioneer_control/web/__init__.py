"""The page in a browser: robots live, driven by hand.

=================  ====================================================================================
``seats``          who may tell which robot what
``backend``        what lies between the page and robots of any kind
``guard``          who may talk to the server, and which files it has
``fleet``          what each viewer gets, and when
``orders``         the messages of the page, checked
``frames``         what changes ten times a second of a robot, as bytes
``columns``        the same of a whole recording
``trail``          the way that a robot went lately
``from_messages``  the messages of a robot's topics, as the page shows them
``recorded``       a bag as a recording for the page
``program_line``   the robot's side of the line to a program that shares its robot with persons
=================  ====================================================================================

``docs/page-protocol.md`` says what page and server say to each other.
"""
