"""Loads ``models.yaml`` and, over it, a user's own file of the same form."""

import difflib
import math
import os
from dataclasses import dataclass
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Tuple

import yaml

from ..errors import UnknownModelError, UsageError
from .model import GripperShape, RobotModel, Transducer

OWN_FILE = os.path.join(os.path.dirname(__file__), "models.yaml")
SECTIONS = ("gripper", "sonar_layouts", "aliases", "excluded", "models")
Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def _metres(value_mm: float) -> float:
    return value_mm / 1000.0


def _same(value: Any) -> Any:
    return value


class Key(NamedTuple):
    """What a key of the file becomes: a field, its conversion to the field's unit, its type in the file, its lowest legal value."""

    field: str
    convert: Callable[[Any], Any]
    kind: type
    lowest: float


MODEL_KEYS: Dict[str, Key] = {
    "firmware_family": Key("firmware_family", _same, str, 0),
    "length_front_mm": Key("length_front", _metres, float, 1),
    "length_rear_mm": Key("length_rear", _metres, float, 1),
    "width_mm": Key("width", _metres, float, 1),
    "max_linear_mm_s": Key("max_linear", _metres, float, 1),
    "max_angular_deg_s": Key("max_angular", math.radians, float, 1),
    "angle_units_per_turn": Key("angle_units_per_rev", _same, int, 360),
    "dist_mm_per_unit": Key("dist_mm_per_unit", _same, float, 1e-4),
    "vel_mm_s_per_unit": Key("vel_mm_s_per_unit", _same, float, 1e-4),
    "range_mm_per_unit": Key("range_mm_per_unit", _same, float, 1e-4),
    "diff_rad_per_mm": Key("diff_rad_per_mm", _same, float, 1e-5),
    "vel2_mm_s_per_unit": Key("vel2_mm_s_per_unit", _same, float, 1e-2),
    "front_bumpers": Key("front_bumpers", _same, int, 0),
    "rear_bumpers": Key("rear_bumpers", _same, int, 0),
    "battery_v": Key("battery_class", _same, int, 6),
    "can_carry_gripper": Key("can_carry_gripper", _same, bool, 0),
    "wheel_radius_mm": Key("wheel_radius", lambda value_mm: value_mm / 1000.0 or None, float, 0),
}
DEFAULTS = {"wheel_radius_mm": 0}
"""What a model need not say."""
GRIPPER_KEYS: Dict[str, Key] = {
    "paddle_start_mm": Key("paddle_start", _metres, float, 0),
    "paddle_length_mm": Key("paddle_length", _metres, float, 0),
    "paddle_thickness_mm": Key("paddle_thickness", _metres, float, 0),
    "opening_mm": Key("opening", _metres, float, 0),
    "close_time_s": Key("close_time", _same, float, 0.01),
    "lift_height_mm": Key("lift_height", _metres, float, 0),
    "lift_speed_mm_s": Key("lift_speed", _metres, float, 1),
    "inner_beam_mm": Key("inner_beam", _metres, float, 0),
    "outer_beam_mm": Key("outer_beam", _metres, float, 0),
    "grasp_time_s": Key("grasp_time", _same, float, 0),
    "min_object_mm": Key("min_object", _metres, float, 0),
    "max_object_mm": Key("max_object", _metres, float, 0),
}
FAMILIES = ("PSOS", "P2OS", "AROS", "ARCOS", "AmigOS", "AmigoSH", "uARCS", "MARCOS")


@dataclass(frozen=True)
class ModelTable:
    """All models by subtype, other names they are announced under, and names that are known but not driven (with the reason)."""

    models: Dict[str, RobotModel]
    aliases: Dict[str, str]
    excluded: Dict[str, str]

    def find(self, subtype: str) -> RobotModel:
        """The model of the subtype a robot announced, in any case.

        Raises UnknownModelError that names near models, or the reason why this one is excluded.
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
        raise UnknownModelError("unknown robot model %r (%s); name the one to use instead (parameter 'model', option --model), "
                                "or describe this one in a models file" % (subtype, known))


def load_table(override_file: Optional[str] = None) -> ModelTable:
    """The package's table with the values of a user's file over it.

    Raises UsageError that names the file, the model and the key when something in it makes no sense.
    """
    source = OWN_FILE
    content = _read(source)
    if override_file:
        source = override_file
        content = _merged(content, _read(source), source)
    gripper = _gripper(content["gripper"], source)
    models = {name: _model(name, content, gripper, source) for name in content["models"]}
    for alias, name in content["aliases"].items():
        if name not in models:
            raise UsageError("%s: alias %s names the model %r, which is not in the table" % (source, alias, name))
    return ModelTable(models, dict(content["aliases"]), {name.lower(): reason for name, reason in content["excluded"].items()})


def load_models(override_file: Optional[str] = None) -> Dict[str, RobotModel]:
    """All models by subtype."""
    return load_table(override_file).models


def find_model(subtype: str, override_file: Optional[str] = None) -> RobotModel:
    """The model of a subtype; raises UnknownModelError (see ModelTable.find) and UsageError (see load_table)."""
    return load_table(override_file).find(subtype)


def _read(path: str) -> Dict[str, Dict[str, Any]]:
    """A models file as sections of dictionaries, each present; raises UsageError."""
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
    return {section: content.get(section, {}) for section in SECTIONS}


def _merged(own: Dict[str, Dict[str, Any]], user: Dict[str, Dict[str, Any]], source: str) -> Dict[str, Dict[str, Any]]:
    """The user's values over ours; a model is merged key by key, everything else replaced entry by entry."""
    merged = {section: dict(own[section], **user[section]) for section in SECTIONS}
    for name, values in user["models"].items():
        if not isinstance(values, dict):
            raise UsageError("models file %s: model %s must be a mapping, not %r" % (source, name, values))
        merged["models"][name] = dict(own["models"].get(name, {}), **values)
    return merged


