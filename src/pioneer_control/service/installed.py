"""The files that a service has on this computer: written, listed with their checksums, and removed again.

The list of a service is a file of its own, ``/etc/pioneer_control/NAME.json``: the path of each file that was written,
with the SHA-256 of its contents. A file that somebody has changed since is never lost: it is renamed to
``FILE.changed``, a name that neither systemd nor udev reads.
"""

import hashlib
import json
import os
import pathlib
from typing import Dict, List, Mapping

from ..errors import UsageError
from ..whole_file import writing

LISTS = "/etc/pioneer_control"


class InstalledFiles:
    """The files of one service.

    Args:
        name: of the service.
        root: the folder that stands for ``/``.
    """

    def __init__(self, name: str, root: str = "/") -> None:
        self._root = pathlib.Path(root)
        self._list = self._at("%s/%s.json" % (LISTS, name))

    def _at(self, path: str) -> pathlib.Path:
        return self._root / path.lstrip("/")

    @property
    def listed(self) -> Dict[str, str]:
        """The checksum of each file as it was written, by its path. Empty: nothing is installed.

        Raises:
            UsageError: the list cannot be read.
        """
        return _read_list(self._list)

    def shared(self) -> Dict[str, str]:
        """What other services list: a file of theirs, such as the udev rules, stays when this one goes."""
        found: Dict[str, str] = {}
        for path in sorted(self._list.parent.glob("*.json")):
            if path != self._list:
                found.update(_read_list(path))
        return found

    def foreign(self, files: Mapping[str, str]) -> List[str]:
        """Return which of these files (text by path) are there already with another text, and are no service's."""
        known = {**self.listed, **self.shared()}
        return [path for path, text in files.items()
                if path not in known and self._at(path).exists() and self._checksum(path) != _checksum(text.encode())]

    def write(self, files: Mapping[str, str]) -> List[str]:
        """Write the files (text by path) in place of those that were installed before.

        A file that is there already with this very text, and is no service's, stays its owner's: it is not listed.

        Returns:
            what was done, in lines for people.
        """
        ours, shared, done = self.listed, self.shared(), []
        wanted = {path: _checksum(text.encode()) for path, text in files.items()}
        done += self._remove({path: checksum for path, checksum in ours.items() if path not in wanted}, shared)
        mine = {path: checksum for path, checksum in wanted.items()
                if path in ours or path in shared or self._checksum(path) != checksum}
        # The list first: what is written and not listed would never be removed.
        _write(self._list, json.dumps({**mine}, indent=2, sort_keys=True) + "\n")
        for path, checksum in wanted.items():
            if self._checksum(path) == checksum:
                done.append("is there already: " + path)
                continue
            done += self._keep_changed(path, {**shared, **ours}.get(path, ""))
            _write(self._at(path), files[path])
            done.append("wrote " + path)
        return done

    def remove(self) -> List[str]:
        """Remove what was written, and the list. Return what was done, in lines for people."""
        done = self._remove(self.listed, self.shared())
        if self._list.exists():
            self._list.unlink()
            done.append("removed %s/%s" % (LISTS, self._list.name))
        if self._list.parent.is_dir() and not any(self._list.parent.iterdir()):
            self._list.parent.rmdir()
        return done

    def _remove(self, files: Mapping[str, str], shared: Mapping[str, str]) -> List[str]:
        done = []
        for path, checksum in files.items():
            if path in shared:
                done.append("left, another service needs it: " + path)
            elif self._at(path).exists() or self._at(path).is_symlink():
                kept = self._keep_changed(path, checksum)
                if not kept:
                    self._at(path).unlink()
                done += kept or ["removed " + path]
        return done

    def _keep_changed(self, path: str, checksum: str) -> List[str]:
        """Rename a file if its contents are not those of a checksum. Return what was done."""
        if self._checksum(path) in ("", checksum):
            return []
        self._at(path).rename(self._at(path + ".changed"))
        return ["somebody has changed %s: it is %s.changed now" % (path, path)]

    def _checksum(self, path: str) -> str:
        """The checksum of a file; empty if it is not there."""
        return _checksum(self._at(path).read_bytes()) if self._at(path).is_file() else ""


def _checksum(contents: bytes) -> str:
    return hashlib.sha256(contents).hexdigest()


def _read_list(path: pathlib.Path) -> Dict[str, str]:
    if not path.exists():
        return {}
    try:
        listed = json.loads(path.read_text(encoding="utf-8"))
        if not all(isinstance(each, str) and each.startswith("/") for each in listed) or \
                not all(isinstance(each, str) for each in listed.values()):
            raise ValueError("not paths and checksums")
    except (ValueError, AttributeError, TypeError) as error:
        raise UsageError("%s is damaged (%s): remove it, and the files of the service, by hand"
                         % (path, error)) from None
    return dict(listed)


def _write(path: pathlib.Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with writing(str(path)) as part:
        pathlib.Path(part).write_text(text, encoding="utf-8")
        os.chmod(part, 0o644)
