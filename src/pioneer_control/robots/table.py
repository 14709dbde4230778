"""Loads the table of robot models: ``models.yaml``, and a user's own file of the same form that can replace values."""

import difflib
import functools
import math
import os
from dataclasses import dataclass
from typing import Any, Callable, Dict, Iterator, NamedTuple, Optional, Tuple

import yaml

from ..errors import UnknownModelError, UsageError
from ..parameters import Choice, Number, Numbers, Switch, Whole, nearest
from .model import BodyShape, GripperShape, LaserPlace, RobotModel, Transducer

OWN_FILE = os.path.join(os.path.dirname(__file__), "models.yaml")
SECTIONS = ("gripper", "sonar_layouts", "shapes", "aliases", "excluded", "models")
FAMILIES = ("PSOS", "P2OS", "AROS", "ARCOS", "AmigOS", "AmigoSH", "uARCS", "MARCOS")
MOST_TRANSDUCERS = 32
Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def _metres(value_mm: float) -> float:
    """Convert a length from millimetres to metres."""
    return value_mm / 1000.0


def _all_metres(values_mm: Tuple[float, ...]) -> Tuple[float, ...]:
    """Convert lengths from millimetres to metres."""
    return tuple(map(_metres, values_mm))


class Key(NamedTuple):
    """How to read one key of a models file.

    ``field`` is the name of the field of RobotModel, GripperShape and so on. ``kind`` checks the value. ``convert``
    converts it to the unit of the field, for example from mm to m.
    """

    field: str
    kind: Any
    convert: Callable[[Any], Any] = lambda value: value


MODEL_KEYS: Dict[str, Key] = {
    "firmware_family": Key("firmware_family", Choice(FAMILIES)),
    "length_front_mm": Key("length_front", Number(1, 1e4), _metres),
    "length_rear_mm": Key("length_rear", Number(1, 1e4), _metres),
    "width_mm": Key("width", Number(1, 1e4), _metres),
    "max_linear_mm_s": Key("max_linear", Number(1, 1e4), _metres),
    "max_angular_deg_s": Key("max_angular", Number(1, 3600), math.radians),
    "angle_units_per_turn": Key("angle_units_per_rev", Whole(360, 65536)),
    "dist_mm_per_unit": Key("dist_mm_per_unit", Number(1e-4, 100)),
    "vel_mm_s_per_unit": Key("vel_mm_s_per_unit", Number(1e-4, 100)),
    "range_mm_per_unit": Key("range_mm_per_unit", Number(1e-4, 100)),
    "diff_rad_per_mm": Key("diff_rad_per_mm", Number(1e-5, 1)),
    "vel2_mm_s_per_unit": Key("vel2_mm_s_per_unit", Number(1e-2, 1000)),
    "front_bumpers": Key("front_bumpers", Whole(0)),
    "rear_bumpers": Key("rear_bumpers", Whole(0)),
    "battery_v": Key("battery_class", Whole(6)),
    "can_carry_gripper": Key("can_carry_gripper", Switch()),
    "wheel_radius_mm": Key("wheel_radius", Number(0, 1e4), lambda value_mm: value_mm / 1000.0 or None),
    "turn_factor": Key("turn_factor", Number(0.5, 2)),
    "curve_deg_per_m": Key("curve_rad_per_m", Number(-45, 45), math.radians),
    "gyro_factor": Key("gyro_factor", Number(0.5, 2)),
}
LASER_KEYS: Dict[str, Key] = {
    "x_mm": Key("x", Number(-2000, 2000), _metres),
    "y_mm": Key("y", Number(-2000, 2000), _metres),
    "z_mm": Key("z", Number(0, 3000), _metres),
    "upside_down": Key("upside_down", Switch()),
}
NOT_NEEDED = ("z_mm",)
"""The keys of `LASER_KEYS` that a laser may leave out."""
DEFAULTS = {"wheel_radius_mm": 0, "turn_factor": 1, "curve_deg_per_m": 0, "gyro_factor": 1}
"""The keys that a model in the file may leave out, and their default values."""
GRIPPER_KEYS: Dict[str, Key] = {
    "paddle_start_mm": Key("paddle_start", Number(0, 1e4), _metres),
    "paddle_length_mm": Key("paddle_length", Number(0, 1e4), _metres),
    "paddle_thickness_mm": Key("paddle_thickness", Number(0, 1e4), _metres),
    "opening_mm": Key("opening", Number(0, 1e4), _metres),
    "close_time_s": Key("close_time", Number(0.01, 100)),
    "lift_height_mm": Key("lift_height", Number(0, 1e4), _metres),
    "lift_speed_mm_s": Key("lift_speed", Number(1, 1e4), _metres),
    "inner_beam_mm": Key("inner_beam", Number(0, 1e4), _metres),
    "outer_beam_mm": Key("outer_beam", Number(0, 1e4), _metres),
    "grasp_time_s": Key("grasp_time", Number(0, 100)),
    "min_object_mm": Key("min_object", Number(0, 1e4), _metres),
    "max_object_mm": Key("max_object", Number(0, 1e4), _metres),
}
SHAPE_KEYS: Dict[str, Key] = {
    "height_mm": Key("height", Number(1, 1e4), _metres),
    "clearance_mm": Key("clearance", Number(0, 1e4), _metres),
    "ring_mm": Key("ring", Numbers(2, 0, 1e4), _all_metres),
    "overhang_mm": Key("overhang", Number(0, 1e4), _metres),
    "wheel_radius_mm": Key("wheel_radius", Number(1, 1e4), _metres),
    "wheel_width_mm": Key("wheel_width", Number(1, 1e4), _metres),
    "wheels_inside": Key("wheels_inside", Switch()),
    "axles_mm": Key("axles", Numbers(None, -1e4, 1e4), _all_metres),
    "castors_mm": Key("castors", Numbers(None, -1e4, 1e4), _all_metres),
    "castor_radius_mm": Key("castor_radius", Number(1, 1e4), _metres),
    "tower_mm": Key("tower", Number(0, 1e4), _metres),
    "upper_arrays": Key("upper_arrays", Numbers(None, 0, 3), lambda numbers: tuple(map(int, numbers))),
}


