"""Names of bags: what they are called without their ending, and the order of parts."""

import re
from typing import List, Sequence


def stem(path: str) -> str:
    """The name of a bag without what all bags end in, also of one that was not closed."""
    return re.sub(r"(\.bag)?(\.active)?$", "", path)


def in_order(parts: Sequence[str]) -> List[str]:
    """Parts by their numbers: FILE_2.bag before FILE_10.bag, which a shell has the other way round."""
    return sorted(parts, key=lambda path: [int(piece) if piece.isdigit() else piece for piece in re.split("([0-9]+)", path)])
