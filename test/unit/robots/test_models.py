"""The table of models: every robot has the values of its row, a user's file overrides them, and wrong files are
refused.
"""

import math

import pytest

from pioneer_control.errors import UnknownModelError, UsageError
from pioneer_control.robots import LaserPlace, find_model, load_table

# A sample of the vendor's parameter files, by hand: one row of each family.
# subtype, family, front, rear, width (m), top speed (m/s), top rate (deg/s), units per turn, dist, vel, range, diff,
# transducers, bumpers
ROWS = [
    ("p3dx-sh", "ARCOS", 0.210, 0.301, 0.425, 2.2, 500, 4096, 1.0, 1.0, 1.0, 0.0056, 16, (0, 0)),
    ("p3at-sh", "ARCOS", 0.313, 0.313, 0.505, 1.2, 300, 4096, 1.0, 1.0, 1.0, 0.0034, 16, (0, 0)),
    ("p3dx", "AROS", 0.210, 0.301, 0.425, 2.2, 500, 4096, 0.485, 1.0, 1.0, 0.0056, 16, (0, 0)),
    ("p2at", "P2OS", 0.313, 0.313, 0.505, 1.2, 300, 4096, 1.32, 1.0, 0.268, 0.0034, 16, (0, 0)),
    ("p2at8+", "AROS", 0.313, 0.313, 0.505, 1.2, 300, 4096, 0.465, 1.0, 1.0, 0.0034, 16, (0, 0)),
    ("p2it", "P2OS", 0.313, 0.313, 0.505, 1.2, 300, 4096, 1.136, 1.0, 0.268, 0.0032, 16, (0, 0)),
    ("p2pp", "P2OS", 0.2565, 0.2565, 0.425, 2.2, 500, 4096, 0.485, 1.0, 0.268, 0.006, 24, (5, 5)),
    ("peoplebot-sh", "ARCOS", 0.2565, 0.2565, 0.425, 2.2, 500, 4096, 1.0, 1.0, 1.0, 0.006, 32, (5, 5)),
    ("amigo-sh", "AmigoSH", 0.160, 0.170, 0.279, 1.0, 300, 4096, 1.0, 1.0, 1.0, 0.011, 8, (0, 0)),
    ("amigo", "AmigOS", 0.160, 0.170, 0.279, 1.0, 300, 4096, 0.5083, 0.6154, 1.0, 0.011, 8, (0, 0)),
    ("mt400", "ARCOS", 0.255, 0.255, 0.425, 2.2, 500, 4096, 1.0, 1.0, 1.0, 0.0056, 16, (6, 6)),
    ("powerbot", "AROS", 0.369, 0.542, 0.680, 2.0, 360, 4096, 0.5813, 1.0, 1.0, 0.00373, 28, (7, 5)),
    ("pion1m", "PSOS", 0.250, 0.250, 0.400, 0.4, 100, 1024, 0.05066, 2.5332, 0.1734, 0.00333333, 7, (0, 0)),
    ("pionat", "PSOS", 0.250, 0.250, 0.400, 0.5, 100, 1024, 0.07, 2.5332, 0.1734, 0.00333333, 7, (0, 0)),
    ("pioneer-lx", "MARCOS", 0.348, 0.348, 0.500, 2.5, 180, 4096, 1.0, 1.0, 1.0, 0.0056, 4, (3, 3)),
    ("seekurjr", "uARCS", 0.600, 0.600, 0.830, 1.2, 80, 4096, 1.0, 1.0, 1.0, 0.0056, 0, (4, 4)),
]


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_a_model_has_the_values_of_its_row(row):
    subtype, family, front, rear, width, linear, angular_deg, turn, dist, vel, ranges, diff, transducers, bumpers = row
    model = find_model(subtype)
    assert (model.subtype, model.firmware_family, model.angle_units_per_rev) == (subtype, family, turn)
    lengths_and_speed = model.length_front, model.length_rear, model.width, model.max_linear
    assert lengths_and_speed == pytest.approx((front, rear, width, linear))
    assert math.degrees(model.max_angular) == pytest.approx(angular_deg)
    assert (model.dist_mm_per_unit, model.vel_mm_s_per_unit) == (dist, vel)
    assert (model.range_mm_per_unit, model.diff_rad_per_mm) == (ranges, diff)
    assert len(model.sonar) == transducers
    assert (model.front_bumpers, model.rear_bumpers) == bumpers