@dataclass(frozen=True)
class ModelTable:
    """All robot models.

    Attributes:
        models: from the subtype (the name that a robot announces) to the model.
        aliases: from other names that robots announce to the subtype to use.
        excluded: from the name of a robot that we do not support (in lower case) to the reason, for people.
    """

    models: Dict[str, RobotModel]
    aliases: Dict[str, str]
    excluded: Dict[str, str]

    def find(self, subtype: str) -> RobotModel:
        """Return the model for a subtype or an alias. Upper and lower case make no difference.

        Raises:
            UnknownModelError: the table has no such model, or the model is excluded. The error message lists models
                with similar names, or gives the reason for the exclusion.
        """
        wanted = subtype.strip().lower()
        by_lower_case = {name.lower(): name for name in self.models}
        wanted = {alias.lower(): name for alias, name in self.aliases.items()}.get(wanted, wanted).lower()
        if wanted in by_lower_case:
            return self.models[by_lower_case[wanted]]
        if wanted in self.excluded:
            raise UnknownModelError("robot model %r is not supported: %s" % (subtype, self.excluded[wanted]))
        near = [by_lower_case[name] for name in difflib.get_close_matches(wanted, by_lower_case, n=3, cutoff=0.5)]
        known = "near: %s" % ", ".join(near) if near else "known: %s" % ", ".join(sorted(self.models))
        raise UnknownModelError(
            "unknown robot model %r (%s); name the one to use instead (parameter 'model', option --model), "
            "or describe this one in a models file" % (subtype, known))


def load_table(override_file: Optional[str] = None) -> ModelTable:
    """Load the models of this package. Values from ``override_file`` replace ours, and can add models.

    Raises:
        UsageError: a file cannot be read, or a value in it is not legal. The error message names the file, the model
            and the key.
    """
    if not override_file:
        return _own_table()
    return _table(_merged(_read(OWN_FILE), _read(override_file), override_file), override_file)


@functools.lru_cache(maxsize=None)
def _own_table() -> ModelTable:
    """Return the models of this package. They are read once: reading takes 10 ms, for each of many robots."""
    return _table(_read(OWN_FILE), OWN_FILE)


