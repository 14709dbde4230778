"""What is heard on a stretch of the path."""

import pytest

from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.stretch import MOST_TURN, Ears, Stretch
from pioneer_control.navigation.values import Firing, Sensing
from pioneer_control.robots import find_model

SONAR = find_model("p3dx-sh").sonar


@pytest.mark.parametrize("rate, counts", [(MOST_TURN, True), (1.8, False)])
def test_what_is_heard_in_a_turn_on_the_spot_counts_unless_it_is_fast(rate, counts):
    """Who explores first turns once: its heading is lost there unless it is heard meanwhile."""
    stretch = Stretch(0.0, Ears(SONAR))
    stretch.add(Pose(0.0, 0.0, 0.0), Sensing(0.1, Pose(0.0, 0.0, 0.1 * rate), (Firing(0, 1.0, 0.1),)), 0.0, 0.0)
    assert (stretch.heard_count == 1) is counts
