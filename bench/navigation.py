#!/usr/bin/python3
"""How well a robot with nothing but sonar, or with a laser, too, navigates: simulated robots in drawn worlds, no ROS.

    python3 bench/navigation.py localise                            # known start, unknown start, carried away
    python3 bench/navigation.py localise --seeds 1000-1011 --start unknown --specular 20 --picture /tmp/lost
    python3 bench/navigation.py map --minutes 6                     # by true poses, by odometry, by its own
    python3 bench/navigation.py begin                               # time and memory to begin on a large map
    python3 bench/navigation.py drive --walkers 1                   # to goals, past people and what is on no map
    python3 bench/navigation.py drive --laser                       # the same with a laser; also localise, carried
    python3 bench/navigation.py carried                             # carried away on the way to a goal
    python3 bench/navigation.py explore --picture /tmp/explored     # where its map ends, then home

Each part has options of its own: `python3 bench/navigation.py PART --help`. The cases of the seeds are those of
`navigation_cases`.
"""

import argparse
import sys

import navigation_begin
import navigation_carried
import navigation_drive
import navigation_explore
import navigation_localise
import navigation_map

PARTS = {"begin": navigation_begin, "carried": navigation_carried, "drive": navigation_drive,
         "explore": navigation_explore, "localise": navigation_localise, "map": navigation_map}
"""Each part has `add_arguments(parser)` and `main(options)`, which returns the exit status."""


def main() -> int:
    """Run the part that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parts = parser.add_subparsers(dest="part", required=True, metavar="PART")
    for name, part in PARTS.items():
        text = part.__doc__.splitlines()[0]
        part.add_arguments(parts.add_parser(name, help=text, description=part.__doc__))
    options = parser.parse_args()
    return PARTS[options.part].main(options)


if __name__ == "__main__":
    sys.exit(main())
