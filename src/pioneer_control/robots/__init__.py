"""What differs between a p3dx-sh and an amigo-sh: one data file, ``models.yaml``, and the classes that load it.

>>> from pioneer_control.robots import find_model
>>> find_model("p3dx-sh").max_linear
2.2

Open ``models.yaml`` first: its head explains every key. The file is keyed by the subtype that a robot announces of
itself; a user's own file of the same form overrides any value of it. ``table`` reads the file, ``model`` is one entry.
"""

from .model import ARRAY_SIZE, GripperShape, RobotModel, Transducer
from .table import ModelTable, find_model, load_table

__all__ = [
    "ARRAY_SIZE", "GripperShape", "ModelTable", "RobotModel", "Transducer", "find_model", "load_table",
]
