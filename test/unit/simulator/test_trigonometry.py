"""Trigonometry from + - * / and sqrt. It is as exact as it says, and gives the same bits on every computer."""

import ast
import hashlib
import inspect
import math
import pathlib
import random
import struct

import numpy as np
import pytest

from pioneer_control.simulator.world import poses as exact

ANGLES = [quarter * math.pi / 4.0 + aside for quarter in range(-40, 41) for aside in (-1e-9, 0.0, 1e-9)]
ANGLES += [random.Random(1).uniform(-10.0 ** power, 10.0 ** power) for power in range(-9, 7) for _ in range(100)]
VECTORS = [(random.Random(seed).uniform(-3.0, 3.0), random.Random(-seed).gauss(0.0, 1.0)) for seed in range(2000)]


@pytest.mark.parametrize("part, known", [(0, math.cos), (1, math.sin)])
def test_a_unit_vector_is_cosine_and_sine(part, known):
    assert max(abs(exact.unit(angle)[part] - known(angle)) for angle in ANGLES) < 1e-13


def test_many_unit_vectors_at_once_are_the_same_to_the_last_bit():
    cosines, sines = exact.units(np.array(ANGLES))
    assert list(zip(cosines.tolist(), sines.tolist())) == [exact.unit(angle) for angle in ANGLES]


def test_the_unit_vector_ahead():
    assert exact.unit(0.0) == exact.unit(-0.0) == (1.0, 0.0)


def test_the_unit_vector_of_a_heading_is_that_of_its_present_angle():
    heading = exact.Heading()
    angles = (0.0, 0.0, *ANGLES[:50], ANGLES[49], -ANGLES[49], 0.0)
    assert all(heading.unit(angle) == exact.unit(angle) for angle in angles)


def test_length_of_vectors():
    for y, x in VECTORS:
        assert exact.hypot(x, y) == pytest.approx(math.hypot(x, y), rel=1e-15)


def test_nothing_of_the_c_library_is_asked_but_what_is_exact():
    """floor and sqrt have exactly one right result. A C library may round every other function as it likes."""
    tree = ast.parse(inspect.getsource(exact))
    attributes = [node for node in ast.walk(tree) if isinstance(node, ast.Attribute)]
    used = {node.attr for node in attributes if getattr(node.value, "id", "") == "math"}
    assert used == {"nan", "pi", "floor", "sqrt"}
    assert not any(isinstance(node, ast.Pow) for node in ast.walk(tree))


def test_the_bits_are_those_of_every_other_computer():
    results = [value for angle in ANGLES[:243] for value in exact.unit(angle)]
    digest = hashlib.sha256(struct.pack("<%dd" % len(results), *results)).hexdigest()
    assert digest == "e8531cc60733b4546835e99b35173dc0c0faa4ce2afbefa8d2cfbc9ccb8a9adf"


INEXACT = {
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "hypot",
    "exp", "log", "log2", "log10", "pow", "dist", "fsum", "prod",
}
"""Functions of `math` and numpy that libraries round as they like."""
INEXACT_DRAWS = {
    "gauss", "normal", "standard_normal", "normalvariate", "lognormvariate", "expovariate", "vonmisesvariate",
    "betavariate", "gammavariate"}
"""Methods of `random.Random`, and of numpy's random numbers, that are made of these."""
OFF_THE_WIRE = {"node.py", "picture.py"}
"""Files of the simulator whose numbers no robot sees."""


def inexact_sums(source):
    """Yield the names of the inexact functions that a Python source uses, and "**" for each power of a number that may
    be a float.
    """
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Attribute):
            of_library = getattr(node.value, "id", "") in ("math", "np")
            if of_library and node.attr in INEXACT or node.attr in INEXACT_DRAWS:
                yield node.attr
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and not isinstance(node.left, ast.Constant):
            yield "**"


def test_a_sum_that_libraries_round_is_seen():
    source = "math.hypot(x, y) + x ** 2 + 2 ** 31 + math.sqrt(x) + self._random.gauss(0, 1) + exact.sin(x)"
    assert sorted(inexact_sums(source)) == ["**", "gauss", "hypot"]


@pytest.mark.parametrize("path", sorted(pathlib.Path(exact.__file__).parents[1].rglob("*.py")),
                         ids=lambda path: path.name)
def test_what_reaches_the_wire_is_rounded_alike_everywhere(path):
    if path.name not in OFF_THE_WIRE:
        assert list(inexact_sums(path.read_text(encoding="utf-8"))) == []