def test_every_robot_loads_and_mappr_is_left_out_with_a_reason():
    assert len(load_table().models) == 49
    with pytest.raises(UnknownModelError, match="'mappr' is not supported: .*limits"):
        find_model("mappr")


def test_every_model_is_physically_plausible():
    for model in load_table().models.values():
        assert 0.2 < model.width < 1.5 and 0.1 < model.length_front < 1.0 and 0.1 < model.length_rear < 1.0
        assert model.angle_rad_per_unit == 2 * math.pi / model.angle_units_per_rev
        assert 0.15 < 2 / model.diff_rad_per_mm / 1000 < 0.7, "effective track of %s" % model.subtype
        for transducer in model.sonar:
            assert abs(transducer.x) < 0.6 and abs(transducer.y) < 0.6 and abs(transducer.heading) <= math.pi
        assert [transducer.number
                for transducer in model.sonar] == sorted({transducer.number for transducer in model.sonar})


def test_transducers_of_the_p3dx_sh():
    model = find_model("p3dx-sh")
    assert model.sonar_count == 16
    assert model.sonar[1][:3] == (1, 0.114, 0.119) and math.degrees(model.sonar[1].heading) == pytest.approx(50)
    assert model.sonar[15][:3] == (15, -0.157, 0.136) and math.degrees(model.sonar[15].heading) == pytest.approx(90)


def test_numbers_without_a_transducer_are_gaps():
    numbers = [transducer.number for transducer in find_model("powerbot").sonar]
    assert not {7, 15, 23} & set(numbers) and max(numbers) == 30 and find_model("powerbot").sonar_count == 31


@pytest.mark.parametrize("announced, subtype", [
    ("P3DX-SH", "p3dx-sh"),
    ("researchpb", "researchPB"),
    ("lynx", "pioneer-lx"),
    ("amigo-sh-tim5xx", "amigo-sh-tim3xx"),
])
def test_a_subtype_is_found_in_any_case_and_by_alias(announced, subtype):
    assert find_model(announced).subtype == subtype


def test_an_unknown_subtype_is_refused_and_near_ones_named():
    with pytest.raises(UnknownModelError, match=r"'p3dx_sh' \(near: p3dx-sh.*'model'"):
        find_model("p3dx_sh")
    with pytest.raises(UnknownModelError, match=r"'qqq' \(known: amigo, "):
        find_model("qqq")


