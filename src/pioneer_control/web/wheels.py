"""What a laptop needs for programs, as wheels that the server hands out: pip installs them without the internet.

``python3 -m pip install --no-index --find-links http://HOST:PORT/packages/ pioneer_control`` takes three: the rooms of
this package that drive a robot, and the two libraries that they need, in pure Python, as they are installed here.
"""

import base64
import hashlib
import html
import importlib.metadata
import importlib.util
import io
import pathlib
import re
import zipfile
from typing import Dict, Iterable, List, Mapping, NamedTuple, Optional

from .. import __version__
from .guard import PageFile

FOLDER = pathlib.Path(__file__).resolve().parents[1]
ROOMS = ("p2os", "robots", "client")
FILES = ("__init__.py", "errors.py", "parameters.py", "port_url.py", "interrupt.py", "wire_fields.py",
         "wire_words.py")
NEEDED = ("PyYAML>=5.1", "websocket-client>=1.0")
ENDINGS = (".py", ".yaml")
DATE = (2020, 1, 1, 0, 0, 0)    # of all files: the same sources give the same wheel


class Library(NamedTuple):
    """A library in pure Python that is installed here: its name for pip, its package, and where Debian has its licence.
    """

    name: str
    package: str
    licence: str


LIBRARIES = (Library("PyYAML", "yaml", "/usr/share/doc/python3-yaml/copyright"),
             Library("websocket-client", "websocket", "/usr/share/doc/python3-websocket/copyright"))


class Wheel(NamedTuple):
    """A wheel: the name of its file, and its bytes."""

    name: str
    contents: bytes

    @property
    def project(self) -> str:
        """The name of its project, as an index has it (PEP 503)."""
        return re.sub("[-_.]+", "-", self.name.split("-")[0]).lower()


def make_wheel(name: str, version: str, files: Mapping[str, bytes], summary: str, needed: Iterable[str] = (),
               licence: bytes = b"") -> Wheel:
    """Return a wheel of pure Python.

    Args:
        name, version: of the project.
        files: the contents of all files by their paths.
        summary: what it is, in a line.
        needed: other projects that it needs, as pip takes them.
        licence: the text of its licence.
    """
    plain = re.sub("[-_.]+", "_", name)
    info = "%s-%s.dist-info" % (plain, version)
    metadata = ["Metadata-Version: 2.1", "Name: %s" % name, "Version: %s" % version, "Summary: %s" % summary,
                "Requires-Python: >=3.8", *("Requires-Dist: %s" % each for each in needed), ""]
    parts = dict(files)
    parts[info + "/METADATA"] = "\n".join(metadata).encode()
    parts[info + "/WHEEL"] = (b"Wheel-Version: 1.0\nGenerator: pioneer_control\nRoot-Is-Purelib: true\n"
                              b"Tag: py3-none-any\n")
    if licence:
        parts[info + "/LICENSE"] = licence
    record = ["%s,sha256=%s,%d" % (path, _digest(data), len(data)) for path, data in sorted(parts.items())]
    parts[info + "/RECORD"] = "\n".join([*record, info + "/RECORD,,", ""]).encode()
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in parts.items():
            entry = zipfile.ZipInfo(path, DATE)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, data)
    return Wheel("%s-%s-py3-none-any.whl" % (plain, version), buffer.getvalue())


def _digest(data: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def own_wheel() -> Wheel:
    """Return the wheel of what a program needs from this package: no ROS, no simulated robot, no page."""
    paths = [FOLDER / name for name in FILES]
    paths += [path for room in ROOMS for path in sorted((FOLDER / room).rglob("*")) if path.suffix in ENDINGS]
    files = {path.relative_to(FOLDER.parent).as_posix(): path.read_bytes() for path in paths}
    return make_wheel("pioneer_control", __version__, files, "Drive Pioneer robots from Python", NEEDED)


def library_wheel(library: Library) -> Optional[Wheel]:
    """Return the wheel of a library as it is installed here, without its compiled parts; None if it is not."""
    found = importlib.util.find_spec(library.package)
    if found is None or not found.submodule_search_locations:
        return None
    try:
        version = importlib.metadata.version(library.name)
    except importlib.metadata.PackageNotFoundError:
        return None
    folder = pathlib.Path(list(found.submodule_search_locations)[0])
    files = {path.relative_to(folder.parent).as_posix(): path.read_bytes() for path in sorted(folder.rglob("*.py"))
             if "tests" not in path.relative_to(folder).parts}
    licence = pathlib.Path(library.licence)
    return make_wheel(library.name, version, files, "%s, its pure Python part" % library.name,
                      licence=licence.read_bytes() if licence.is_file() else b"")


def all_wheels() -> List[Wheel]:
    """Return the wheel of this package, and those of the libraries that are installed here."""
    return [own_wheel(), *(wheel for wheel in map(library_wheel, LIBRARIES) if wheel is not None)]


def package_files(wheels: Iterable[Wheel]) -> Dict[str, PageFile]:
    """Return what the server hands out of wheels, by paths: the wheels, and an index of them (PEP 503)."""
    wheels, files = list(wheels), {}
    for wheel in wheels:
        for folder in ("/", "/packages/", "/packages/%s/" % wheel.project):
            files[folder + wheel.name] = PageFile("application/zip", wheel.contents)
    for path, listed in [("/packages/", wheels)] + [("/packages/%s/" % wheel.project, [wheel]) for wheel in wheels]:
        links = ['<a href="%s">%s</a><br>' % ((html.escape(wheel.name),) * 2) for wheel in listed]
        files[path] = PageFile("text/html; charset=utf-8", "\n".join(
            ["<!doctype html>", "<title>packages</title>", *links, ""]).encode())
    return files
