"""The files of a service on a computer: written, replaced, and removed without a trace, but never what others made."""

import json

import pytest

from pioneer_control.errors import UsageError
from pioneer_control.service.installed import InstalledFiles

UNIT, RULES = "/etc/systemd/system/pioneer.service", "/etc/udev/rules.d/99-pioneer.rules"
FILES = {UNIT: "unit 1\n", RULES: "rules\n"}


def tree(root):
    """Return the text of each file below a folder."""
    return {"/" + path.relative_to(root).as_posix(): path.read_text() for path in root.rglob("*") if path.is_file()}


def put(root, path, text):
    (root / path[1:]).parent.mkdir(parents=True, exist_ok=True)
    (root / path[1:]).write_text(text)


def test_what_was_written_is_removed_without_a_trace(tmp_path):
    put(tmp_path, "/etc/udev/rules.d/70-other.rules", "x")
    before = tree(tmp_path)
    InstalledFiles("pioneer", str(tmp_path)).write(FILES)
    assert {**before, **FILES}.items() <= tree(tmp_path).items()
    assert InstalledFiles("pioneer", str(tmp_path)).remove()
    assert tree(tmp_path) == before and not (tmp_path / "etc" / "pioneer_control").exists()


def test_a_second_installation_replaces_the_first(tmp_path):
    installed = InstalledFiles("pioneer", str(tmp_path))
    installed.write(FILES)
    assert installed.foreign({UNIT: "unit 2\n"}) == []
    installed.write({UNIT: "unit 2\n"})
    found = tree(tmp_path)
    assert found[UNIT] == "unit 2\n" and RULES not in found and list(installed.listed) == [UNIT]


def test_a_file_of_somebody_else_is_told_of_and_stays(tmp_path):
    put(tmp_path, RULES, "my rules\n")
    installed = InstalledFiles("pioneer", str(tmp_path))
    assert installed.foreign(FILES) == [RULES]
    installed.write({UNIT: FILES[UNIT]})
    installed.remove()
    assert tree(tmp_path) == {RULES: "my rules\n"}


def test_the_same_file_that_somebody_copied_there_before_stays_his(tmp_path):
    put(tmp_path, RULES, FILES[RULES])
    installed = InstalledFiles("pioneer", str(tmp_path))
    assert installed.foreign(FILES) == [] and "is there already: " + RULES in installed.write(FILES)
    installed.remove()
    assert tree(tmp_path) == {RULES: FILES[RULES]}


@pytest.mark.parametrize("again", [True, False])
def test_what_somebody_changed_since_is_kept_beside(tmp_path, again):
    installed = InstalledFiles("pioneer", str(tmp_path))
    installed.write(FILES)
    put(tmp_path, UNIT, "mine\n")
    said = installed.write(FILES) if again else installed.remove()
    assert tree(tmp_path)[UNIT + ".changed"] == "mine\n" and any(".changed" in line for line in said)
    assert (UNIT in tree(tmp_path)) == again


def test_what_two_services_need_goes_with_the_last(tmp_path):
    first, second = (InstalledFiles(name, str(tmp_path)) for name in ("one", "two"))
    first.write({"/etc/systemd/system/one.service": "1", RULES: "rules\n"})
    second.write({"/etc/systemd/system/two.service": "2", RULES: "rules\n"})
    first.remove()
    assert RULES in tree(tmp_path)
    second.remove()
    assert tree(tmp_path) == {}


@pytest.mark.parametrize("text", ["", "[]", "{", '{"a": "b"}', '{"/a": 1}', json.dumps("x")])
def test_a_damaged_list_removes_nothing(tmp_path, text):
    put(tmp_path, "/etc/pioneer_control/pioneer.json", text)
    with pytest.raises(UsageError, match="damaged"):
        InstalledFiles("pioneer", str(tmp_path)).remove()


def test_nothing_installed_is_nothing_listed(tmp_path):
    assert InstalledFiles("pioneer", str(tmp_path)).listed == {} == tree(tmp_path)
