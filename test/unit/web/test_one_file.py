"""The page as one file: modules in their order, without a name twice, and nothing that ends the file's elements."""

import json
import re

import pytest

from pioneer_control.errors import UsageError
from pioneer_control.web.one_file import PAGE, join_modules, names_of, one_file, order_of

MODULES = {
    "main.js": 'import {a, f} from "./one.js";\nimport {g} from "./two.js";\n\nlet x = a, y = f(1, 2);\n',
    "one.js": 'import {g} from "./two.js";\n\nexport const a = 1, b = {c: 2, d: [3, 4]};\n\n'
              "export function f() {\n\tconst a = g;\n}\n",
    "two.js": "export async function g() {}\n\nexport class H {}\nconst i = 3;\n",
    "lonely.js": "export const j = 1;\n",
}


def page_modules():
    return {path.name: path.read_text(encoding="utf-8") for path in PAGE.glob("*.js")}


def test_a_module_comes_behind_those_that_it_imports():
    assert order_of(MODULES) == ["two.js", "one.js", "main.js"]


def test_modules_become_one_script():
    script = join_modules(MODULES)
    assert "import" not in script and "export" not in script and "lonely" not in script
    assert script.index("class H") < script.index("const a = 1") < script.index("let x")


def test_names_are_found():
    assert names_of(MODULES["one.js"]) == ["f", "a", "b"]
    assert names_of(MODULES["main.js"]) == ["x", "y"]
    assert names_of('const {k} = 1, t = "a, u = 2", v = (w = 1) => 2, z = x === y;\n') == ["t", "v", "z"]


def test_a_module_that_is_loaded_late_is_in_the_script_with_what_it_exports():
    late = dict(MODULES, **{"main.js": 'import {a} from "./one.js";\nimport("./lonely.js").then(({j}) => j + a);\n'})
    assert order_of(late)[-2:] == ["lonely.js", "main.js"]
    script = join_modules(late)
    assert "import" not in script and "Promise.resolve({j}).then(({j}) => j + a)" in script
    assert script.index("const j = 1") < script.index("Promise")
    with pytest.raises(UsageError, match="not there"):
        join_modules(dict(late, **{"main.js": 'import("./gone.js");\n'}))


@pytest.mark.parametrize("name, text, words", [
    ("two.js", 'import {x} from "./main.js";\nexport function g() {}\n', "circle"),
    ("two.js", "export function g() {}\nconst a = 2;\n", "a is a name in two.js and in one.js"),
    ("two.js", "export function g() {}\nexport default 3;\n", "export default"),
    ("two.js", 'export function g() {}\nimport * as all from "./one.js";\n', r"import \* as"),
    ("two.js", 'export function g() { return import("./one.js"); }\n', "circle"),
    ("two.js", "export function g() { return import(name); }\n", r"import\("),
    ("two.js", "function g() {}\n", "does not export"),
    ("main.js", 'import {k} from "./gone.js";\n', "not there"),
])
def test_what_cannot_be_joined_is_refused(name, text, words):
    with pytest.raises(UsageError, match=words):
        join_modules(dict(MODULES, **{name: text}))


def test_the_pages_modules_can_be_joined():
    """No name is used twice in all of them, and each is needed."""
    assert sorted(order_of(page_modules())) == sorted(page_modules())
    join_modules(page_modules())


def test_a_name_that_is_used_twice_in_the_page_is_seen():
    modules = page_modules()
    modules["view.js"] += "\nfunction decodeFrames() {}\n"
    with pytest.raises(UsageError, match="decodeFrames"):
        join_modules(modules)


def test_the_recording_cannot_end_its_element():
    recording = {"name": "</script><b>&", "messages": []}
    html = one_file(recording)
    inside = re.search(r'<script type="application/json" id="recording">(.*?)</script>', html, re.DOTALL).group(1)
    assert json.loads(inside) == recording
    assert "<b>&" not in html
    assert 'src="' not in html and "href=\"style" not in html


def test_a_page_without_its_script_is_refused(tmp_path):
    (tmp_path / "index.html").write_text("<p>")
    with pytest.raises(UsageError, match="style.css"):
        one_file({}, tmp_path)


MOST, MOST_LATE = 60000, 12000
"""Bytes of all files that the page loads at once, as they are, with their comments; and of those that it loads only
when a robot has navigation.
"""
LATE = {"navigation.js"}


def test_all_files_of_the_page_together_are_small():
    sizes = {path.name: path.stat().st_size for path in PAGE.iterdir()}
    assert sum(size for name, size in sizes.items() if name not in LATE) <= MOST, sizes
    assert sum(sizes[name] for name in LATE) <= MOST_LATE, sizes


def test_what_the_page_loads_late_it_does_not_load_at_once():
    modules = page_modules()
    for name in LATE:
        assert not [each for each in modules if 'from "./%s"' % name in modules[each]]
