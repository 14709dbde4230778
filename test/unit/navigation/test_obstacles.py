"""The memory of echoes: what the map explains, what it does not, and what is forgotten when."""

import math

import numpy as np
import pytest
from floor_for_tests import chassis_of, room

from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.obstacles import Obstacles, cells_near, edge_cells
from pioneer_control.navigation.planning import DrivableFloor
from pioneer_control.navigation.tuned import ObstacleNumbers, PlanningNumbers
from pioneer_control.navigation.values import Firing, Scan, Sensing

HERE = Pose(2.0, 2.0, 0.0)
AHEAD = 3       # a transducer of a p3dx, at (0.166, 0.027), that looks 10 degrees to the left


def memory(grid_map=None, makes_map=False, **numbers):
    grid_map, chassis = grid_map or room(), chassis_of()
    clearance = DrivableFloor(grid_map, chassis.half_width, PlanningNumbers()).clearance
    return Obstacles(chassis, grid_map, clearance, ObstacleNumbers(**numbers), makes_map)


def hear(obstacles, distance, time, number=AHEAD, odometry=HERE, where=HERE):
    obstacles.hear(Sensing(time, odometry, (Firing(number, distance, time),)), where)
    return obstacles.heard()


def test_an_echo_that_no_wall_explains_lies_on_an_arc_across_the_cone():
    places = hear(memory(), 1.0, 1.0)
    assert len(places.x) == 5 and not places.mapped.any()
    eye = 2.0 + 0.166, 2.0 + 0.027
    assert np.hypot(places.x - eye[0], places.y - eye[1]) == pytest.approx(np.ones(5))
    bearings = np.degrees(np.arctan2(places.y - eye[1], places.x - eye[0]))
    assert bearings.min() == pytest.approx(10 - 11.25) and bearings.max() == pytest.approx(10 + 11.25)


def test_an_echo_of_a_wall_is_explained():
    places = hear(memory(), 1.85, 1.0, number=0)     # to the left, where the wall is at y = 3.975
    assert len(places.x) and places.mapped.all()


ASLANT = 1      # a transducer of a p3dx that looks 50 degrees to the left
BESIDE = Pose(2.0, 3.0, 0.0)        # the wall's face is at y = 3.95


@pytest.mark.parametrize("depth, count", [(0.03, 1), (0.1, 2), (1.0, 3)])
def test_the_echo_of_a_wall_comes_from_where_the_arc_is_nearest_to_it(depth, count):
    places = hear(memory(explained_depth=depth), 0.95, 1.0, number=ASLANT, odometry=BESIDE, where=BESIDE)
    assert len(places.x) == count and places.mapped.all()
    nearest = places.y.argmax()
    assert 3.95 - places.y[nearest] == pytest.approx(0.0, abs=0.03) and places.x[nearest] == places.x.min()
    assert (3.95 - places.y).max() < depth + 0.03


def test_a_robot_that_makes_its_map_keeps_all_that_its_map_explains():
    """Its map is wrong by some centimetres."""
    places = hear(memory(makes_map=True), 0.95, 1.0, number=ASLANT, odometry=BESIDE, where=BESIDE)
    assert len(places.x) == 3 and places.mapped.all()


def test_what_stands_right_before_a_wall_is_kept_where_it_is():
    places = hear(memory(), 0.7, 1.0, number=0, odometry=BESIDE, where=BESIDE)
    assert len(places.x) == 5 and places.mapped.all()
    assert places.y == pytest.approx(np.full(5, 3.0 + 0.115 + 0.7), abs=0.03), "0.14 m before the wall"


def test_an_echo_is_explained_at_its_pose_on_the_map_and_kept_in_the_frame_of_odometry():
    places = hear(memory(), 1.85, 1.0, number=0, odometry=Pose(-7.0, 1.0, math.pi / 2))
    assert places.mapped.all()
    assert places.x == pytest.approx(np.full(len(places.x), -7.0 - 0.136 - 1.85), abs=0.06)
    assert not hear(memory(), 1.0, 1.0, odometry=Pose(-7.0, 1.0, 0.0)).mapped.any()


def test_when_unsure_the_map_explains_nothing():
    assert not hear(memory(), 1.85, 1.0, number=0, where=None).mapped.any()


@pytest.mark.parametrize("distance", [math.inf, math.nan, -1.0, 0.0, 3.0])
def test_no_echo_and_far_echoes_leave_nothing(distance):
    assert len(hear(memory(), distance, 1.0).x) == 0


def test_a_transducer_that_is_not_fitted_is_ignored():
    obstacles = memory()
    assert len(hear(obstacles, 1.0, 1.0, number=77).x) == 0 and obstacles.live(0.0) == []


