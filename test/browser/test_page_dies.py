"""Whatever dies between the hand and the robot: the robot is told to stand in time, and nothing moves afterwards."""

import pytest
from ways_to_die import WAYS, DrivenPage, until

IN_TIME = 0.6       # s
SLOW_MACHINE = 1.4  # s more that other tests beside this one may take


@pytest.mark.parametrize("way", WAYS)
def test_the_robot_stands_and_stays(tmp_path, way):
    with DrivenPage(tmp_path) as page:
        page.drive()
        death = page.dies(WAYS[way])
    print("%s: %.0f ms" % (way, 1000 * death.until_zero))
    assert death.until_zero < IN_TIME + SLOW_MACHINE
    assert death.moves_afterwards == 0


def test_a_page_that_lives_goes_on_driving(tmp_path):
    """The measure sees velocities: while the key is held and all is well, zero never comes. A busy machine may hold the
    page up, so that it stands: then the key is pressed again.
    """
    with DrivenPage(tmp_path) as page:
        def drives_for_a_second():
            page.drive()
            start, end = page.heard.all[-1][0], page.robot.simulation.time + 1.0
            until(lambda: page.zero_since(start) is not None or page.robot.simulation.time > end, "a second is over")
            return page.zero_since(start) is None

        until(drives_for_a_second, "it drives for a second")