def _table(content: Dict[str, Dict[str, Any]], source: str) -> ModelTable:
    """Return the table of the sections of a models file. Raises UsageError when a value is not legal."""
    gripper = GripperShape(**_converted("%s: gripper" % source, content["gripper"], GRIPPER_KEYS))
    models = {name: _model(name, content, gripper, source) for name in content["models"]}
    for alias, name in content["aliases"].items():
        if name not in list(models):
            raise UsageError("%s: alias %s names the model %r, which is not in the table" % (source, alias, name))
    return ModelTable(models, dict(content["aliases"]),
                      {name.lower(): reason for name, reason in content["excluded"].items()})


def find_model(subtype: str, override_file: Optional[str] = None) -> RobotModel:
    """Load the table of models and return the model for a subtype or an alias.

    Raises:
        UnknownModelError: the table has no such model, or the model is excluded.
        UsageError: a models file cannot be read, or a value in it is not legal.
    """
    return load_table(override_file).find(subtype)


def _read(path: str) -> Dict[str, Dict[str, Any]]:
    """Read a models file and return its sections. A section that the file does not have is an empty dictionary.

    Raises:
        UsageError: the file cannot be read, is not YAML, or has a wrong section.
    """
    try:
        with open(path, encoding="utf-8") as file:
            content = yaml.load(file, Loader=Loader)
    except OSError as error:
        raise UsageError("models file %s cannot be read: %s" % (path, error.strerror)) from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise UsageError("models file %s is not valid YAML: %s" % (path, " ".join(str(error).split()))) from error
    if not isinstance(content, dict):
        raise UsageError("models file %s must be a mapping with the sections %s" % (path, ", ".join(SECTIONS)))
    for section, values in content.items():
        if section not in SECTIONS:
            raise UsageError("models file %s: unknown section %r (legal: %s)" % (path, section, ", ".join(SECTIONS)))
        if not isinstance(values, dict):
            raise UsageError("models file %s: section %s must be a mapping, not %r" % (path, section, values))
        for name in values:
            if not isinstance(name, str):
                raise UsageError("models file %s: %s: a name must be a text, not %r: write it in quotes" % (
                    path, section, name))
    return {section: content.get(section, {}) for section in SECTIONS}


def _merged(own: Dict[str, Dict[str, Any]], user: Dict[str, Dict[str, Any]], source: str) -> Dict[str, Dict[str, Any]]:
    """Return our sections with the values of the user's file in them.

    In the section ``models``, each key of the user's model replaces the same key of our model. In the other sections, a
    whole entry of the user replaces our entry. ``source`` is the name of the user's file, for errors.

    Raises:
        UsageError: a model in the user's file is not a mapping.
    """
    merged = {section: dict(own[section], **user[section]) for section in SECTIONS}
    for name, values in user["models"].items():
        if not isinstance(values, dict):
            raise UsageError("models file %s: model %s must be a mapping, not %r" % (source, name, values))
        merged["models"][name] = {**own["models"].get(name, {}), **values}
    return merged


def _resolved(name: str, models: Dict[str, Dict[str, Any]], source: str, seen: Tuple[str, ...] = ()) -> Dict[str, Any]:
    """Return all values of a model. Values that it does not give come from the model that its key ``like`` names.

    Args:
        name: the name of the model.
        models: the section ``models`` of the file.
        source: the name of the file, for errors.
        seen: the models that led here through ``like``, to find a circle.

    Raises:
        UsageError: ``like`` names an unknown model, or models are ``like`` each other in a circle.
    """
    if name in seen:
        raise UsageError("%s: models are like each other in a circle: %s" % (source, " -> ".join(seen + (name,))))
    values = dict(models[name])
    base = values.pop("like", None)
    if base is None:
        return values
    if base not in list(models):
        raise UsageError("%s: model %s is like %r, which is not in the table" % (source, name, base))
    return {**_resolved(base, models, source, seen + (name,)), **values}


def _model(name: str, content: Dict[str, Dict[str, Any]], gripper: GripperShape, source: str) -> RobotModel:
    """Return the model ``name`` from the sections of a models file. Raises UsageError when a value is not legal."""
    where = "%s: model %s" % (source, name)
    values = {**DEFAULTS, **_resolved(name, content["models"], source)}
    sonar, laser, shape = values.pop("sonar", None), values.pop("laser", "none"), values.pop("shape", "box")
    fields = _converted(where, values, MODEL_KEYS)
    if sonar is None:
        raise UsageError("%s lacks sonar: the name of a layout, a list of poses, or [] for none" % where)
    return RobotModel(subtype=name, sonar=tuple(_transducers(where, sonar, content["sonar_layouts"])),
                      gripper=gripper, laser=_laser("%s: laser" % where, laser),
                      shape=_shape(where, shape, content["shapes"]), **fields)