def test_an_obstacle_is_forgotten_after_its_time():
    obstacles = memory(kept=5.0, kept_aside=5.0)
    hear(obstacles, 1.0, 1.0)
    assert len(hear(obstacles, math.inf, 5.9).x) == 5
    assert len(hear(obstacles, math.inf, 6.1).x) == 0


def test_echoes_from_farther_away_clear_what_they_passed_and_silence_does_not():
    obstacles = memory(passes=3, kept_aside=25.0)
    hear(obstacles, 1.0, 1.0)
    for number in range(20):
        hear(obstacles, math.inf, 1.1 + 0.1 * number)
    for time in (4.0, 4.1):
        hear(obstacles, 2.4, time)
    middle = obstacles.heard().chosen(np.hypot(obstacles.heard().x - 2.0, obstacles.heard().y - 2.0) < 1.4)
    assert len(middle.x) == 5
    hear(obstacles, 2.4, 4.2)
    near = obstacles.heard().chosen(np.hypot(obstacles.heard().x - 2.0, obstacles.heard().y - 2.0) < 1.4)
    assert len(near.x) == 2, "only what is beside the middle of the cone is left"


@pytest.mark.parametrize("back, left", [(0.5, 1), (1.5, 5)])
def test_echoes_that_passed_a_place_far_away_clear_nothing(back, left):
    """A smooth wall may stand between: seed 1157 forgot what stood behind one, and went to and fro for 300 s."""
    obstacles, away = memory(passes=3, kept_aside=25.0), HERE._replace(x=HERE.x - back)
    hear(obstacles, 1.0, 1.0)
    for time in (4.0, 4.1, 4.2):
        hear(obstacles, 4.5, time, odometry=away, where=away)
    assert len(obstacles.heard().x) == left


def test_an_echo_in_the_same_place_makes_it_young_again_and_adds_none():
    obstacles = memory()
    hear(obstacles, 1.0, 1.0)
    places = hear(obstacles, 1.0, 2.0)
    assert len(places.x) == 5 and (places.time == 2.0).all()


@pytest.mark.parametrize("speed, came_up", [(0.05, True), (0.2, False)])
def test_what_comes_while_the_robot_drives_is_not_told_from_what_it_drives_to(speed, came_up):
    obstacles = memory()
    for number, distance in enumerate((2.4, 2.4, 1.0, 1.0)):
        here = HERE._replace(x=HERE.x + speed * min(number, 2))     # at last it stands: that changes nothing
        firings = Firing(0, 1.85, 1.0 + number), Firing(AHEAD, distance, 1.001 + number)
        obstacles.hear(Sensing(1.1 + number, here, firings), None)
        newest = obstacles.heard().chosen(obstacles.heard().time == 1.001 + number)
        assert distance == 2.4 or len(newest.x) and newest.came.all() and (newest.came_up == came_up).all()


@pytest.mark.parametrize("distances, came", [([2.4] + 300 * [1.0], True), ([1.0, 2.4, 1.0], False)])
def test_what_stands_in_a_place_has_come_there_or_not_once_for_all(distances, came):
    obstacles = memory()
    for number, distance in enumerate(distances):
        places = hear(obstacles, distance, 1.0 + 0.1 * number, where=None)
    newest = places.chosen(places.time == 1.0 + 0.1 * number)
    assert len(newest.x) and (newest.came == came).all()


@pytest.mark.parametrize("before, came", [([2.4], True), ([], False), ([math.inf], False), ([1.1], False)])
def test_what_is_heard_where_an_echo_from_farther_away_had_passed_has_come_there(before, came):
    """Where no echo had passed it may always have been: a robot that was carried hears all its walls for the first
    time. It stays what it was while it stands there.
    """
    obstacles = memory()
    for number, distance in enumerate(before):
        hear(obstacles, distance, 1.0 + 0.1 * number, where=None)
    for number in range(50):        # other echoes, of the wall on the left
        hear(obstacles, 1.85, 4.0 + 0.01 * number, number=0, where=None)
    for time in (5.1, 5.2, 6.9):
        places = hear(obstacles, 1.0, time, where=None)
        newest = places.chosen(places.time == time)
        assert len(newest.came) and (newest.came == came).all()


def test_a_firing_is_placed_where_the_robot_was_then():
    obstacles = memory()
    hear(obstacles, math.inf, 1.0)
    obstacles.hear(Sensing(1.1, Pose(2.1, 2.0, 0.0), (Firing(AHEAD, 1.0, 1.05),)), Pose(2.1, 2.0, 0.0))
    eye = 2.05 + 0.166, 2.027
    assert np.hypot(obstacles.heard().x - eye[0], obstacles.heard().y - eye[1]) == pytest.approx(np.ones(5))


