"""Runs mypy or flake8 over all code, and leaves what they found as a JUnit file.

    check_code.py mypy|flake8 REPORT

A file without a finding is a passed test, each finding a failed one. setup.cfg configures both tools. An ignore that
does not name its error, or does not say why, is a finding too; the number of all ignores is printed.
"""

import pathlib
import re
import subprocess
import sys
import tokenize
import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterator, List, NamedTuple, Sequence

ROOT = pathlib.Path(__file__).resolve().parents[1]
FINDING = re.compile(r"(?P<file>[^:]+):(?P<place>[\d:]+) (?P<text>.*)")
"""A line of either tool; what else they print (notes, sums) counts for nothing."""


class Tool(NamedTuple):
    """A checker: how to call it, what it reads, and how its ignores look."""

    arguments: List[str]
    files: List[pathlib.Path]
    ignore: str
    """Begin of the comment (a regular expression)."""
    good_ignore: str
    """The whole of it (a regular expression): one error by its name, and why."""


class Finding(NamedTuple):
    """One problem that a tool found: the file (path from the root of the repository), the line, and the message."""

    file: str
    place: str
    text: str


def python_files(*folders: str) -> List[pathlib.Path]:
    """Return the Python files in some folders."""
    return sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py"))


def tools() -> Dict[str, Tool]:
    """Return both checkers, by name."""
    nodes = sorted(path for path in (ROOT / "nodes").iterdir() if path.is_file())
    return {
        "mypy": Tool(["--warn-unused-configs", "--no-error-summary", "--hide-error-context"], python_files("src"),
                     r"#\s*type:\s*ignore", r"# type: ignore\[[a-z-]+\]  # \S.*"),
        "flake8": Tool([], python_files("src", "test", "bench", "docs") + nodes + [ROOT / "setup.py"],
                       r"#\s*noqa", r"# noqa: [A-Z]\d+  # \S.*"),
    }


def read(output: str) -> Iterator[Finding]:
    """Return the findings in the output of a tool."""
    for line in output.splitlines():
        if line.startswith("Warning: "):        # of mypy: a section of setup.cfg that is for no file
            yield Finding("setup.cfg", "0", line)
        match = FINDING.fullmatch(line)
        if match and not match.group("text").startswith("note:"):
            yield Finding(match.group("file"), match.group("place").rstrip(":"), match.group("text"))


def ignores_of(path: pathlib.Path, pattern: str) -> Iterator[Finding]:
    """Return the comments of a file in which an ignore begins."""
    with tokenize.open(str(path)) as file:
        for token in tokenize.generate_tokens(file.readline):
            match = re.search(pattern, token.string) if token.type == tokenize.COMMENT else None
            if match:
                yield Finding(path.relative_to(ROOT).as_posix(), str(token.start[0]), token.string[match.start():])


def report(files: Sequence[str], findings: Sequence[Finding], ignores: int) -> ElementTree.ElementTree:
    """Return the findings as the XML tree of a JUnit file."""
    suite = ElementTree.Element("testsuite")
    ElementTree.SubElement(ElementTree.SubElement(suite, "properties"), "property", name="ignores", value=str(ignores))
    found = {finding.file for finding in findings}
    for file in files:
        if file not in found:
            ElementTree.SubElement(suite, "testcase", classname=file, name="clean")
    for finding in findings:
        place = "%s:%s" % (finding.file, finding.place)
        case = ElementTree.SubElement(suite, "testcase", classname=place, name=finding.text)
        ElementTree.SubElement(case, "failure", message=finding.text)
    return ElementTree.ElementTree(suite)


def main(arguments: Sequence[str]) -> int:
    """Run one tool. Returns the exit status: 0 without findings, 1 with findings, 2 when the tool did not work."""
    name, target = arguments
    tool = tools()[name]
    files = [path.relative_to(ROOT).as_posix() for path in tool.files]
    done = subprocess.run([sys.executable, "-m", name] + tool.arguments + files, cwd=str(ROOT),
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)
    print(done.stdout, end="")
    findings = list(read(done.stdout))
    if done.returncode not in (0, 1) or done.returncode and not findings:
        print("%s ended with status %d" % (name, done.returncode))
        return 2
    ignored = [ignore for path in tool.files for ignore in ignores_of(path, tool.ignore)]
    findings += [Finding(file, line, "an ignore names one error and says why, not so: " + text)
                 for file, line, text in ignored if not re.fullmatch(tool.good_ignore, text)]
    report(files, findings, len(ignored)).write(target)
    print("%s: %d files, %d findings, %d ignores" % (name, len(files), len(findings), len(ignored)))
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
