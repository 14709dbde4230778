"""What command lines of this room have in common: tables of options, and checks of what was given."""

import argparse
from typing import Any, Dict, Iterable

from ..errors import UsageError
from ..parameters import Number


def refuse_launch_arguments(words: Iterable[str], names: Iterable[str]) -> None:
    """Refuse ``speed:=0.5`` behind ``rosrun``: to ROS it is the new name of a topic, and would silently do nothing.

    Args:
        words: of the command line.
        names: of the launch file's arguments.

    Raises:
        UsageError: a word of the command line gives an argument of the launch file.
    """
    for word in words:
        if word.partition(":=")[0] in names:
            raise UsageError("%s: this is the form for roslaunch; --help lists the options here" % word)


def parser_of(program: str, description: str, options: Dict[str, Dict[str, Any]],
              **more: Any) -> argparse.ArgumentParser:
    """A parser of options.

    Args:
        program: its name.
        description: what it does.
        options: for each option, its name (or names, with spaces between them) and the arguments of `add_argument`.
        more: arguments of the parser itself.
    """
    parser = argparse.ArgumentParser(prog=program, description=description, **more)
    for name, option in options.items():
        parser.add_argument(*name.split(), **option)
    return parser


def yes_or_no(text: str) -> bool:
    """The value of "true" or "false", as launch files write it.

    Raises:
        ArgumentTypeError: the text is neither.
    """
    if text.lower() not in ("true", "false"):
        raise argparse.ArgumentTypeError("%r is not legal: give true or false" % text)
    return text.lower() == "true"


def number(name: str, text: str, low: float, high: float) -> float:
    """The number that an option gives.

    Args:
        name: of the option, for the error.
        text: what was given.
        low: the least legal number.
        high: the greatest legal number.

    Raises:
        UsageError: the text is not a number from `low` to `high`.
    """
    kind = Number(low, high)
    try:
        return kind.accept(float(text))
    except ValueError:
        raise UsageError("%s: %r is not legal: give %s" % (name, text, kind.legal)) from None


def say(sentence: str) -> None:
    """Print a sentence without delay, because other programs print in between."""
    print(sentence, flush=True)
