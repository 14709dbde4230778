"""The true state of the simulated world for other programs, and the orders that they give, without ROS. Open
``service`` first: the socket for these programs, with a thread of its own.

``state``   world and robots as plain values
``orders``  what other programs may order, and what each order does
``visit``   the conversation with one program: lines in, lines out

Only ``service`` uses a socket, a thread and real time.
"""

from .service import TruthService

__all__ = ["TruthService"]