def test_live_are_those_that_fired_lately():
    obstacles = memory()
    hear(obstacles, 1.0, 1.0, number=2)
    hear(obstacles, math.inf, 3.0, number=5)
    assert sorted(obstacles.live(0.5)) == [2, 5] and obstacles.live(2.0) == [5] and obstacles.live(4.0) == []


def test_what_is_added_and_what_is_forgotten():
    obstacles = memory()
    obstacles.add(np.array([1.0]), np.array([2.0]), 3.0)
    places = obstacles.heard()
    assert places.x.tolist() == [1.0] and not (places.mapped[0] or places.came[0] or places.came_up[0])
    obstacles.forget()
    assert len(obstacles.heard().x) == 0


def test_what_stalled_the_wheels_is_kept_although_sonar_hears_through_it():
    obstacles = memory(felt=60.0)
    obstacles.add(np.array([2.6]), np.array([2.1]), 1.0)
    for k in range(50):
        places = hear(obstacles, 1.85, 1.1 + 0.1 * k)
    assert 2.6 in places.x
    assert 2.6 not in hear(obstacles, 1.85, 61.1).x


def test_the_faces_of_walls_near_a_pose():
    grid_map = room()
    clearance = DrivableFloor(grid_map, 0.2, PlanningNumbers()).clearance
    edges = edge_cells(clearance)
    assert edges.sum() == 2 * 118 + 2 * 78
    for half in (0.0, 0.025):
        x, y = cells_near(grid_map, edges, Pose(1.0, 2.0, math.pi), 1.5, half)
        assert len(x) and x == pytest.approx(np.full(len(x), 1.0 - 0.025 - half)), "one wall, ahead of the turned robot"
    assert len(cells_near(grid_map, edges, Pose(-90.0, 2.0, 0.0), 1.5, 0.0)[0]) == 0


def test_a_part_of_an_arc_that_other_echoes_have_passed_is_left_out():
    obstacles = memory()
    turned = Pose(2.0, 2.0, math.radians(-10.0))
    hear(obstacles, 4.0, 1.0, odometry=turned, where=turned)
    places = hear(obstacles, 1.0, 1.1)
    assert 0 < len(places.x) < 5 and places.y.max() > 2.3 and places.y.min() > 2.05


def test_the_sides_of_an_arc_are_forgotten_before_its_middle():
    obstacles = memory()
    hear(obstacles, 1.0, 1.0)
    assert len(hear(obstacles, math.inf, 8.0).x) == 1


@pytest.mark.parametrize("distance, speed, kept", [(0.5, 0.0, 60.0), (0.5, 0.2, 25.0), (1.2, 0.0, 25.0)])
def test_what_is_beside_a_robot_that_stands_is_kept_longer(distance, speed, kept):
    """5308: an AmigoBot gave way for half a minute, forgot the box beside its back, and backed into it."""
    obstacles, left = memory(), {}
    hear(obstacles, distance, 1.0)
    for number in range(1, 71):
        there = HERE._replace(x=HERE.x + speed * (number % 2), y=HERE.y)    # to and fro
        left[number] = len(hear(obstacles, math.inf, 1.0 + number, odometry=there, where=there).x)
    assert max(number for number, count in left.items() if count) == pytest.approx(kept, abs=1.0)
    assert left[4] > left[6], "the ends of the arc are forgotten as ever"


def test_what_stands_is_known_since_its_first_echo_and_what_walks_since_a_moment():
    stands, walks = memory(), memory()
    for number in range(21):
        hear(stands, 1.0 + 0.02 * (number % 2), 1.0 + 0.1 * number)
        hear(walks, 1.7 - 0.04 * number, 1.0 + 0.1 * number)

    def newest(obstacles):
        places = obstacles.heard()
        return places.since[places.time == places.time.max()]
    assert (newest(stands) == 1.0).all() and newest(walks).min() > 2.3


@pytest.mark.parametrize("distance, notices", [(0.3, 0.16), (0.5, 0.2), (1.5, 0.24)])
def test_who_stood_for_long_and_begins_to_walk_is_noticed_the_sooner_the_nearer(distance, notices):
    obstacles, time, way = memory(), 1.0, 0.0
    for _ in range(30):
        hear(obstacles, distance, time)
        time += 0.1
    places = obstacles.heard()
    while (places.since[places.time == places.time.max()] == 1.0).any():
        way, time = way + 0.02, time + 0.1
        places = hear(obstacles, distance - way, time)
    assert 0.08 < way < notices


@pytest.mark.parametrize("speed, known", [(0.35, True), (0.05, False)])
def test_a_robot_that_drives_hears_one_place_after_another_of_one_thing(speed, known):
    obstacles, way, time = memory(), 0.0, 1.0
    for _ in range(30):
        hear(obstacles, 0.3, time, number=0)
        time += 0.1
    while way < 0.27:
        way, time = way + 0.1 * speed, time + 0.1
        at = Pose(2.0 + way, 2.0, 0.0)
        places = hear(obstacles, 0.3, time, number=0, odometry=at, where=at)
    assert (places.since[places.time == places.time.max()] == 1.0).any() == known


