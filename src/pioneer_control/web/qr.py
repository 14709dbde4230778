"""An address as a QR code: for the page, and for a terminal."""

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


def qr_lines(rows: List[str], border: int = 2) -> List[str]:
    """Return a QR code as lines for a terminal whose background is dark: two rows in each line."""
    if not rows:
        return []
    light = "0" * (len(rows[0]) + 2 * border)
    framed = [light] * border + ["0" * border + row + "0" * border for row in rows] + [light] * (border + len(rows) % 2)
    blocks = {"00": "\u2588", "01": "\u2580", "10": "\u2584", "11": " "}
    return ["".join(blocks[above + below] for above, below in zip(*pair))
            for pair in zip(framed[::2], framed[1::2])]
