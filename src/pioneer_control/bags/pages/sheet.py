"""A sheet of paper to draw on, as wide as A4. Places are given in inches from its upper left corner."""

import textwrap
from typing import Any, List, Tuple

from ...pictures import INK

WIDTH, HEIGHT = 8.27, 11.69  # inches: A4
# inches: the left and the right end of the drawing, and the free space above and below
LEFT, RIGHT, TOP, BOTTOM = 0.55, 7.92, 0.35, 0.42
BODY, SMALL = 8.5, 7.5  # points
MORE = "…"
FILLED = 0.94  # share of a line that is filled with letters of average width: some lines have wider ones


class Sheet:
    """A sheet to draw on.

    Args:
        height: the height of the sheet (inches).

    Attributes:
        height: the argument.
        figure: the matplotlib Figure.
    """

    def __init__(self, height: float) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # imported here: it takes a second to load
        from matplotlib.figure import Figure

        self.height = height
        self.figure = Figure(figsize=(WIDTH, height), facecolor="white")
        FigureCanvasAgg(self.figure)

    def axes(self, left: float, top: float, width: float, height: float) -> Any:
        """Add axes. `left` and `top` are the place of their upper left corner. All arguments are in inches."""
        return self.figure.add_axes((left / WIDTH, 1.0 - (top + height) / self.height, width / WIDTH,
                                     height / self.height))

    def at(self, left: float, top: float) -> Tuple[float, float]:
        """Convert a place (inches) to the coordinates of the Figure.

        These are shares of its width and height, from the lower left corner.
        """
        return left / WIDTH, 1.0 - top / self.height

    def text(self, left: float, middle: float, words: str, room: float = WIDTH, size: float = BODY, **look: Any) -> Any:
        """Write one line of text. A text that is too long is cut off, and ends in dots.

        Args:
            left: the place of its left end (inches).
            middle: the height of its middle (inches from above).
            words: the text.
            room: the largest width (inches).
            size: the size of the letters (points).
            look: more properties of a matplotlib Text.

        Returns:
            The matplotlib Text.
        """
        words = plain(words)
        text = self.figure.text(*self.at(left, middle), words,
                                **{**dict(color=INK, va="center", fontsize=size), **look})
        while len(words) > 1 and self.wide(text) > room:
            words = words[:min(len(words) - 1, int(len(words) * room / self.wide(text)))]
            text.set_text(words.rstrip(" \\") + MORE)
        return text

    def wide(self, text: Any) -> float:
        """Return the width of a matplotlib Text (inches)."""
        return text.get_window_extent(self.figure.canvas.get_renderer()).width / self.figure.dpi

    def lines(self, words: str, room: float, most: int, size: float = BODY, **look: Any) -> List[str]:
        """Break a text into lines.

        Args:
            words: the text.
            room: the largest width of a line (inches).
            most: the largest number of lines. If the text has more, the last line ends in dots.
            size: the size of the letters (points).
            look: more properties of a matplotlib Text.
        """
        probe = self.figure.text(0, 0, plain(words) or MORE, fontsize=size, **look)
        letters = len(words) * room / self.wide(probe)      # on a line, with letters of average width
        probe.remove()
        return textwrap.wrap(words, int(FILLED * letters) + 1, max_lines=most, placeholder=MORE, break_on_hyphens=False)


def plain(words: str) -> str:
    """Convert a text of a bag or a user, so that matplotlib writes it on one line and takes no dollar for a formula."""
    return "".join(sign if sign.isprintable() else " " for sign in words).replace("$", r"\$")
