"""Pages of runs, A4 wide, as `pioneer_control.bags.draw` has them drawn.

================  =================================================================================
``page``          the report of one run: all of the others on one page
``side_by_side``  several runs compared on one page
``from_above``    where the robot went, what it heard and gripped
``over_time``     what changed over time, on one axis
``incidents``     errors and warnings, alike ones together, each with a letter
``timeline``      how time is written
``sheet``         the paper: sizes and places
================  =================================================================================
"""
