"""Reads YAML files as plain values, or node by node, so that an error message can name the line of the error."""

import re
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, NoReturn, Optional, Tuple

import yaml

from ..errors import ParameterError, WorldError
from ..parameters import Number, Numbers, nearest


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


def compose(path: Path, text: str, kind: str = "world file") -> Optional[yaml.Node]:
    """Parse a YAML text and return its root node. Every node has its line number.

    Args:
        path: file name for errors.
        text: YAML text.
        kind: what the file is, for errors.

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
        raise WorldError("%s %s%s: not YAML: %s"
                         % (kind, path, line, problem or " ".join(str(error).split()))) from error


LENGTH = Number(0.0001)
"""Legal lengths (m)."""
FARTHEST = 1e6
"""Greatest legal coordinate (m) of a map and of its places, along x and y, either way."""
EXPONENT = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+")
"""Numbers such as 1e-2, which are texts for PyYAML, and numbers for map_server."""
SafeConstructor: Any = yaml.constructor.SafeConstructor     # some stubs of PyYAML have no types for its methods
Read = Any
"""How to read the value of a key: an instance of a class of `pioneer_control.parameters`, which checks the plain value.

Or, for other values, a function that gets the node, and returns the value or raises a WorldError.
"""


class NodeReader:
    """Converts YAML nodes to values. All methods raise a WorldError when a node is not legal.

    Args:
        path: path of the file, for errors.
    """

    kind = "world file"
    """What the file is, for errors."""

    def __init__(self, path: Path):
        self.path = path

    def fail(self, node: yaml.Node, message: str) -> NoReturn:
        """Raise a WorldError that names the file and the line of a node."""
        raise WorldError("%s %s, line %s: %s" % (self.kind, self.path, node.start_mark.line + 1, message))

    def mapping(
        self, node: yaml.Node, what: str, needs: Mapping[str, Read], may: Optional[Mapping[str, Read]] = None,
        others: Optional[List[yaml.Node]] = None,
    ) -> Dict[str, Any]:
        """Return the values of a mapping, by key.

        Args:
            node: node of the mapping.
            what: name of the mapping in errors, such as "a wall".
            needs: how to read the values of required keys, by key.
            may: how to read the values of optional keys, by key.
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
                read = legal[key]
                values[key] = read(value_node) if callable(read) else self.checked(key, value_node, read)
            elif others is not None:
                others.append(key_node)
            else:
                near = nearest(key, legal)
                hint = "did you mean %r?" % near if near else "known: %s" % ", ".join(legal)
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

    def checked(self, name: str, node: yaml.Node, kind: Any) -> Any:
        """Return the value in a node.

        Args:
            name: name of the value, for errors.
            node: node of the value.
            kind: what is legal: an instance of a class of `pioneer_control.parameters`, such as ``Number(0, 1)``.
        """
        value = node.value
        if isinstance(kind, (Number, Numbers)):
            for each in value if isinstance(node, yaml.SequenceNode) else [node]:
                if isinstance(each, yaml.ScalarNode) and not each.style and EXPONENT.fullmatch(each.value):
                    each.tag = "tag:yaml.org,2002:float"
        try:
            value = SafeConstructor().construct_document(node)
            return kind.accept(value)
        except (ValueError, OverflowError, yaml.YAMLError):
            self.fail(node, "%s is %r; it must be %s" % (name, value, kind.legal))
