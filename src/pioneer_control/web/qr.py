"""An address as a QR code: for the page, and for a terminal."""

import re
import urllib.parse
from typing import List


def qr_rows(text: str) -> List[str]:
    """Return the rows of the QR code of a text, of 1 (dark) and 0. Empty where python3-qrcode is not installed."""
    try:
        import qrcode
    except ImportError:
        return []
    code = qrcode.QRCode(border=0, error_correction=qrcode.constants.ERROR_CORRECT_M)
    code.add_data(text)
    code.make(fit=True)
    return ["".join("1" if dark else "0" for dark in row) for row in code.get_matrix()]


def qr_image(rows: List[str], border: int = 4) -> str:
    """Return a QR code as an address (``data:``) of a picture that a page shows. Empty if there are no rows."""
    if not rows:
        return ""
    dark = "".join("M%d,%dh%dv1h-%dz" % (run.start(), y, len(run.group()), len(run.group()))
                   for y, row in enumerate(rows) for run in re.finditer("1+", row))
    wide = len(rows) + 2 * border
    box = "%d %d %d %d" % (-border, -border, wide, wide)
    svg = ("<svg xmlns='http://www.w3.org/2000/svg' viewBox='%s' shape-rendering='crispEdges'>"
           "<path fill='#fff' d='M%d,%dh%dv%dh-%dz'/><path d='%s'/></svg>" % (
               box, -border, -border, wide, wide, wide, dark))
    return "data:image/svg+xml," + urllib.parse.quote(svg, safe=" ,:/='")


def qr_lines(rows: List[str], border: int = 2) -> List[str]:
    """Return a QR code as lines for a terminal whose background is dark: two rows in each line."""
    if not rows:
        return []
    light = "0" * (len(rows[0]) + 2 * border)
    framed = [light] * border + ["0" * border + row + "0" * border for row in rows] + [light] * (border + len(rows) % 2)
    blocks = {"00": "\u2588", "01": "\u2580", "10": "\u2584", "11": " "}
    return ["".join(blocks[above + below] for above, below in zip(*pair))
            for pair in zip(framed[::2], framed[1::2])]
