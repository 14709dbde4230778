"""The documents are true: tables agree with the code that they describe, and links lead somewhere."""

import ast
import dataclasses
import pathlib
import re
import xml.etree.ElementTree as ElementTree
from typing import List, Set

import pytest
import yaml

from pioneer_control.client import alarms, drive, handshake, health, host_baud, phases, velocities
from pioneer_control.client.identity import DEFAULT_WATCHDOG
from pioneer_control.client.line import LONGEST_QUEUE
from pioneer_control.client.threads import BACK_OFF
from pioneer_control.client.tuning import ROWS
from pioneer_control.driver import notices
from pioneer_control.driver.parameters import TUNING, DriverParameters, PlaceOrNone, check_parameters
from pioneer_control.laser.parameters import LaserParameters, Mounting, check_laser_parameters
from pioneer_control.lms2xx import SPEEDS, VARIANTS, scan_time
from pioneer_control.navigation.node.parameters import NavigationParameters, PlaceOrNothing
from pioneer_control.p2os import knows
from pioneer_control.parameters import AutoSwitch, Choice, Number, Numbers, Rate, Signs, Switch, Text, Whole, Wholes
from pioneer_control.robots import load_table
from pioneer_control.robots.__main__ import main, table
from pioneer_control.robots.table import FAMILIES
from pioneer_control.simulator.line import faults
from pioneer_control.simulator.__main__ import parser as simulator_parser
from pioneer_control.simulator.parameters import SimulatorParameters

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
DOCUMENTS = sorted([*ROOT.glob("*.md"), *DOCS.glob("*.md")])
TYPES = {Number: "number", Rate: "number", Whole: "integer", Numbers: "list", Wholes: "list", Signs: "list",
         Switch: "bool", AutoSwitch: "bool, text", Text: "text", PlaceOrNothing: "list, text", Mounting: "list, text",
         PlaceOrNone: "list, text"}


def read(path: pathlib.Path) -> str:
    return path.read_text(encoding="utf-8")


def rows(text: str, chapter: str) -> List[List[str]]:
    """Return the cells of the first table in a chapter (its heading), without the two lines of the table's head."""
    part = re.split(r"^#+ %s\n" % re.escape(chapter), text, maxsplit=1, flags=re.MULTILINE)
    lines = re.search(r"(?:^\|.*\n)+", part[1], re.MULTILINE).group().splitlines() if len(part) > 1 else []
    return [[cell.strip() for cell in line.strip("|").split(" |")] for line in lines[2:]]


# Parameters: driver/parameters.py is the source.

def parameter_row(entry: dataclasses.Field) -> List[str]:
    """Return the row of a parameter: name, type, unit, default as in YAML, what is legal, meaning, whether it may
    change.
    """
    kind, unit, meaning, live = (entry.metadata[key] for key in ("kind", "unit", "meaning", "live"))
    default = entry.default
    if default is None:
        default = "" if isinstance(kind, (PlaceOrNothing, Mounting, PlaceOrNone)) else "auto"
    if isinstance(default, tuple):
        default = list(default)
    if isinstance(kind, Choice):
        type_name = {int: "integer", float: "number", str: "text"}[type(kind.choices[0])]
    else:
        type_name = TYPES[type(kind)]
    written = yaml.safe_dump(default, default_flow_style=True,
                             width=1000).replace("\n...", "").strip() if default != "" else ""
    return ["`%s`" % entry.name, type_name, unit, written, kind.legal, meaning, "yes" if live else ""]


def test_every_parameter_has_its_row():
    """When this fails, the message has the rows that docs/driver.md needs."""
    wanted = [parameter_row(entry) for entry in dataclasses.fields(DriverParameters)]
    assert rows(read(DOCS / "driver.md"), "Parameters") == wanted


def test_every_parameter_of_navigation_has_its_row():
    """When this fails, the message has the rows that docs/navigation.md needs."""
    wanted = [parameter_row(entry)[:-1] for entry in dataclasses.fields(NavigationParameters)]
    assert rows(read(DOCS / "navigation.md"), "Parameters") == wanted


def test_every_parameter_of_the_laser_has_its_row():
    """When this fails, the message has the rows that docs/laser.md needs."""
    wanted = [parameter_row(entry)[:-1] for entry in dataclasses.fields(LaserParameters)]
    assert rows(read(DOCS / "laser.md"), "Parameters") == wanted
    written = {row[0].strip("`"): yaml.safe_load(row[3] or "''") for row in wanted}
    assert check_laser_parameters(written) == (LaserParameters(), [])


