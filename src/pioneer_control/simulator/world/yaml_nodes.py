"""Reads YAML files as plain values, or node by node, so that an error message can name the line of the error."""

import difflib
import math
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, NoReturn, Optional, Tuple

import yaml

from ...errors import ParameterError, WorldError


def read_values(path: str) -> Any:
    """Return the content of a YAML file as plain Python values.

    Raises:
        ParameterError: the file cannot be read, or is not YAML.
    """
    try:
        with open(path, encoding="utf-8") as stream:
            return yaml.safe_load(stream)
    except OSError as error:
        raise ParameterError("cannot read %s: %s" % (path, error.strerror)) from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ParameterError("%s does not parse: %s" % (path, " ".join(str(error).split()))) from error


def compose(path: Path, text: str) -> Optional[yaml.Node]:
    """Parse a YAML text and return its root node. Every node has its line number.

    Args:
        path: file name for errors.
        text: YAML text.

    Returns:
        The root node, or None for an empty text.

    Raises:
        WorldError: the text is not YAML.
    """
    read: Callable[..., Optional[yaml.Node]] = yaml.compose      # some stubs of PyYAML have no types for it
    try:
        return read(text, Loader=yaml.SafeLoader)
    except yaml.YAMLError as error:
        mark, problem = getattr(error, "problem_mark", None), getattr(error, "problem", None)
        line = ", line %s" % (mark.line + 1) if mark else ""
        raise WorldError("world file %s%s: not YAML: %s"
                         % (path, line, problem or " ".join(str(error).split()))) from error


Read = Callable[[yaml.Node], Any]
"""A function that converts a YAML node to a value, or raises a WorldError."""


class NodeReader:
    """Converts YAML nodes to values, with one method for each kind of value.

    All methods raise a WorldError when a node is not legal.

    Args:
        path: path of the file, for errors.
    """

    def __init__(self, path: Path):
        self.path = path

    def fail(self, node: yaml.Node, message: str) -> NoReturn:
        """Raise a WorldError that names the file and the line of a node."""
        raise WorldError("world file %s, line %s: %s" % (self.path, node.start_mark.line + 1, message))

    def mapping(
        self, node: yaml.Node, what: str, needs: Mapping[str, Read], may: Optional[Mapping[str, Read]] = None,
        others: Optional[List[yaml.Node]] = None,
    ) -> Dict[str, Any]:
        """Return the values of a mapping, by key.

        Args:
            node: node of the mapping.
            what: name of the mapping in errors, such as "a wall".
            needs: functions that read the values of required keys, by key.
            may: functions that read the values of optional keys, by key.
            others: list to which the nodes of all other keys are appended. If None, other keys are an error.

        Raises:
            WorldError: the node is not such a mapping, or one of its values is not legal.
        """
        legal = {**needs, **(may or {})}
        if not isinstance(node, yaml.MappingNode):
            self.fail(node, "%s must be a mapping with the keys %s" % (what, ", ".join(legal)))
        values: Dict[str, Any] = {}
        for key_node, value_node in node.value:
            key = key_node.value
            if not isinstance(key_node, yaml.ScalarNode):
                self.fail(key_node, "keys must be plain words; known: %s" % ", ".join(legal))
            if key in values:
                self.fail(key_node, "%s has %r twice" % (what, key))
            if key in legal:
                values[key] = legal[key](value_node)
            elif others is not None:
                others.append(key_node)
            else:
                near = difflib.get_close_matches(key, legal, n=1)
                hint = "did you mean %r?" % near[0] if near else "known: %s" % ", ".join(legal)
                self.fail(key_node, "%s has no %r; %s" % (what, key, hint))
        missing = [key for key in needs if key not in values]
        if missing:
            self.fail(node, "%s needs %s" % (what, " and ".join(missing)))
        return values

    def items(self, node: yaml.Node, name: str) -> List[yaml.Node]:
        """Return the nodes of the entries of a list. Errors use `name` for the list."""
        if not isinstance(node, yaml.SequenceNode):
            self.fail(node, "%s must be a list" % name)
        return list(node.value)

    def mappings(
        self, node: yaml.Node, name: str, what: str, needs: Mapping[str, Read],
        may: Optional[Mapping[str, Read]] = None,
    ) -> List[Tuple[yaml.Node, Dict[str, Any]]]:
        """Return node and values of each entry of a list of mappings. For the arguments see `items` and `mapping`."""
        return [(entry, self.mapping(entry, what, needs, may)) for entry in self.items(node, name)]

    def numbers(self, node: yaml.Node, count: int, legal: str, read: Optional[Read] = None) -> Tuple[float, ...]:
        """Return the numbers of a list that has `count` of them.

        Args:
            node: node of the list.
            count: required length of the list.
            legal: error message when the node is not a list of this length.
            read: function that reads each number, `NodeReader.number` if None.
        """
        if not isinstance(node, yaml.SequenceNode) or len(node.value) != count:
            self.fail(node, legal)
        return tuple(map(read or self.number, node.value))

    def point(self, node: yaml.Node) -> Tuple[float, ...]:
        """Return the two numbers of a point, [x, y]."""
        return self.numbers(node, 2, "a point must be two numbers, [x, y]")

    def size(self, node: yaml.Node) -> Tuple[float, ...]:
        """Return the two numbers of a size, [along x, along y], which must be above 0."""
        return self.numbers(node, 2, "a size must be two numbers above 0, [along x, along y]", self.positive)

    def number(self, node: yaml.Node) -> float:
        """Return the number in a node, which must be finite."""
        try:
            value = float(node.value) if node.tag in ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float") else math.nan
        except ValueError:  # YAML's own spellings, such as 0x10 and 1:30
            value = math.nan
        if not math.isfinite(value):
            given = repr(node.value) if isinstance(node, yaml.ScalarNode) else "a list or mapping"
            self.fail(node, "a finite number is needed here, not %s" % given)
        return value

    def legal_number(self, node: yaml.Node, is_legal: Callable[[float], bool], otherwise: str) -> float:
        """Return the finite number in a node, which must be legal.

        Args:
            node: node of the number.
            is_legal: function that returns whether a number is legal.
            otherwise: error message when the number is not legal, with a %g for the number.
        """
        value = self.number(node)
        if not is_legal(value):
            self.fail(node, otherwise % value)
        return value

    def positive(self, node: yaml.Node) -> float:
        """Return the number in a node, which must be above 0."""
        return self.legal_number(node, lambda value: value > 0.0, "must be above 0, not %g")

    def boolean(self, node: yaml.Node) -> bool:
        """Return the boolean value of a node, such as ``true``, ``no`` or ``on``."""
        if node.tag != "tag:yaml.org,2002:bool":
            self.fail(node, "true or false is needed here")
        return node.value.lower() in ("true", "yes", "on")

    def text(self, node: yaml.Node) -> str:
        """Return the text in a node, which must not be empty."""
        if node.tag != "tag:yaml.org,2002:str" or not node.value:
            self.fail(node, "text is needed here")
        return str(node.value)