def _laser(where: str, laser: Any) -> Optional[LaserPlace]:
    """Return the place of a laser from the value of the key ``laser``. Raises UsageError when it is not legal."""
    if laser == "none":
        return None
    if not isinstance(laser, dict):
        raise UsageError("%s is %r, but must be none, or a mapping with %s" % (where, laser, ", ".join(LASER_KEYS)))
    keys = {name: key for name, key in LASER_KEYS.items() if name in laser or name not in NOT_NEEDED}
    return LaserPlace(**_converted(where, laser, keys))


def _shape(where: str, name: Any, shapes: Dict[str, Any]) -> BodyShape:
    """Return the shape ``name`` of the section ``shapes``. Raises UsageError when there is none, or it is not legal."""
    if name not in list(shapes):
        raise UsageError("%s: unknown shape %r (known: %s)" % (where, name, ", ".join(shapes)))
    where = "%s: shape %s" % (where, name)
    if not isinstance(shapes[name], dict):
        raise UsageError("%s must be a mapping, not %r" % (where, shapes[name]))
    return BodyShape(**_converted(where, shapes[name], SHAPE_KEYS))


def _transducers(where: str, sonar: Any, layouts: Dict[str, Any]) -> Iterator[Transducer]:
    """Yield the transducers of a model.

    Args:
        where: the file and the model, for errors.
        sonar: the value of the key ``sonar``: the name of a layout, or a list of poses [x_mm, y_mm, heading_deg]. The
            place in the list is the transducer number; null means that this transducer is not fitted.
        layouts: the section ``sonar_layouts`` of the file.

    Raises:
        UsageError: the layout is unknown, or a pose is not legal.
    """
    if isinstance(sonar, str):
        if sonar not in layouts:
            raise UsageError("%s: unknown sonar layout %r (known: %s)" % (where, sonar, ", ".join(layouts)))
        sonar = layouts[sonar]
    if not isinstance(sonar, list) or len(sonar) > MOST_TRANSDUCERS:
        raise UsageError("%s: sonar must name a layout or list at most %d poses, not %r"
                         % (where, MOST_TRANSDUCERS, sonar))
    for number, pose in enumerate(sonar):
        if pose is None:
            continue
        if not isinstance(pose, list) or len(pose) != 3:
            raise UsageError("%s: sonar %d must be [x_mm, y_mm, heading_deg] or null, not %r" % (where, number, pose))
        x_mm, y_mm, heading_deg = (_checked(where, "sonar %d" % number, value, Number(-1e4, 1e4)) for value in pose)
        yield Transducer(number, _metres(x_mm), _metres(y_mm), math.radians(heading_deg))


def _converted(where: str, values: Dict[str, Any], keys: Dict[str, Key]) -> Dict[str, Any]:
    """Check the values of one mapping of a models file, and convert them to the units of the fields.

    Args:
        where: the file and the model, for errors.
        values: the mapping: from a key of the file to its value.
        keys: all keys that the mapping must have.

    Returns:
        The converted values, by the name of the field.

    Raises:
        UsageError: a key is unknown or missing, or a value is not legal.
    """
    for name in values:
        if name not in keys:
            near = nearest(name, keys)
            hint = "" if near is None else ", did you mean %r?" % near
            raise UsageError("%s: unknown key %r%s (legal: %s)" % (where, name, hint, ", ".join(keys)))
    missing = [name for name in keys if name not in values]
    if missing:
        raise UsageError("%s lacks %s (or `like:` a model that has them)" % (where, ", ".join(missing)))
    return {key.field: key.convert(_checked(where, name, values[name], key.kind)) for name, key in keys.items()}


def _checked(where: str, name: str, value: Any, kind: Any) -> Any:
    """Return the value that ``kind.accept`` makes of a value in the file.

    Raises:
        UsageError: the value is not legal. The error message has ``where`` (the file and the model) and ``name``.
    """
    try:
        return kind.accept(value)
    except ValueError:
        raise UsageError("%s: %s is %r, but must be %s" % (where, name, value, kind.legal)) from None