def test_the_rates_of_a_laser_are_those_of_its_line():
    wanted = [["%d, %.2f" % (variant.angle_deg, variant.step_hundredths / 100.0), "%d" % variant.values] + [
        "%.3g" % (1.0 / scan_time(variant, baud)) for baud in SPEEDS] for variant in VARIANTS]
    assert rows(read(DOCS / "laser.md"), "Speeds and rates") == wanted
    assert sorted(SPEEDS) == list(SPEEDS)


def test_defaults_can_be_written_as_they_are_read():
    written = {row[0].strip("`"): yaml.safe_load(row[3] or "''")
               for row in rows(read(DOCS / "driver.md"), "Parameters")}
    assert check_parameters(written) == (DriverParameters(), [])


def test_a_row_that_lies_is_seen():
    text = read(DOCS / "driver.md")
    lie = text.replace("a number from 0.1 to 2 |", "a number from 0.1 to 20 |")
    assert lie != text and rows(lie, "Parameters") != rows(text, "Parameters") and rows(text, "No such chapter") == []


def test_the_readmes_parameters_are_rows_of_that_table():
    wanted = {row[0]: row[:-1] for row in map(parameter_row, dataclasses.fields(DriverParameters))}
    few = rows(read(ROOT / "README.md"), "Parameters of the driver")
    assert few == [wanted.get(row[0]) for row in few] != []


# Models: robots/models.yaml is the source.

def test_the_table_of_models_is_what_the_command_prints():
    """`python3 -m pioneer_control.robots` prints the table that docs/models.md must have."""
    text, models = read(DOCS / "models.md"), load_table()
    assert "\n".join(table(models.models)) in text
    assert [name for name in [*models.aliases, *models.excluded] if "`%s`" % name not in text] == []


def test_the_table_shows_a_models_file(tmp_path, capsys):
    mine = tmp_path / "mine.yaml"
    mine.write_text("models: {p3dx-sh: {width_mm: 444}, my-robot: {like: amigo-sh}}")
    assert main([str(mine)]) == 0
    printed = capsys.readouterr().out
    assert "0.444" in printed and "`my-robot` | AmigoSH" in printed and "0.444" not in read(DOCS / "models.md")


def test_a_models_file_that_makes_no_sense_is_told(tmp_path, capsys):
    mine = tmp_path / "mine.yaml"
    mine.write_text("models: {p3dx-sh: {widht_mm: 444}}")
    with pytest.raises(SystemExit):
        main([str(mine)])
    assert "did you mean 'width_mm'" in capsys.readouterr().err


def test_what_older_firmware_lacks():
    heads = ["PSOS", "P2OS, AmigOS", "AROS", "ARCOS, AmigoSH, uARCS, MARCOS"]
    assert "| " + " | ".join(heads) + " |" in read(DOCS / "models.md")
    assert sorted(", ".join(heads).split(", ")) == sorted(FAMILIES)
    told = {}
    for names, *columns in rows(read(DOCS / "models.md"), "What older firmware lacks"):
        lacking = {family for head, column in zip(heads, columns) if column == "-" for family in head.split(", ")}
        told.update(dict.fromkeys(re.findall(r"\w+", names), lacking))
    assert told == {name: {family for family in FAMILIES if not knows(family, ROWS[TUNING[name]].command)}
                    for name in TUNING}


# Numbers in sentences

SENTENCES = [
    ("no velocity for `cmd_vel_timeout` (%g s)", DriverParameters.cmd_vel_timeout),
    ("exact on average over a second", velocities.ROUNDING_PERIOD == 1.0),
    ("slowed down within %g s", drive.REFRESH),
    ("it stands for %g s though it is told to drive", drive.MOVES_WITHIN),
    ("link lost after %.1f s without a packet", phases.SILENCE),
    ("up to %g s to come to rest", phases.STAND_TIMEOUT),
    ("after %g s without a packet the first thing sent is a stop", DEFAULT_WATCHDOG * phases.WATCHDOG_MARGIN),
    ("2 s after the last packet, by its own watchdog", DEFAULT_WATCHDOG == 2.0),
    ("beyond %d waiting other commands", LONGEST_QUEUE),
    ("tries again %g s after each attempt", BACK_OFF),
    ("each reason every %d s at most", notices.PERIOD),
    ("a warning every %d s", notices.PERIOD),
    ("else %g V (%g V)", (alarms.LOW_BATTERY_12_V, 2 * alarms.LOW_BATTERY_12_V)),
    ("Listen for %g s", handshake.LISTEN),
    ("at the new speed within %g s", host_baud.ANSWER),
    ("within the last %d s", health.WINDOW),
    ("less than %d %% come", health.RATE_OK * 100),
    ("%d degrees below the level of switching off", health.NEAR_LIMIT),
]


