"""docs/worlds.md is true."""

import dataclasses
import pathlib
import re

import numpy as np
import pytest
import yaml

from pioneer_control.errors import ParameterError
from pioneer_control.parameters import Switch
from pioneer_control.robots import find_model
from pioneer_control.simulator.world.aria_map import OBJECTS
from pioneer_control.simulator.world.materials import BUILT
from pioneer_control.simulator.world import known_worlds, load_world, standing_places
from pioneer_control.simulator.hardware.robot_numbers import LEGAL, load_numbers, standard_numbers

DOCS = pathlib.Path(__file__).resolve().parents[3] / "docs"
TEXT = (DOCS / "worlds.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```yaml\n(.*?)```", TEXT, re.DOTALL)


def test_every_world_of_the_gallery_is_shown():
    shown = re.findall(r"`(\w+)` !\[(\w+)\]\(images/world-(\w+)\.png\)", TEXT)
    assert sorted(shown) == [(name, name, name) for name in known_worlds()]
    assert all((DOCS / ("images/world-%s.png" % name)).stat().st_size < 70000 for name in known_worlds())


def test_the_example_of_a_world_loads(tmp_path):
    path = tmp_path / "small.yaml"
    path.write_text(EXAMPLES[0], encoding="utf-8")
    world = load_world(path)
    assert (len(world.walls), len(world.posts), len(world.cans), len(world.docks)) == (8, 1, 2, 1)
    assert list(world.goals) == ["window"] and [place.name for place in world.places] == ["depot", "hole"]


def test_the_example_of_numbers_loads(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(EXAMPLES[1], encoding="utf-8")
    numbers = load_numbers(str(path))
    assert (numbers.wheels.right_larger, numbers.sonar.specular_deg) == (0.004, 40)


def test_the_table_of_the_lasers_numbers():
    rows = dict((name, rest) for name, *rest in re.findall(
        r"^\| `laser\.(\w+)` \| (.*?) \| (.*?) \|", TEXT, re.MULTILINE))
    numbers = standard_numbers().laser
    assert list(rows) == [field.name for field in dataclasses.fields(numbers)]
    for name, (default, legal) in rows.items():
        check = LEGAL.get("laser.%s" % name, Switch())
        assert name == "needed_reflectivity" or getattr(numbers, name) == yaml.safe_load(default), name
        assert name == "needed_reflectivity" or check.legal.replace("a number from ", "") == legal, name


def test_the_table_of_materials():
    told = re.findall(r"^\| `(\w+)` \| (?:a wall as usual|black|a pane|the ray is|retro)", TEXT, re.MULTILINE)
    assert told == list(BUILT)


def test_how_far_what_is_dark_and_what_is_glass_are_seen():
    numbers = standard_numbers().laser
    for reflectivity, far in ((numbers.dark_reflectivity, 5.6), (numbers.glass_reflectivity, 7.0)):
        needed = [float(np.interp(distance, *zip(*numbers.needed_reflectivity))) for distance in (far, far + 0.3)]
        assert needed[0] <= reflectivity < needed[1]


def test_the_table_of_numbers():
    rows = re.findall(r"^\| `(\w+)\.(\w+)` \| (\S+) \| (\S+) to (\S+) \|", TEXT, re.MULTILINE)
    for section, name, off, least, most in rows:
        assert getattr(getattr(standard_numbers(), section), name) == yaml.safe_load(off), name
        assert LEGAL["%s.%s" % (section, name)] == (float(least), float(most)), name
    told = {name for section, name, *_ in rows if section == "wheels"}
    assert told == {field.name for field in dataclasses.fields(standard_numbers().wheels)}
    told_of_sonar = {"sonar.%s" % name for section, name, *_ in rows if section == "sonar"}
    assert told_of_sonar == {name for name in LEGAL if name.startswith("sonar.")}


def test_the_table_of_objects_names_every_kind_that_is_read():
    table = " ".join(re.findall(r"^\| (`.*?) \|", TEXT, re.MULTILINE))
    kinds = [kind for pattern, _ in OBJECTS for kind in pattern.replace("\\w*", "").replace("\\", "").split("|")]
    assert kinds and all("`%s`" % kind in table for kind in kinds)


def test_the_numbers_of_robots_that_worlds_hold():
    sentence = re.search(r"how many it holds:\n(.*)\.", TEXT).group(1)
    told = dict(re.findall(r"`(\w+)` (\d+)", sentence))
    assert len(told) == 3
    for name, most in told.items():
        model = find_model("p3dx-sh")
        assert len(standing_places(load_world(name), model, int(most))) == int(most)
        with pytest.raises(ParameterError, match="has room for %s " % most):
            standing_places(load_world(name), model, int(most) + 1)
