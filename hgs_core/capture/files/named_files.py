"""Files of a capture as another machine named them: C:\\scan\\images\\a 1.JPG is images/a%201.jpg here.

A name is looked for as it is, then with what differs between machines taken away: backslashes, escapes of URLs, blanks
around it, capitals, the ending of a picture or a video, and leading folders. Of these as many are taken away as most
names need, and as few as leave a file: the longest end of the path that is there.
"""

from __future__ import annotations

import posixpath
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from hgs_core.base.wording import shown
from hgs_core.capture.footage import is_picture, is_video
from hgs_core.capture.pictures.picture import list_folder, list_folders

__all__ = ["NamedFiles", "find_named", "otherwise_named", "path_as_written", "plain_name"]

_LONGEST_NAME = 250  # bytes: file systems have 255, and an ending may be added


@dataclass(frozen=True)
class NamedFiles:
    """The found files."""

    files: tuple[Path | None, ...]  # file or folder of each name; None: missing
    otherwise: tuple[tuple[str, Path], ...] = ()  # names that are written otherwise than their files, and these


def plain_name(name: str) -> str:
    """Return a name as cameras and footage are compared by: small letters, no blanks around it, slashes, no escapes."""
    return unquote(name.replace("\\", "/")).strip().casefold()


def find_named(capture: Path, names: Sequence[str]) -> NamedFiles:
    """Return the file or folder below a capture that each name means.

    Raises:
        InputError: a folder may not be read.
    """
    folders = _Folders()
    ends = [_longest_end(folders, capture, name) for name in names]
    away = Counter(end[0] for end in ends if end is not None and end[0])
    usual = away.most_common(1)[0][0] if away else ()
    files = [end[1] if end is not None and end[0] in ((), usual) else None for end in ends]
    otherwise = [
        (name, file)
        for name, file in zip(names, files, strict=True)
        if file is not None and not _is_written(name, file.relative_to(capture).as_posix())
    ]
    return NamedFiles(tuple(files), tuple(otherwise))


def otherwise_named(file: str, named: NamedFiles) -> list[str]:
    """Say of how many names of a calibration `file` the pictures are called otherwise, with an example."""
    if not named.otherwise:
        return []
    name, found = named.otherwise[0]
    count = f"{len(named.otherwise)} of the {len(named.files)} names in {file}"
    return [f"{count} are written otherwise than the files there: {shown(name)} is taken for {found.name}"]


def path_as_written(folder: Path, name: str) -> Path | None:
    """Return the path that a name means, there or not; None: it leads outside, or no file can have such a name."""
    path = PurePosixPath(name.replace("\\", "/"))
    parts = [part for part in path.parts if part != "/"]
    if path.is_absolute() or not parts or ".." in parts:
        return None
    return (
        folder.joinpath(*parts) if max(len(part.encode(errors="replace")) for part in parts) <= _LONGEST_NAME else None
    )


def _is_written(name: str, there: str) -> bool:
    """Whether a file is called so, perhaps but for an ending that is left out."""
    plain = posixpath.normpath(name)
    return plain in (there, str(PurePosixPath(there).with_suffix("")))


def _longest_end(folders: _Folders, capture: Path, name: str) -> tuple[tuple[str, ...], Path] | None:
    """Return the folders removed from the front of a name, and the rest."""
    for spelled in _spellings(name):
        parts = tuple(part for part in posixpath.normpath(spelled).split("/") if part not in ("", "."))
        for away in range(len(parts)):
            if (file := folders.walk(capture, parts[away:])) is not None:
                return parts[:away], file
    return None


def _spellings(name: str) -> Iterator[str]:
    spelled = dict.fromkeys((name, name.replace("\\", "/"), unquote(name.replace("\\", "/"))))
    yield from spelled
    yield from (stripped for one in spelled if (stripped := one.strip()) != one)


class _Folders:
    """The contents of folders, each listed once."""

    def __init__(self) -> None:
        self._files: dict[Path, dict[str, str]] = {}
        self._folders: dict[Path, dict[str, str]] = {}
        self._stems: dict[Path, dict[str, list[str]]] = {}

    def walk(self, folder: Path, parts: Sequence[str]) -> Path | None:
        """Return the file or folder at the end of `parts`; None if there is none, or more than one could be meant."""
        for part in parts[:-1]:
            self._list(folder)
            if (found := _in(self._folders[folder], part)) is None:
                return None
            folder = folder / found
        self._list(folder)
        last = _in(self._files[folder], parts[-1]) or _in(self._folders[folder], parts[-1])
        if last is None:
            known = is_picture(parts[-1]) or is_video(parts[-1])
            stem = PurePosixPath(parts[-1]).stem if known else parts[-1]
            alike = self._stems[folder].get(stem.casefold(), [])
            last = alike[0] if len(alike) == 1 else None
        return None if last is None else folder / last

    def _list(self, folder: Path) -> None:
        if folder in self._files:
            return
        names = list(list_folder(folder))
        self._files[folder] = _by_small_letters(names)
        self._folders[folder] = _by_small_letters(list_folders(folder))
        stems: dict[str, list[str]] = {}
        for name in names:
            if is_picture(name) or is_video(name):
                stems.setdefault(PurePosixPath(name).stem.casefold(), []).append(name)
        self._stems[folder] = stems


def _by_small_letters(names: Sequence[str]) -> dict[str, str]:
    """Return names by themselves, and by their small letters where only one has these."""
    alike = Counter(name.casefold() for name in names)
    return {name.casefold(): name for name in names if alike[name.casefold()] == 1} | {name: name for name in names}


def _in(names: dict[str, str], name: str) -> str | None:
    return names.get(name) or names.get(name.casefold())
