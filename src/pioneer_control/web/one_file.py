"""Joins the page and a recording into one HTML file that opens by a double click.

A browser loads no modules from file://, so the modules become one classic script. This works because they keep to
``import {a, b} from "./x.js";`` and ``export function``, ``export class``, ``export const`` or ``export async
function``, and because no name is used twice in all of them. A module that does otherwise is refused. A module that is
loaded only when it is needed, by ``import("./x.js")``, is in the script too: the promise is of what it exports.
"""

import base64
import json
import os
import pathlib
import re
import sys
from typing import Any, Dict, List, Mapping, Optional, Sequence

from ..bags.command_line import Progress, in_order, parser_of, say, stem
from ..errors import PioneerError, UsageError
from ..whole_file import writing
from .recorded import Recording, read_recording

PAGE = pathlib.Path(__file__).resolve().parent / "page"
START = "main.js"
OPTIONS: Dict[str, Dict[str, Any]] = {
    "bag": dict(nargs="+", help="the bag; if there are several, the parts of one recording"),
    "--html": dict(action="store_true", required=True, help="write one HTML file that plays the run in a browser"),
    "-o --output": dict(metavar="FILE", help="the file to write (default: beside the first bag, .html)"),
    "--title": dict(help="what the page is called (default: the name of the bag)"),
}
_IMPORT = re.compile(r'^import \{([\w$, ]+)\} from "\./([\w-]+\.js)";\n', re.MULTILINE)
_LATE = re.compile(r'\bimport\("\./([\w-]+\.js)"\)')
_EXPORT = re.compile(r"^export (?=(?:async )?function |class |const )", re.MULTILINE)
_LEFT = re.compile(r"^\s*(?:import|export)\b.*|\bimport\(.*", re.MULTILINE)
_STYLE = '<link rel="stylesheet" href="style.css">\n'
_SCRIPT = '<script type="module" src="main.js"></script>\n'


def names_of(text: str) -> List[str]:
    """Return the names that a module has at its top, where each statement begins with one of its own."""
    found = re.findall(r"^(?:export )?(?:async )?(?:function|class) ([\w$]+)", text, re.MULTILINE)
    for statement in re.findall(r"^(?:export )?(?:const|let) (.*?);", text, re.MULTILINE | re.DOTALL):
        found += _declared(statement)
    return found


def _declared(statement: str) -> List[str]:
    """Return the names of ``a = f(b, c), d = {e: 1}``: those outside of all brackets and texts."""
    flat = re.sub(r"\"[^\"]*\"|'[^']*'", "0", statement)
    while True:
        shorter = re.sub(r"\([^()]*\)|\[[^\[\]]*\]|\{[^{}]*\}", "0", flat)
        if shorter == flat:
            break
        flat = shorter
    return [match for part in flat.split(",") for match in re.findall(r"^\s*([A-Za-z_$][\w$]*)\s*=(?![=>])", part)]


def exports_of(text: str) -> List[str]:
    """Return the names that a module exports."""
    return re.findall(r"^export .*?(?:function|class|const) ([\w$]+)", text, re.MULTILINE)


def order_of(modules: Mapping[str, str], start: str = START) -> List[str]:
    """Return the names of the modules that ``start`` needs, each behind those that it imports.

    Raises:
        UsageError: a module is not there, does not export what is imported, or modules import each other in a circle.
    """
    ordered: List[str] = []

    def visit(name: str, path: List[str]) -> None:
        if name in path:
            raise UsageError("modules import each other in a circle: " + ", ".join(path + [name]))
        if name not in modules:
            raise UsageError("%s imports %s, which is not there" % (path[-1] if path else "the page", name))
        if name in ordered:
            return
        for wanted, other in _IMPORT.findall(modules[name]):
            visit(other, path + [name])
            exported = exports_of(modules[other])
            for each in re.split(r", *", wanted.strip()):
                if each not in exported:
                    raise UsageError("%s imports %s, which %s does not export" % (name, each, other))
        for other in _LATE.findall(modules[name]):
            visit(other, path + [name])
        ordered.append(name)
    visit(start, [])
    return ordered


