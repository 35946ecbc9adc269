"""Folders of captures that the API may read."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from hgs_core.base.errors import InputError
from server.http.problem_error import ProblemError

__all__ = ["CaptureFolders"]

SETTING = "HGS_CAPTURES"

_MOST_ENTRIES = 500_000  # files and folders checked for links, per capture
_DEEPEST = 6  # levels below a capture; its readers use three, and a few deeper ones by name


@dataclass(frozen=True)
class CaptureFolders:
    """Absolute folders without symbolic links, in the lookup order of relative paths."""

    folders: tuple[Path, ...]
    uploaded: Path | None = None  # folder of uploaded captures, searched last

    @classmethod
    def configured(cls, home: Path, given: str = "", environment: Mapping[str, str] = os.environ) -> Self:
        """Return the folders `given` as a path list, or those of `HGS_CAPTURES`, or the defaults.

        The defaults are captures/ in the service's home, and samples/ of the repository when run from a checkout.
        """
        listed = [Path(part) for part in (given or environment.get(SETTING, "")).split(os.pathsep) if part]
        if not listed:
            samples = Path(__file__).resolve().parents[2] / "samples"
            listed = [home / "captures"] + ([samples] if samples.is_dir() else [])
        return cls(tuple(folder.expanduser().resolve() for folder in listed))

    @classmethod
    def from_json(cls, fields: Mapping[str, Any]) -> Self:
        """Return the folders of a reader's request."""
        uploaded = fields["uploaded"]
        return cls(tuple(map(Path, fields["folders"])), uploaded and Path(uploaded))

    def to_json(self) -> dict[str, Any]:
        """Return the plain form, for a reader."""
        return {"folders": [str(one) for one in self.folders], "uploaded": self.uploaded and str(self.uploaded)}

    @property
    def readable(self) -> tuple[Path, ...]:
        """All folders that may contain captures."""
        return self.folders if self.uploaded is None else (*self.folders, self.uploaded)

    def allows(self, path: Path) -> bool:
        """Return whether a path without links lies in one of the folders."""
        return any(path.is_relative_to(folder) for folder in self.readable)

    def shown(self, text: str) -> str:
        """Return a line for clients, with captures named relative to the server's folders."""
        for folder in sorted(map(str, self.readable), key=len, reverse=True):
            if folder != "/":
                text = re.sub(rf"(?<![\w.~-]){re.escape(folder)}(?:/|(?![\w.-]))", _name_of(folder), text)
        return text

    def locate(self, capture: str) -> Path:
        """Return the absolute path of a capture named by a client.

        Raises:
            ProblemError: 403, the path lies outside the folders, by `..` or a symbolic link too.
            InputError: there is nothing at the path.
        """
        try:
            candidates = [(folder / capture).resolve() for folder in self.readable]
            inside = [path for path in candidates if self.allows(path)]
            found = next((path for path in inside if path.is_dir()), None)
        except (OSError, RuntimeError, ValueError) as error:  # too long, a loop of links, not valid text
            raise InputError.of_field("capture", f"{capture[:80]!r} is not a path") from error
        if not inside:
            raise _outside("capture", capture)
        if found is None:
            raise InputError.of_field("capture", f"{capture!r} is not a folder", "give the folder of a capture")
        return found

    def locate_file(self, field: str, file: str, capture: Path) -> Path:
        """Return the absolute path of a file named by a client in a field of the request, searched in `capture` first.

        Raises:
            ProblemError: 403, the path lies outside the folders, by `..` or a symbolic link too.
            InputError: there is no file at the path.
        """
        try:
            inside = [path for folder in (capture, *self.readable) if self.allows(path := (folder / file).resolve())]
            found = next((path for path in inside if path.is_file()), None)
        except (OSError, RuntimeError, ValueError) as error:
            raise InputError.of_field(field, f"{file[:80]!r} is not a path") from error
        if not inside:
            raise _outside(field, file)
        if found is None:
            raise InputError.of_field(
                field, f"there is no file {file!r}", "give its path in the capture, or its absolute path"
            )
        return found

    def require_inner_links(self, capture: Path) -> None:
        """Reject links to the outside: a capture's author must not read other files of the server through them.

        Raises:
            ProblemError: 403, there is such a link.
            InputError: there are too many files.
        """
        waiting, looked_at = [(capture, 0)], 0
        while waiting:
            folder, depth = waiting.pop()
            for entry in _entries(folder):
                looked_at += 1
                if looked_at > _MOST_ENTRIES:
                    raise InputError.of_field(
                        "capture", f"{capture.name!r} has more than {_MOST_ENTRIES:,} files and folders"
                    )
                if entry.is_symlink() and not self.allows(Path(os.path.realpath(entry.path))):
                    link = Path(entry.path).relative_to(capture)
                    raise ProblemError(
                        403,
                        "capture-outside",
                        f"capture {capture.name!r}: {str(link)!r} is a link that leads outside the folders that the "
                        f"server may read; put the file itself there, or add its folder to {SETTING}",
                        field="capture",
                    )
                if entry.is_dir() and depth < _DEEPEST:
                    waiting.append((Path(entry.path), depth + 1))


def _name_of(folder: str) -> Callable[[re.Match[str]], str]:
    return lambda found: "" if found[0].endswith("/") else Path(folder).name


def _outside(field: str, path: str) -> ProblemError:
    detail = f"{field} {path!r}: lies outside the folders the server may read; add its folder to {SETTING}"
    return ProblemError(403, "capture-outside", detail, field=field)


def _entries(folder: Path) -> list[os.DirEntry[str]]:
    try:
        with os.scandir(folder) as entries:
            return list(entries)
    except OSError:
        return []  # opening the capture reports the reason
