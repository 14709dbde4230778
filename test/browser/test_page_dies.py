"""Whatever dies between the hand and the robot: the robot is told to stand in time, and nothing moves afterwards."""

import pytest
from ways_to_die import WAYS, DrivenPage

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
    """The measure sees velocities: while the key is held and all is well, zero never comes."""
    with DrivenPage(tmp_path) as page:
        page.drive()
        start = page.heard.all[-1][0]
        end = page.robot.simulation.time + 1.0
        while page.robot.simulation.time < end:
            assert page.zero_since(start) is None
