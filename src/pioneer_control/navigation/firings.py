"""When each sonar fired: a packet does not say it, but the order of its readings does.

An array fires one transducer every 40 ms, in the order of its sequence, and all arrays fire at once (manual of ARCOS;
fact of `SonarNumbers` in the simulator). A packet has the readings since the packet before it, oldest first.
"""

import collections
import math
from typing import Dict, Iterable, Tuple

from ..message_values import NO_ECHO
from ..robots import ARRAY_SIZE
from .values import Firing

CYCLE = 0.04
"""Time (s) between two firings of an array, at power-on."""


def timed(heard: Iterable[Tuple[int, float]], packet_time: float) -> Tuple[Firing, ...]:
    """Return the firings of one packet, each with its time.

    The last firing of each array lies half a cycle before the packet on average; each one before it, a cycle earlier.

    Args:
        heard: number of the transducer and range (m), in the order of the packet. `NO_ECHO` and more mean no echo.
        packet_time: time (s) at which the robot sent the packet.
    """
    readings = list(heard)
    later: Dict[int, int] = collections.Counter(number // ARRAY_SIZE for number, _ in readings)
    firings = []
    for number, heard_range in readings:
        later[number // ARRAY_SIZE] -= 1
        time = packet_time - (later[number // ARRAY_SIZE] + 0.5) * CYCLE
        firings.append(Firing(number, heard_range if heard_range < NO_ECHO else math.inf, time))
    return tuple(firings)
