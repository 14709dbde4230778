"""Which programs the launch files for driving and viewing start, and with which arguments. Nothing is started but a
stand-in for RViz.
"""

import os
import pathlib
import subprocess

import pytest
from roslaunch.config import load_config_default

ROOT = pathlib.Path(__file__).resolve().parents[2]


def launched(launch, *arguments):
    return load_config_default([(str(ROOT / "launch" / launch), list(arguments))], None, verbose=False)


@pytest.mark.parametrize("launch, arguments, node", [
    ("simulator.launch", [], "/simulator"), ("pioneer.launch", ["sim:=true"], "/pioneer/simulator")])
def test_a_simulated_robot_may_err_as_a_file_says(launch, arguments, node):
    config = launched(launch, "numbers_file:=wheels.yaml", *arguments)
    assert config.params[node + "/numbers_file"].value == "wheels.yaml"
    assert launched(launch, *arguments).params[node + "/numbers_file"].value == ""


@pytest.mark.parametrize("launch, arguments, node, usual", [
    ("simulator.launch", [], "/simulator", False), ("pioneer.launch", ["sim:=true"], "/pioneer/simulator", False),
    ("demo.launch", [], "/pioneer/simulator", True)])
def test_a_simulated_robot_may_err_as_a_real_one(launch, arguments, node, usual):
    assert launched(launch, *arguments).params[node + "/real"].value is usual
    assert launched(launch, "real:=true", *arguments).params[node + "/real"].value is True
    assert launched(launch, "real:=false", *arguments).params[node + "/real"].value is False


def test_what_ends_badly_at_the_start_ends_the_launch():
    """A program that fails at its start (wrong world, wrong model) ends the launch. With required:=false it does not.
    """
    nodes = launched("pioneer.launch", "sim:=true").nodes
    assert {node.type: node.required for node in nodes} == {"p2os_simulator": True, "p2os_driver": True}
    assert not any(node.required for node in launched("pioneer.launch", "sim:=true", "required:=false").nodes)
    assert all(node.required for node in launched("navigate.launch", "sim:=true").nodes)
    assert all(node.required for node in launched("explore.launch", "driver:=false").nodes)


def test_where_there_is_no_rviz_it_says_what_to_install(tmp_path):
    (node,) = [node for node in launched("view.launch").nodes if node.name == "rviz"]
    view = ROOT / "nodes" / node.type
    no_rviz = dict(os.environ, PATH=str(tmp_path))
    done = subprocess.run(["/usr/bin/python3", str(view)], env=no_rviz, stderr=subprocess.PIPE)
    assert done.returncode == 1
    assert b"RViz is not installed: sudo apt-get install rviz" in done.stderr


def test_under_navigation_rviz_does_not_listen_to_what_only_the_simulator_knows():
    """Its frame is joined to nothing there, so that these displays would be errors."""
    truth = {"world_markers", "markers", "cans", "ground_truth"}
    for launch, words, moved in (
            ("navigate.launch", ["rviz:=true"], truth), ("view.launch", [], set()),
            ("demo.launch", ["rviz:=true"], set()),
            ("demo.launch", ["rviz:=true", "navigate:=true"], truth)):
        (node,) = [node for node in launched(launch, *words).nodes if node.name == "rviz"]
        assert {name for name, _ in node.remap_args} == moved, launch
        assert not {new for _, new in node.remap_args} & truth


def test_where_there_is_one_it_gets_the_arguments(tmp_path):
    rviz = tmp_path / "rviz"
    rviz.write_text("#!/bin/sh\necho $*\n")
    rviz.chmod(0o755)
    view = ROOT / "nodes" / "view"
    done = subprocess.run(
        ["/usr/bin/python3", str(view), "-f", "map"], env=dict(os.environ, PATH=str(tmp_path)), stdout=subprocess.PIPE)
    assert done.stdout == b"-f map\n"