@pytest.mark.parametrize("sentence, numbers", SENTENCES)
def test_a_number_in_a_sentence_is_the_constant(sentence, numbers):
    wanted = sentence if isinstance(numbers, bool) else sentence % numbers
    assert numbers and wanted in " ".join(read(DOCS / "driver.md").split())


def test_how_long_connecting_takes_is_what_the_handshake_says():
    told = re.findall(r"\d\.\d s", " ".join(sum(rows(read(DOCS / "driver.md"), "Getting the link back"), [])))
    assert told == re.findall(r"\d\.\d s", handshake.__doc__.partition("====\n")[2])


# The simulated robot: simulator/line/faults.py, simulator/parameters.py and a test are the sources.

def test_the_table_of_faults_is_that_of_the_simulator():
    wanted = [["`%s`" % kind.name, kind.value.legal if kind.value else "", kind.unit, kind.meaning]
              for kind in faults.KINDS.values()]
    assert rows(read(DOCS / "simulator.md"), "Faults") == wanted


def test_the_simulators_node_has_the_parameters_that_are_named():
    told = set(re.findall(r"`(\w+)`", read(DOCS / "simulator.md").partition("as private parameters:")[2].partition(
        "and the frames")[0]))
    frames = {"map_frame", "map_tf", "odom_frame_id", "base_link_frame_id", "frame_prefix"}
    assert told | frames == {entry.name for entry in dataclasses.fields(SimulatorParameters)}


def test_the_options_that_are_told_are_there():
    known = {option for action in simulator_parser()._actions for option in action.option_strings}
    told = re.findall(r"`(--\w+)", " ".join(row[0] for row in rows(read(DOCS / "simulator.md"), "Running it")))
    assert len(told) > 8 and set(told) <= known


def test_the_examples_are_code_that_is_tested():
    examples = re.findall(r"^```python\n(.*?)^```", read(DOCS / "simulator.md"), re.MULTILINE | re.DOTALL)
    source = "".join(read(ROOT / "test" / "integration" / name)
                     for name in ("test_lockstep.py", "test_somebody_elses_client.py"))
    assert len(examples) == 4 and all(example in source for example in examples)


# Launch files

def test_the_readme_names_every_launch_file_and_arguments_that_it_has():
    told = {row[0].strip("`"): re.findall(r"`(\w+)`", row[2]) for row in rows(read(ROOT / "README.md"), "Launch files")}
    assert sorted(told) == sorted(path.name for path in (ROOT / "launch").iterdir())
    for name, arguments in told.items():
        declared = {element.get("name")
                    for element in ElementTree.parse(ROOT / "launch" / name).getroot().findall("arg")}
        assert set(arguments) <= declared, name


@pytest.mark.parametrize("path", sorted((ROOT / "launch").iterdir()), ids=lambda path: path.name)
def test_a_launch_file_tells_what_each_argument_is(path):
    """roslaunch --ros-args shows the description."""
    arguments = ElementTree.parse(path).getroot().findall("arg")
    assert [argument.get("name") for argument in arguments if argument.get("value") is None and
            not argument.get("doc")] == []


# The tutorial's table of corrections

SHOWN_BY = [path for folder in ("test", "bench") for path in (ROOT / folder).rglob("*.py")]


def missing_tests(cell: str) -> List[str]:
    """Return files and tests that a cell names and that do not exist: "test_pick.py: `test_held_is_...`, `test_3`"."""
    missing = []
    for named in cell.split("; "):
        file, *tests = re.findall(r"[\w/]+\.py|test_\w+", named) or [""]
        texts = [read(path) for path in SHOWN_BY if file and path.as_posix().endswith("/" + file)]
        missing += [file] if file and not texts else [test for test in tests
                                                      if not any("def %s" % test.rstrip(".") in text for text in texts)]
    return missing


def test_what_shows_a_correction_is_there():
    table = rows(read(DOCS / "tutorial.md"), "What was corrected")
    assert len(table) > 20 and [row for row in table if missing_tests(row[-1])] == []


@pytest.mark.parametrize("cell, missing", [
    ("test_house.py: `test_parses_as_python_3_8`", []), ("test_pick.py: `test_held_is_...`; bench/picking.py", []),
    ("every rostest starts it", []),
    ("test_house.py: `test_no_such_...`", ["test_no_such_"]), ("test_hovel.py: `test_1`", ["test_hovel.py"])])
def test_what_is_not_there_is_seen(cell, missing):
    assert missing_tests(cell) == missing


# Links