def test_an_absent_array_takes_its_transducers_away():
    p3dx, amigo, peoplebot = (find_model(name) for name in ("p3dx-sh", "amigo-sh", "peoplebot-sh"))
    assert [t.number for t in p3dx.with_arrays(front=True, rear=False).sonar] == list(range(8))
    assert [t.number for t in p3dx.with_arrays(front=False, rear=True).sonar] == list(range(8, 16))
    assert p3dx.with_arrays(True, True) == p3dx and p3dx.with_arrays(False, False).sonar_count == 0
    assert len(amigo.with_arrays(front=True, rear=False).sonar) == 8, "one array, though two of it look back"
    assert [t.number // 8 for t in peoplebot.with_arrays(True, False).sonar] == [0] * 8 + [2] * 8


def area(polygon):
    return sum(x1 * y2 - x2 * y1 for (x1, y1), (x2, y2) in zip(polygon, polygon[1:] + polygon[:1])) / 2


def test_outlines_run_counter_clockwise_and_include_the_paddles():
    model = find_model("p3dx-sh")
    assert area(model.outline()) == pytest.approx(0.511 * 0.425)
    assert area(model.outline(gripper=True)) == pytest.approx(0.511 * 0.425 + 0.14 * 0.25)
    assert max(x for x, _ in model.outline(gripper=True)) == pytest.approx(0.35)


def test_the_gripper_is_in_metres_and_seconds():
    gripper = find_model("p3dx-sh").gripper
    values = gripper.opening, gripper.close_time, gripper.lift_height, gripper.lift_speed
    assert values == pytest.approx((0.21, 2.5, 0.07, 0.02))


@pytest.mark.parametrize("family, first", [("ARCOS", True), ("AROS", True), ("P2OS", False), ("PSOS", False)])
def test_the_order_of_the_gripper_byte_follows_the_firmware(family, first):
    models = load_table().models.values()
    assert {model.grip_state_first for model in models if model.firmware_family == family} == {first}


@pytest.fixture
def user_file(tmp_path):
    def write(text):
        path = tmp_path / "mine.yaml"
        path.write_text(text)
        return str(path)

    return write


def test_a_users_file_overrides_any_value(user_file):
    path = user_file("models:\n  p3dx-sh: {dist_mm_per_unit: 0.997, sonar: [[100, 0, 0], null, [0, 90, 90]]}\n"
                     "gripper: {}\n")
    model = find_model("p3dx-sh", path)
    assert model.dist_mm_per_unit == 0.997 and model.diff_rad_per_mm == 0.0056
    assert [transducer.number for transducer in model.sonar] == [0, 2]
    assert find_model("p3dx-sh-lms1xx", path).dist_mm_per_unit == 0.997, "models like it follow"
    assert find_model("p3dx-sh").dist_mm_per_unit == 1


def test_our_models_are_read_once_and_a_users_file_each_time(user_file):
    assert find_model("p3dx-sh") is find_model("p3dx-sh")
    for number in (0.9, 0.8):
        path = user_file("models:\n  p3dx-sh: {dist_mm_per_unit: %s}\n" % number)
        assert find_model("p3dx-sh", path).dist_mm_per_unit == number


def test_the_wheel_radius_is_known_for_some_and_may_be_left_out(user_file):
    assert (find_model("p3dx").wheel_radius, find_model("p3at-sh").wheel_radius,
            find_model("amigo-sh").wheel_radius) == (0.0975, 0.1075, None)
    assert find_model("amigo-sh", user_file("models: {amigo-sh: {wheel_radius_mm: 50}}")).wheel_radius == 0.05
    with pytest.raises(UsageError, match="wheel_radius_mm is -1"):
        load_table(user_file("models: {amigo-sh: {wheel_radius_mm: -1}}"))


def test_a_users_file_adds_models_and_gripper_measures(user_file):
    table = load_table(user_file("models: {mine: {like: p3at-sh, width_mm: 600}}\n"
                                 "aliases: {p9: mine}\ngripper: {opening_mm: 180}\n"))
    assert table.find("P9").width == 0.6 and table.find("p9").gripper.opening == 0.18


@pytest.mark.parametrize(
    "text, message",
    [
        ("models: {p3dx-sh: {lenght_front_mm: 1}}",
         "model p3dx-sh: unknown key 'lenght_front_mm', did you mean 'length_front_mm'"),
        ("models: {p3dx-sh: {width_mm: wide}}", "width_mm is 'wide', but must be a number"),
        ("models: {p3dx-sh: {width_mm: true}}", "width_mm is True"),
        ("models: {p3dx-sh: {width_mm: .nan}}", "width_mm is nan"),
        ("models: {p3dx-sh: {width_mm: 1.0e+308}}", "width_mm is 1e.308, but must be a number from 1 to 10000"),
        ("models: {p3dx-sh: {dist_mm_per_unit: -1}}",
         "dist_mm_per_unit is -1, but must be a number from 0.0001 to 100"),
        ("models: {p3dx-sh: {angle_units_per_turn: 10.5}}", "must be a whole number"),
        ("models: {p3dx-sh: {firmware_family: DOS}}", "firmware_family is 'DOS', but must be one of PSOS"),
        ("models: {p3dx-sh: {sonar: circle}}", "unknown sonar layout 'circle'"),
        ("models: {p3dx-sh: {sonar: [[1, 2]]}}", "sonar 0 must be"),
        ("models: {mine: {width_mm: 300}}", "mine lacks firmware_family"),
        ("models: {mine: {like: yours}}", "like 'yours', which is not in the table"),
        ("models: {mine: {like: [p3dx]}}", r"like \['p3dx'\], which is not in the table"),
        ("models: {mine: {like: p3dx, sonar: }}", r"model mine lacks sonar: the name of a layout, a list of poses, or"),
        ("models: {p3dx-sh: {sonar: [[1, 2, 1.0e+30]]}}", "sonar 0 is 1e.30, but must be a number from -10000 to 1000"),
        ("models: {p3dx-sh: {1: 2}}", "model p3dx-sh: unknown key 1"),
        ("models: {1: {like: p3dx}}", "models: a name must be a text, not 1: write it in quotes"),
        ("aliases: {null: p3dx}", "aliases: a name must be a text, not None"),
        ("aliases: {mine: [p3dx]}", r"alias mine names the model \['p3dx'\], which is not in the table"),
        ("models: {mine: {like: other}, other: {like: mine}}", "circle"),
        ("models: [p3dx-sh]", "section models must be a mapping"),
        ("models: {p3dx-sh: 3}", "model p3dx-sh must be a mapping"),
        ("robots: {}", "unknown section 'robots' .legal: gripper"),
        ("aliases: {a: b}", "alias a names the model 'b'"),
        ("gripper: {close_time_s: 0}", "gripper: close_time_s is 0, but must be a number from 0.01 to 100"),
        ("gripper: {opening: 1}", "gripper: unknown key 'opening', did you mean 'opening_mm'"),
        ("- 1", "must be a mapping with the sections"),
        ("models: {", "is not valid YAML"),
    ],
)
def test_a_users_file_that_makes_no_sense_is_refused_by_name(user_file, text, message):
    with pytest.raises(UsageError, match=message) as refused:
        load_table(user_file(text))
    assert "mine.yaml" in str(refused.value)


def test_a_users_file_that_is_not_there_is_named():
    with pytest.raises(UsageError, match="models file /nowhere/robots.yaml cannot be read: No such file"):
        load_table("/nowhere/robots.yaml")


@pytest.mark.parametrize("subtype, place", [
    ("p3dx-sh", LaserPlace(0.021, 0.0)), ("p3at", LaserPlace(0.16, 0.0)), ("p2at8", LaserPlace(0.16, 0.007)),
    ("p2pp", LaserPlace(0.016, 0.001)), ("p3at-sh-lms1xx", LaserPlace(0.197, 0.0)),
    ("researchPB-lms500", LaserPlace(0.037, 0.0, None, True)), ("powerbot", LaserPlace(0.251, 0.0, None, True)),
    ("pioneer-lx-ld", LaserPlace(0.267, 0.0, 0.19, True)), ("seekur", LaserPlace(0.69, 0.0)),
    ("amigo-sh", None), ("p3atiw", None), ("pion1m", None),
])
def test_where_the_laser_of_a_model_sits(subtype, place):
    assert find_model(subtype).laser == (place and pytest.approx(place))


def test_a_laser_sits_on_its_robot():
    for model in load_table().models.values():
        if model.laser is not None:
            assert -model.length_rear < model.laser.x < model.length_front and abs(model.laser.y) < model.width / 2


def test_a_users_file_moves_a_laser_or_takes_it_away(user_file):
    path = user_file("models: {p3dx-sh: {laser: {x_mm: -50, y_mm: 5, z_mm: 310, upside_down: true}},"
                     " p3at: {laser: none}}")
    assert find_model("p3dx-sh", path).laser == LaserPlace(-0.05, 0.005, 0.31, True)
    assert find_model("p3at", path).laser is None


@pytest.mark.parametrize("laser, message", [
    ("sick", "laser is 'sick', but must be none, or a mapping with x_mm, y_mm, z_mm, upside_down"),
    ("{x_mm: 1, upside_down: false}", "laser lacks y_mm"),
    ("{x_mm: 1, y_mm: 2, upside_down: 1}", "upside_down is 1, but must be true or false"),
    ("{x_mm: 3000, y_mm: 2, upside_down: false}", "x_mm is 3000"),
    ("{x_mm: 1, y_mm: 2, z_mm: -1, upside_down: false}", "z_mm is -1"),
    ("{x_mm: 1, y_mm: 2, upside_dwn: false}", "did you mean 'upside_down'"),
])
def test_a_laser_that_makes_no_sense(user_file, laser, message):
    with pytest.raises(UsageError, match=message):
        find_model("p3dx-sh", user_file("models: {p3dx-sh: {laser: %s}}" % laser))


def test_a_model_without_a_shape_is_drawn_as_a_box(user_file):
    path = user_file("models: {mine: {sonar: none, firmware_family: ARCOS, length_front_mm: 200, length_rear_mm: 200,"
                     " width_mm: 400,"
                     " max_linear_mm_s: 1000, max_angular_deg_s: 100, angle_units_per_turn: 4096, dist_mm_per_unit: 1,"
                     " vel_mm_s_per_unit: 1, range_mm_per_unit: 1, diff_rad_per_mm: 0.005, vel2_mm_s_per_unit: 20,"
                     " front_bumpers: 0, rear_bumpers: 0, battery_v: 12, can_carry_gripper: false},"
                     " other: {like: mine, shape: amigobot}}")
    assert find_model("mine", path).shape.height == 0.25
    assert find_model("other", path).shape == find_model("amigo").shape
    assert find_model("mine", path).shape not in [model.shape for model in load_table().models.values()]


@pytest.mark.parametrize("text, message", [
    ("models: {p3dx-sh: {shape: round}}", r"unknown shape 'round' \(known: box, pioneer_dx, "),
    ("models: {p3dx-sh: {shape: [1]}}", r"unknown shape \[1\]"),
    ("shapes: {pioneer_dx: 3}", "shape pioneer_dx must be a mapping, not 3"),
    ("shapes: {pioneer_dx: {height_mm: 3}}", "shape pioneer_dx lacks clearance_mm"),
])
def test_a_shape_that_makes_no_sense(user_file, text, message):
    with pytest.raises(UsageError, match=message):
        load_table(user_file(text))


def test_the_factors_of_a_calibration(user_file):
    plain = find_model("p3dx-sh")
    assert (plain.turn_factor, plain.curve_rad_per_m, plain.gyro_factor) == (1.0, 0.0, 1.0)
    file = user_file("models: {p3dx-sh: {turn_factor: 1.02, curve_deg_per_m: -1.5, gyro_factor: 0.97}}")
    found = find_model("p3dx-sh", file)
    assert (found.turn_factor, found.curve_rad_per_m, found.gyro_factor) == (1.02, math.radians(-1.5), 0.97)


@pytest.mark.parametrize("line, reason", [
    ("turn_factor: 0", "turn_factor is 0, but must be a number from 0.5 to 2"),
    ("turn_factor: .nan", "turn_factor is nan"), ("curve_deg_per_m: 90", "curve_deg_per_m is 90"),
    ("gyro_factor: -1", "gyro_factor is -1")])
def test_factors_that_no_robot_has(user_file, line, reason):
    with pytest.raises(UsageError, match=reason):
        load_table(user_file("models: {p3dx-sh: {%s}}" % line))
