"""The table of robot models: sizes, limits and units of each model (p3dx-sh, amigo-sh, ...), from ``models.yaml``.

>>> from pioneer_control.robots import find_model
>>> find_model("p3dx-sh").max_linear
2.2

The comment at the top of ``models.yaml`` explains every key. A model is found by its subtype, the name that a robot
announces when it connects. A user's own file of the same form can replace any value. ``table`` reads the file, and
``model`` holds the values of one model.
"""

from .model import (ARRAY_SIZE, HALF_CONE, SONAR_HEIGHT, BodyShape, GripperShape, LaserPlace, RobotModel,
                    Transducer)
from .table import ModelTable, find_model, load_table

__all__ = [
    "ARRAY_SIZE", "HALF_CONE", "SONAR_HEIGHT", "BodyShape", "GripperShape", "LaserPlace", "ModelTable", "RobotModel",
    "Transducer", "find_model", "load_table",
]