def test_what_was_silent_for_long_must_prove_anew_that_it_stands():
    obstacles = memory()
    hear(obstacles, 1.0, 1.0)
    places = hear(obstacles, 1.0, 5.0)
    assert (places.since[places.time == 5.0] == 5.0).all()


# What a laser sees

LASER = Pose(0.02, 0.0, 0.0)


def see(obstacles, time, ends=(), where=HERE, odometry=HERE, wall=math.inf, heard=()):
    """Let a laser see: `ends` are pairs of a number of a ray (0 to 180, 90 is ahead) and a range, all else `wall`."""
    ranges = [wall] * 181
    for number, far in ends:
        ranges[number] = far
    scan = Scan(time, odometry, LASER, -math.pi / 2, math.radians(1.0), ranges)
    obstacles.hear(Sensing(time, odometry, tuple(Firing(number, far, time) for number, far in heard), scan=scan), where)
    return obstacles.heard()


LEG = [(89, 1.0), (90, 1.0), (91, 1.0)]
LEFT_LEG = [(99, 1.02), (100, 1.02), (101, 1.02)]      # in the middle of what `AHEAD` hears, 0.87 m from it


def test_where_rays_end_that_the_map_does_not_explain_something_is():
    places = see(memory(), 1.0, LEG)
    assert places.seen.all() and not places.mapped.any() and 1 <= len(places.x) <= 3
    assert np.hypot(places.x - 3.02, places.y - 2.0).max() < 0.03


def test_a_wall_that_a_laser_sees_is_left_to_the_map():
    assert not len(see(memory(), 1.0, [(180, 1.95), (179, 1.95), (178, 1.95)]).x)


def test_a_ray_alone_measures_neither_a_thing_nor_what_is_behind():
    assert not len(see(memory(), 1.0, [(90, 1.0)]).x)
    assert not len(see(memory(), 1.0, [(89, 0.8), (90, 1.0), (91, 1.2)]).x)


def test_what_is_far_away_or_the_robot_itself_is_no_obstacle():
    assert not len(see(memory(), 1.0, [(number, 2.1) for number in range(85, 95)]).x)
    assert not len(see(memory(), 1.0, [(number, 0.1) for number in range(85, 95)]).x)


def test_rays_that_pass_forget_what_a_laser_told():
    obstacles = memory()
    assert len(see(obstacles, 1.0, LEG).x)
    assert len(see(obstacles, 1.1).x), "no echo says nothing"
    assert len(see(obstacles, 1.2, wall=1.15).x), "the ray ended too near behind it"
    for time in (1.5, 1.6):
        places = see(obstacles, time, wall=3.0)
    assert not len(places.x)


def test_a_laser_does_not_forget_what_sonar_told_nor_sonar_what_a_laser_told():
    obstacles = memory()
    hear(obstacles, 1.0, 1.0)
    for step in range(1, 6):
        places = see(obstacles, 1.0 + step / 10, wall=3.0)
    assert len(places.x) and not places.seen.any()      # it is lower than the laser
    obstacles = memory()
    see(obstacles, 1.0, LEFT_LEG)
    for step in range(1, 6):
        places = hear(obstacles, 1.6, 1.0 + step / 10)
    assert places.seen.any()        # sonar is deaf to it


def test_both_keep_what_they_tell_of_one_place():
    obstacles = memory()
    places = see(obstacles, 1.0, LEFT_LEG, heard=[(AHEAD, 0.87)])
    assert int((~places.seen).sum()) == 5 and places.seen.any()
    for step in range(1, 6):
        places = see(obstacles, 1.0 + step / 10, wall=3.0)
    assert int((~places.seen).sum()) == 5 and not places.seen.any()


def test_what_a_laser_saw_while_the_robot_was_not_sure_is_forgotten_where_the_map_explains_it():
    obstacles, wall = memory(), [(180, 1.95), (179, 1.95), (178, 1.95)]
    assert len(see(obstacles, 1.0, wall + LEG, where=None).x) > 3
    assert np.hypot(*(see(obstacles, 1.1, LEG).x - 3.02, obstacles.heard().y - 2.0)).max() < 0.03


def test_what_a_laser_sees_for_long_in_one_place_stands_still():
    obstacles = memory()
    for step in range(30):
        places = see(obstacles, 1.0 + step / 10, LEG)
    assert (places.time - places.since).max() > ObstacleNumbers().proves_still


def test_a_robot_that_makes_its_map_leaves_the_laser_out():
    assert not len(see(memory(makes_map=True), 1.0, LEG).x)