def join_modules(modules: Mapping[str, str], start: str = START) -> str:
    """Return modules, given by their names, as one classic script.

    Raises:
        UsageError: they use other forms of import or export than those above, or a name twice.
    """
    owners: Dict[str, str] = {}
    parts = []
    for name in order_of(modules, start):
        text = _LATE.sub(lambda late: "Promise.resolve({%s})" % ", ".join(exports_of(modules[late.group(1)])),
                         _EXPORT.sub("", _IMPORT.sub("", modules[name])))
        left = _LEFT.search(text)
        if left:
            raise UsageError("%s: a form of import or export that cannot be joined: %s" % (name, left.group().strip()))
        for each in names_of(modules[name]):
            if each in owners:
                raise UsageError("%s is a name in %s and in %s" % (each, owners[each], name))
            owners[each] = name
        parts.append("// --- %s ---\n%s" % (name, text))
    return '"use strict";\n(() => {\n%s})();\n' % "\n".join(parts)


def one_file(recording: Mapping[str, Any], page: pathlib.Path = PAGE) -> str:
    """Return the page as one HTML text with a recording inside.

    Args:
        recording: the value of a recording, as in docs/page-protocol.md,
            each entry of ``columns`` with ``data``.
        page: the folder of the page.

    Raises:
        UsageError: the page's files cannot be joined.
    """
    html = (page / "index.html").read_text(encoding="utf-8")
    for wanted in (_STYLE, _SCRIPT):
        if wanted not in html:
            raise UsageError("index.html has no line %s" % wanted.strip())
    script = join_modules({path.name: path.read_text(encoding="utf-8") for path in page.glob("*.js")})
    style = (page / "style.css").read_text(encoding="utf-8")
    # A text of the recording must not end the element that it is in.
    inside = json.dumps(recording, separators=(",", ":")).replace("<", "\\u003c")
    if "</" in script or "</" in style:
        raise UsageError("script or style has a </, which could end its element")
    return html.replace(_STYLE, "<style>\n%s</style>\n" % style).replace(_SCRIPT, "") + (
        '<script type="application/json" id="recording">%s</script>\n<script>\n%s</script>\n' % (inside, script))


def recording_inside(recording: Recording) -> Dict[str, Any]:
    """Return the value of ``recording`` for one file: with the columns of each robot inside, as base64."""
    columns = [dict(entry, data=base64.b64encode(message[3:]).decode())
               for entry, message in zip(recording.value["columns"], recording.columns)]
    return dict(recording.value, columns=columns)


def main(arguments: Optional[Sequence[str]] = None, program: str = "draw_run") -> int:
    """Write the HTML file of a run that the command line of a program names: ``draw_run --html RUN.bag``.

    Returns:
        The exit status: 0 when the file is written, 2 after an error, 130 after Ctrl-C.
    """
    options = parser_of(program + " --html", "Make a page of a recorded run that plays in a browser, without a server.",
                        OPTIONS).parse_args(arguments)
    output = options.output or stem(options.bag[0]) + ".html"
    try:
        name = options.title or os.path.basename(stem(options.bag[0]))
        bags = in_order(options.bag)
        with Progress(os.path.basename(bags[0])) as progress:
            recording = read_recording(bags, name, progress)
        with writing(output) as part, open(part, "w", encoding="utf-8") as file:
            file.write(one_file(recording_inside(recording)))
    except (PioneerError, OSError) as error:
        print("%s: %s" % (program, error), file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    say(output)
    return 0


def draw_run(arguments: Sequence[str], program: str = "draw_run") -> int:
    """Do what the command ``draw_run`` is told: with --html, make a page that plays, else draw a picture.

    Returns the exit status.
    """
    if "--html" in arguments:
        return main(arguments, program)
    from ..bags.draw import main as draw    # late: it imports matplotlib
    return draw(arguments, program)


if __name__ == "__main__":
    sys.exit(main())
