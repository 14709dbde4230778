"""Draw recorded runs on a page as wide as A4, for `pioneer_control.bags.draw`.

================  =================================================================================
``page``          the report of one run, on one page
``side_by_side``  several runs compared on one page
``from_above``    where the robot went, heard echoes and gripped cans
``over_time``     what changed over time, on one axis
``incidents``     collects equal errors and warnings, and gives each a letter
``timeline``      writes times
``sheet``         the paper: sizes, places and texts
================  =================================================================================
"""
