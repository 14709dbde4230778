"""Serves `pip install .` (the ROS-free part, anywhere) and catkin_python_setup() alike."""

import pathlib
import re

from setuptools import find_packages, setup

INIT = pathlib.Path(__file__).parent / "src" / "pioneer_control" / "__init__.py"

setup(
    name="pioneer_control",
    version=re.search(r'^__version__ = "(.+)"', INIT.read_text(encoding="utf-8"), re.MULTILINE).group(1),
    description="Pioneer robots from Python and ROS: P2OS protocol, client, driver, tutorial, simulated robot",
    author="the pioneer_control developers",
    author_email="maintainers@pioneer-control.example.org",
    license="BSD-3-Clause",
    package_dir={"": "src"},
    packages=find_packages("src"),
    package_data={"": ["*.yaml", "worlds/*.yaml", "arenas/*.yaml"], "pioneer_control.web": ["page/*"]},
    python_requires=">=3.8",
    install_requires=["numpy", "Pillow", "pyserial", "PyYAML", "websocket-client"],
    extras_require={"pictures": ["matplotlib", "lz4", "tqdm"], "page": ["tornado"]},
)
