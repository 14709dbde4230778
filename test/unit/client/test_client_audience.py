"""The listeners of a robot, and the events that wait for them: client/threads.py."""

from pioneer_control.client.events import LinkDown, StatesMissed
from pioneer_control.client.threads import MOST_WAITING, Audience
from pioneer_control.errors import PortError


def test_of_attempts_in_vain_that_wait_only_the_newest_is_told():
    told = []
    audience = Audience()
    audience.listen(None, told.append)
    downs = [LinkDown(PortError(str(number)), 0.2) for number in range(2 * MOST_WAITING)]
    for down in downs:
        audience.put([down])
    audience.put([StatesMissed(1)])
    audience.put([downs[0]])
    audience.tell()
    assert told == [downs[-1], StatesMissed(1), downs[0]], "another event in between keeps both"
