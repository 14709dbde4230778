"""Draw recorded runs on one page: a report of one run, or a comparison of several runs.

``python3 -m pioneer_control.bags.draw RUN.bag`` writes RUN.png beside the bag. ``-o`` names another file (.png, .pdf or
.svg). Colour-blind people can tell the colours (Okabe and Ito's) apart. In grey print, line widths, line styles and
hatches differ.
"""

import os
import sys
from typing import Any, Dict, List, Optional, Sequence, Tuple

from ..errors import PioneerError, UsageError
from ..pictures import check_output, write
from .command_line import Progress, in_order, parser_of, stem
from .pages import page, side_by_side
from .recorded_run import Run
from .run import read_run

DPI = 160

OPTIONS: Dict[str, Dict[str, Any]] = {
    "bag": dict(nargs="+", help="the bag; if there are several, the others are compared with the first"),
    "-o --output": dict(metavar="FILE",
                        help="the picture to write: .png, .pdf or .svg (default: beside the first bag, .png)"),
    "--parts": dict(action="store_true", help="the bags are the parts of one recording (rosbag record --split)"),
    "--robot": dict(action="append", default=[], metavar="NAME",
                    help="namespace of the robot, if a bag has several. Give it once for each bag, or several times "
                    "for one bag to compare its robots"),
    "--title": dict(help="title of the page (default: the names of the robot and the world)"),
}


def draw_run(run: Run, output: str, title: Optional[str] = None) -> None:
    """Write the report of a run to the file `output`. The ending of its name chooses the format: .png, .pdf or .svg.

    Raises UsageError if the picture cannot be written.
    """
    draw_runs([run], output, title)


def draw_runs(runs: Sequence[Run], output: str, title: Optional[str] = None) -> None:
    """Draw runs and write the picture to a file.

    Args:
        runs: one run, for a report, or several runs, for a comparison with the first run.
        output: the file. The ending of its name chooses the format: .png, .pdf or .svg.
        title: the title of the page. None: a title made from the runs.

    Raises:
        UsageError: the picture cannot be written, see `pictures.write`.
    """
    write(lambda: side_by_side.figure(runs, title) if len(runs) > 1 else page.figure(runs[0], title), output, DPI)


def read(paths: Sequence[str], robot: Optional[str]) -> Run:
    """Read a run from the files of one recording, with a progress bar.

    Args:
        paths: the bag, or the files of one split recording in their order.
        robot: namespace of the robot. None: the only robot in the bag.

    Raises:
        BagError: the bag cannot be read, or has no such robot.
    """
    with Progress(os.path.basename(paths[0])) as progress:
        return read_run(paths, robot, progress)


def wanted(bags: Sequence[str], robots: Sequence[str], parts: bool) -> List[Tuple[Sequence[str], Optional[str]]]:
    """Return which runs to draw: for each run its bags, and its robot (None: the only robot in the bag).

    Args:
        bags: the bags on the command line.
        robots: the values of --robot.
        parts: whether the bags are the parts of one recording.

    Raises:
        UsageError: the number of robots is neither 1 nor the number of bags, so the pairs are not clear.
    """
    runs = [in_order(bags)] if parts else [[bag] for bag in bags]
    names: List[Optional[str]] = list(robots) or [None]
    if len(runs) > 1 and len(names) not in (1, len(runs)):
        raise UsageError("--robot %s: give one for all bags, or one for each of the %s"
                         % (" --robot ".join(robots), len(runs)))
    return [(runs[n % len(runs)], names[n % len(names)]) for n in range(max(len(runs), len(names)))]


def main(arguments: Optional[Sequence[str]] = None, program: str = "draw_run") -> int:
    """Draw the runs that the command line names.

    Args:
        arguments: the command line. None: that of the process.
        program: the name of the command.

    Returns:
        The exit status: 0 when the picture is written, 2 after an error, 130 after Ctrl-C.
    """
    options = parser_of(program, "Draw a report of a recorded run on one page, or compare several runs. (%s --html "
                        "makes a page that plays the run in a browser: see %s --html --help.)" % (program, program),
                        OPTIONS).parse_args(arguments)
    try:
        chosen = wanted(options.bag, options.robot, options.parts)
        output = options.output or stem(options.bag[0]) + ("-compared.png" if len(chosen) > 1 else ".png")
        check_output(output)
        side_by_side.check_number(len(chosen))
        runs = [read(*each) for each in chosen]
        draw_runs(runs, output, options.title)
    except (PioneerError, OSError, ImportError) as error:
        print("%s: %s" % (program, error), file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    for run in runs:
        if run.damage:
            print("%s: %s: %s" % (program, run.path, run.damage), file=sys.stderr)
    print(output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
