"""What all pictures of this package share: colours, the axes of a picture from above, and how to write a file.

This file does not import matplotlib, which takes a second to load: the caller passes in matplotlib objects.
"""

import io
import os
from typing import Any, Callable

from .errors import UsageError
from .whole_file import writing

FORMATS = (".png", ".pdf", ".svg")
WALL, FLOOR, BEYOND = "#3c3c3c", "#ffffff", "#e4e4e4"
INK, FAINT = "#222222", "#8a8a8a"
# Okabe and Ito's colours: colour-blind people can tell them apart. For grey print, line styles and hatches differ too.
BLUE, SKY, VERMILLION, ORANGE, GREEN, PURPLE = "#0072b2", "#56b4e9", "#d55e00", "#e69f00", "#009e73", "#cc79a7"
SCALE_BARS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)  # m


def check_output(output: str) -> None:
    """Raise UsageError when a picture cannot be written to this file. Call this before the long work of drawing."""
    if not output.endswith(FORMATS):
        raise UsageError("%s: a picture's name ends in %s" % (output, ", ".join(FORMATS)))
    folder = os.path.dirname(output) or "."
    if not os.path.isdir(folder):
        raise UsageError("cannot write %s: there is no directory %s" % (output, folder))
    if os.path.isdir(output) or not os.access(output if os.path.exists(output) else folder, os.W_OK):
        raise UsageError("cannot write %s: it is a directory, or yours to read only" % output)


def write(figure: Callable[[], Any], output: str, dpi: int) -> None:
    """Draw a matplotlib Figure and write it to a file.

    Args:
        figure: a function that draws and returns the Figure.
        output: the name of the file. Its ending, one of `FORMATS`, chooses the format.
        dpi: the resolution in dots per inch.

    Raises:
        UsageError: the ending is not one of `FORMATS`, the file cannot be written, or matplotlib is not installed.
    """
    check_output(output)
    drawn = io.BytesIO()    # the whole picture, before the first byte is written to the file
    try:
        figure().savefig(drawn, dpi=dpi, format=os.path.splitext(output)[1][1:])
    except ModuleNotFoundError as error:
        raise UsageError("pictures need matplotlib, and there is no %s: install python3-matplotlib, or with pip "
                         ".[pictures]" % error.name) from error
    try:
        with writing(output) as part, open(part, "wb") as file:
            file.write(drawn.getbuffer())
    except OSError as error:
        raise UsageError("cannot write %s: %s" % (output, error.strerror)) from error


def draw_frame(axes: Any, low_x: float, high_x: float) -> None:
    """Draw a grid and labels in metres, and a scale bar above the right end of the picture.

    Args:
        axes: the matplotlib axes to draw on.
        low_x, high_x: the limits of the x axis (m).
    """
    length = max(bar for bar in SCALE_BARS if bar <= max(SCALE_BARS[0], 0.15 * (high_x - low_x)))
    top = axes.get_xaxis_transform()
    axes.plot([high_x - length, high_x], [1.012, 1.012], color=INK, linewidth=3, solid_capstyle="butt", transform=top,
              clip_on=False)
    axes.text(high_x - length / 2, 1.02, "%g m" % length, ha="center", va="bottom", fontsize=9, color=INK,
              transform=top)
    draw_grid(axes, "both")
    axes.tick_params(colors=FAINT, labelsize=8, length=2)
    axes.set_xlabel("x (m)", color=FAINT, fontsize=8, labelpad=1)
    axes.set_ylabel("y (m)", color=FAINT, fontsize=8, labelpad=1)


def draw_grid(axes: Any, axis: str) -> None:
    """Draw faint grid lines for ``axis`` ("x", "y" or "both") behind everything else, and make the borders faint."""
    axes.grid(axis=axis, color=FAINT, linewidth=0.4, alpha=0.35)
    axes.set_axisbelow(True)
    for spine in axes.spines.values():
        spine.set_color(BEYOND)