def anchors(text: str) -> List[str]:
    """Return the targets of links into a document: its headings, as GitHub spells them."""
    headings = re.findall(r"^#+ +(.+?) *$", re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL),
                          re.MULTILINE)
    return [re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings]


def dead_links(path: pathlib.Path, text: str) -> List[str]:
    """Return relative links to a missing file or heading."""
    dead = []
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        place, _, anchor = link.partition("#")
        if ":" in place:
            continue
        target = path.parent / place if place else path
        if not target.exists() or anchor and anchor not in anchors(text if target == path else read(target)):
            dead.append(link)
    return dead


@pytest.mark.parametrize("path", [*DOCUMENTS, *sorted((ROOT / "bench").glob("*.md"))],
                         ids=lambda path: path.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(path):
    assert dead_links(path, read(path)) == []


def test_every_document_can_be_found():
    """A few links lead from the README to every document."""
    found, new = set(), {ROOT / "README.md"}
    while new:
        found |= new
        links = {(path.parent / link.partition("#")[0]).resolve() for path in new
                 for link in re.findall(r"\]\(([^)\s]+)\)", read(path))}
        new = {path for path in links if path.suffix == ".md" and path.exists()} - found
    assert set(DOCUMENTS) - found == set()


@pytest.mark.parametrize("link, is_dead", [
    ("CONTRIBUTING.md", False), ("CONTRIBUTING.md#the-house", False), ("#two-commands", False),
    ("https://example.org/x", False),
    ("NOTHING.md", True), ("CONTRIBUTING.md#the-hovel", True), ("#three-commands", True)])
def test_a_dead_link_is_seen(link, is_dead):
    assert dead_links(ROOT / "README.md", "## Two commands\n[text](%s)\n" % link) == ([link] if is_dead else [])


# What a program of the reader's imports is there.

def missing_imports(text: str) -> List[str]:
    """Return what the Python blocks of a document import from this package, and the package does not have."""
    missing = []
    for block in re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        for module, names in re.findall(r"^from (pioneer_control\S*) import ([\w, ]+)", block, re.MULTILINE):
            place = ROOT / "src" / module.replace(".", "/")
            wanted = [name.strip() for name in names.split(",")]
            if module in ("pioneer_control.msg", "pioneer_control.srv"):
                folder = ROOT / module.rpartition(".")[2]
                missing += ["%s.%s" % (module, name) for name in wanted if not list(folder.glob(name + ".*"))]
                continue
            path = place.with_suffix(".py") if place.with_suffix(".py").exists() else place / "__init__.py"
            there = names_in(path) if path.exists() else set()
            missing += ["%s.%s" % (module, name) for name in wanted if name not in there]
    return missing


def names_in(path: pathlib.Path) -> Set[str]:
    """Return the names that a module defines or imports at its top."""
    found = set()
    for node in ast.parse(read(path)).body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            found.add(node.name)
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            found |= {(alias.asname or alias.name) for alias in node.names}
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found |= {target.id for target in targets if isinstance(target, ast.Name)}
    return found


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_what_a_document_imports_is_there(path):
    assert missing_imports(read(path)) == []


@pytest.mark.parametrize("line, missing", [
    ("from pioneer_control.client import Robot", []),
    ("from pioneer_control.msg import SonarArray", []),
    ("from pioneer_control.client import Robot, Car", ["pioneer_control.client.Car"]),
    ("from pioneer_control.msg import Elephant", ["pioneer_control.msg.Elephant"]),
    ("from pioneer_control.cellar import wine", ["pioneer_control.cellar.wine"])])
def test_an_import_of_what_is_gone_is_seen(line, missing):
    assert missing_imports("```python\n%s\n```\n" % line) == missing


def test_the_lesson_names_buttons_that_the_page_has():
    """Buttons are bold where the teacher presses them, and slanted where the teacher speaks."""
    page = "".join(read(path) for path in sorted((ROOT / "src/pioneer_control/web/page").iterdir()))
    tasks = read(ROOT / "src/pioneer_control/simulator/tasks/tasks.yaml")
    lesson = read(DOCS / "lesson.md").partition("\n## ")[2]      # before it: what bold means
    pressed = [word for line in lesson.splitlines() if not line.startswith(">")
               for word in re.findall(r"\*\*([^*]+)\*\*", line) if len(word.split()) < 4]
    pressed += re.findall(r"[Pp]ress(?:ed)? \*([^*]+)\*", lesson)
    assert {"STOP all", "Join", "Switch motors on", "Drive a square", "Students' address"} <= set(pressed)
    assert [word for word in pressed if word not in page + tasks and word != "Switch motors on"] == []
    assert '"Switch motors " + (motors ? "off" : "on")' in page