def _resolved(name: str, models: Dict[str, Dict[str, Any]], source: str, seen: Tuple[str, ...] = ()) -> Dict[str, Any]:
    """All values of a model, those of the model it is like included."""
    if name in seen:
        raise UsageError("%s: models are like each other in a circle: %s" % (source, " -> ".join(seen + (name,))))
    values = models[name]
    base = values.get("like")
    if base is None:
        return dict(values)
    if base not in models:
        raise UsageError("%s: model %s is like %r, which is not in the table" % (source, name, base))
    return dict(_resolved(base, models, source, seen + (name,)), **values)


def _model(name: str, content: Dict[str, Dict[str, Any]], gripper: GripperShape, source: str) -> RobotModel:
    where = "%s: model %s" % (source, name)
    values = dict(DEFAULTS, **_resolved(name, content["models"], source))
    values.pop("like", None)
    sonar = values.pop("sonar", None)
    legal = ["like", "sonar"] + list(MODEL_KEYS)
    for key in values:
        if key not in MODEL_KEYS:
            near = difflib.get_close_matches(str(key), legal, n=1)
            hint = ", did you mean %r?" % near[0] if near else ""
            raise UsageError("%s: unknown key %r%s (legal: %s)" % (where, key, hint, ", ".join(legal)))
    missing = [key for key in MODEL_KEYS if key not in values] + (["sonar"] if sonar is None else [])
    if missing:
        raise UsageError("%s lacks %s (or `like:` a model that has them)" % (where, ", ".join(missing)))
    arguments = _converted(where, values, MODEL_KEYS)
    if arguments["firmware_family"] not in FAMILIES:
        raise UsageError("%s: firmware_family is %r (legal: %s)" % (where, arguments["firmware_family"], ", ".join(FAMILIES)))
    return RobotModel(subtype=name, sonar=_transducers(where, sonar, content["sonar_layouts"]), gripper=gripper, **arguments)


def _transducers(where: str, sonar: Any, layouts: Dict[str, Any]) -> Tuple[Transducer, ...]:
    if isinstance(sonar, str):
        if sonar not in layouts:
            raise UsageError("%s: unknown sonar layout %r (known: %s)" % (where, sonar, ", ".join(layouts)))
        sonar = layouts[sonar]
    if not isinstance(sonar, list) or len(sonar) > 32:
        raise UsageError("%s: sonar must name a layout or list at most 32 poses, not %r" % (where, sonar))
    fitted: List[Transducer] = []
    for number, pose in enumerate(sonar):
        if pose is None:
            continue
        if not isinstance(pose, list) or len(pose) != 3:
            raise UsageError("%s: sonar %d must be [x_mm, y_mm, heading_deg] or null, not %r" % (where, number, pose))
        x_mm, y_mm, heading_deg = (_checked(where, "sonar %d" % number, value, float, -1e5) for value in pose)
        fitted.append(Transducer(number, x_mm / 1000.0, y_mm / 1000.0, math.radians(heading_deg)))
    return tuple(fitted)


def _gripper(values: Dict[str, Any], source: str) -> GripperShape:
    where = "%s: gripper" % source
    wrong = sorted(set(values) ^ set(GRIPPER_KEYS))
    if wrong:
        raise UsageError("%s: missing or unknown: %s (legal: %s)" % (where, ", ".join(wrong), ", ".join(GRIPPER_KEYS)))
    return GripperShape(**_converted(where, values, GRIPPER_KEYS))


def _converted(where: str, values: Dict[str, Any], keys: Dict[str, Key]) -> Dict[str, Any]:
    """The values of a file that ``keys`` describes, checked, as fields in their own units."""
    return {key.field: key.convert(_checked(where, name, values[name], key.kind, key.lowest)) for name, key in keys.items()}


def _checked(where: str, key: str, value: Any, kind: type, lowest: float) -> Any:
    """The value, if it is of its kind, finite and not below the lowest legal one."""
    right_type = isinstance(value, kind) or (kind is float and isinstance(value, int))
    if not right_type or (isinstance(value, bool) and kind is not bool):
        wanted = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}[kind]
        raise UsageError("%s: %s is %r, but must be %s" % (where, key, value, wanted))
    if kind in (float, int) and not (math.isfinite(value) and value >= lowest):
        raise UsageError("%s: %s is %r, but must be a finite number of at least %g" % (where, key, value, lowest))
    return value
