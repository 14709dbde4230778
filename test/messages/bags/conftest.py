"""Lets the tests here, and those of test/rostest, import bag_factory."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
