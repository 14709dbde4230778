"""`test/check_code.py` counts the findings of mypy and flake8, and each ignore that does not name one error and give a
reason.
"""

import pathlib
import sys
import xml.etree.ElementTree as ElementTree

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import check_code


def test_findings_of_mypy_are_read_and_its_notes_are_not():
    output = 'src/a.py:12: error: Name "x" is not defined  [name-defined]\nsrc/a.py:12: note: Hint\nSuccess: fine\n'
    (finding,) = check_code.read(output)
    assert finding == ("src/a.py", "12", 'error: Name "x" is not defined  [name-defined]')


def test_findings_of_flake8_are_read():
    (finding,) = check_code.read("src/a.py:12:121: E501 line too long\n")
    assert finding == ("src/a.py", "12:121", "E501 line too long")


def test_a_section_of_the_configuration_that_is_for_no_file_is_a_finding():
    (finding,) = check_code.read("Warning: unused section(s) in setup.cfg: [mypy-rospi.*]\n")
    assert finding.file == "setup.cfg" and "rospi" in finding.text


class Tree:
    """A repository of one file, and a stand-in for a tool."""

    def __init__(self, folder, monkeypatch):
        self.folder, self._monkeypatch = folder, monkeypatch
        monkeypatch.setattr(check_code, "ROOT", folder)

    def check(self, text, prints="", status=0, name="mypy"):
        """Check the file with a tool that prints this. Returns the exit status, the number of passes, and the texts of
        the findings.
        """
        (self.folder / "code.py").write_text(text)
        (self.folder / "stand_in.py").write_text("import sys; print(%r); sys.exit(%d)" % (prints, status))
        real = check_code.tools
        (self.folder / "nodes").mkdir(exist_ok=True)
        tool = real()[name]._replace(arguments=[], files=[self.folder / "code.py"])
        self._monkeypatch.setattr(check_code, "tools", lambda: {"stand_in": tool})
        self._monkeypatch.setenv("PYTHONPATH", str(self.folder))
        code = check_code.main(["stand_in", str(self.folder / "report.xml")])
        self._monkeypatch.setattr(check_code, "tools", real)
        cases = list(ElementTree.parse(self.folder / "report.xml").iter("testcase")) if code in (0, 1) else []
        bad = [case for case in cases if case.find("failure") is not None]
        return code, len(cases) - len(bad), [case.get("name") for case in bad]


@pytest.fixture
def tree(tmp_path, monkeypatch):
    return Tree(tmp_path, monkeypatch)


def test_clean_code_passes(tree):
    assert tree.check("x = 1\n") == (0, 1, [])


def test_a_finding_fails(tree):
    assert tree.check("x = y\n", "code.py:1: error: no y  [name-defined]", 1) == (1, 0, ["error: no y  [name-defined]"])


def test_a_tool_that_breaks_down_fails_without_a_report(tree):
    assert tree.check("x = 1\n", "INTERNAL ERROR", 2)[0] == 2
    assert tree.check("x = 1\n", "No module named mypy", 1)[0] == 2


@pytest.mark.parametrize("name, comment, good", [
    ("mypy", "# type: ignore[misc]  # rospy has no types", True),
    ("mypy", "# type: ignore", False),
    ("mypy", "# type: ignore[misc]", False),
    ("mypy", "#type:ignore", False),
    ("flake8", "# noqa: E731  # read once", True),
    ("flake8", "# noqa", False),
    ("flake8", "# noqa: E731", False),
    ("flake8", "# noqa: E731: why", False),
])
def test_an_ignore_names_its_error_and_says_why(tree, name, comment, good):
    code, passed, bad = tree.check("x = 1  %s\n" % comment, name=name)
    assert (code, passed) == ((0, 1) if good else (1, 0))
    assert bad == ([] if good else ["an ignore names one error and says why, not so: " + comment])
    assert 'name="ignores" value="1"' in (tree.folder / "report.xml").read_text()


def test_an_ignore_in_a_string_is_none(tree):
    assert tree.check("x = '# noqa'\n", name="flake8") == (0, 1, [])
