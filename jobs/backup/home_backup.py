"""A copy of a home that runs, from which it can be restored: `jobs.backup.backup_restore`.

```
backup.json        what was copied, of which home, by which version
jobs.sqlite        the database, as it was at one moment; not where it is Postgres
home-id            which home and database belong together
store/             published scenes: manifests, and the chunks that they name; not where it is an object store
runs/, uploads/, captures/      as in the home
SHA256SUMS         of all of these, as `sha256sum --check` reads it; written last
```

The database comes first. What it knows is on the disk by then or later, and stages go on from whatever there is.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import shutil
import sqlite3
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

import sqlalchemy as sa

from hgs_core.base.errors import InputError
from hgs_core.base.version import software_version
from jobs.artifacts.artifact_store import open_store
from jobs.artifacts.store_check import chunks_of
from jobs.home.home import Home
from jobs.home.home_identity import FILE as HOME_ID
from jobs.home.object_store import is_folder

__all__ = ["DATABASE", "DESCRIPTION", "FOLDERS", "STORE", "SUMS", "Backup", "back_up", "database_file", "store_folder"]

FORMAT = 1
DESCRIPTION, SUMS = "backup.json", "SHA256SUMS"
DATABASE, STORE = "jobs.sqlite", "store"
FOLDERS = ("runs", "uploads", "captures")
_BLOCK = 1 << 20
# Locks, and what belongs to one process alone or is on its way to another name.
_LEFT_OUT = re.compile(r"\..*|run\.lock|run\.lease\..*")


@dataclass(frozen=True)
class Backup:
    """The extent of a backup."""

    format: int
    software: str
    made: float  # seconds since the epoch
    home: str  # its folder, which absolute paths in the database begin with
    home_id: str
    database: str  # "sqlite", or what else is to be copied by its own tools
    store: str  # "folder", or the URL of what is to be kept by its own means
    files: int
    bytes: int
    holes: tuple[str, ...]  # chunks that are missing or damaged in the home itself


def database_file(home: Home) -> Path | None:
    """Return the file of the home's database; None where it is a server."""
    url = sa.make_url(home.database_url)
    return Path(str(url.database)) if url.get_backend_name() == "sqlite" else None


def store_folder(home: Home) -> Path | None:
    """Return the folder of the home's store; None where it is an object store."""
    return Path(url2pathname(urlsplit(home.store_url).path)) if is_folder(home.store_url) else None


def back_up(home: Home, target: Path) -> Backup:
    """Copy a home, in use or not, into a new folder, which appears whole or not at all.

    Raises:
        InputError: there is no home, or something lies at `target`.
        OSError: something cannot be read, or not be written.
    """
    database = database_file(home)
    if not (home.folder / HOME_ID).is_file() or (database is not None and not database.is_file()):
        raise InputError(f"HGS_HOME {home.folder}", "holds no home", "give the HGS_HOME of the server")
    if target.exists() and (not target.is_dir() or any(target.iterdir())):
        raise InputError(target, "is there already", "give a folder that is not")
    if target.resolve().is_relative_to(home.folder):
        raise InputError(target, f"lies in the home {home.folder}", "give a folder outside of it")
    part = target.with_name(f".{target.name}.part")
    shutil.rmtree(part, ignore_errors=True)  # remains of an interrupted backup
    part.mkdir(parents=True)
    try:
        made = _fill(home, database, part)
        if target.exists():
            target.rmdir()
        part.rename(target)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise
    return made


def _fill(home: Home, database: Path | None, part: Path) -> Backup:
    made = time.time()
    sums = _Sums(part)
    if database is not None:
        _copy_database(database, part / DATABASE)
        sums.add(part / DATABASE)
    sums.copy(home.folder / HOME_ID, part / HOME_ID)
    holes = () if store_folder(home) is None else tuple(_copy_store(home, part / STORE, sums))
    for folder in FOLDERS:
        _copy_folder(home.folder / folder, part / folder, sums)
    kind = "sqlite" if database is not None else sa.make_url(home.database_url).get_backend_name()
    backup = Backup(
        FORMAT,
        software_version(),
        made,
        str(home.folder),
        (part / HOME_ID).read_text().strip(),
        kind,
        "folder" if store_folder(home) is not None else home.store_url,
        len(sums.lines),
        sums.bytes,
        holes,
    )
    (part / DESCRIPTION).write_text(json.dumps(asdict(backup), indent=1) + "\n")
    sums.add(part / DESCRIPTION)
    (part / SUMS).write_text("".join(f"{line}\n" for line in sums.lines), encoding="utf-8", errors="surrogateescape")
    return backup


class _Sums:
    """The digests of the files copied to a folder."""

    def __init__(self, root: Path) -> None:
        self._root = root
        self.lines: list[str] = []
        self.bytes = 0

    def copy(self, source: Path, target: Path) -> str:
        """Copy a file with its date, as it is at this moment, and return its digest."""
        digest = hashlib.sha256()
        with source.open("rb") as reading, target.open("xb") as writing:
            status = os.fstat(reading.fileno())
            while block := reading.read(_BLOCK):
                digest.update(block)
                writing.write(block)
        os.utime(target, ns=(status.st_atime_ns, status.st_mtime_ns))
        self._note(target, digest.hexdigest())
        return digest.hexdigest()

    def add(self, file: Path) -> None:
        """Take in a file that is there."""
        with file.open("rb") as reading:
            self._note(file, hashlib.file_digest(reading, "sha256").hexdigest())

    def _note(self, file: Path, digest: str) -> None:
        name = file.relative_to(self._root).as_posix()
        escaped = name.replace("\\", "\\\\").replace("\n", "\\n")  # the escapes of GNU coreutils
        self.lines.append(f"{'' if escaped == name else chr(92)}{digest}  {escaped}")
        self.bytes += file.stat().st_size


def _copy_database(source: Path, target: Path) -> None:
    with (
        contextlib.closing(sqlite3.connect(f"{source.resolve().as_uri()}?mode=ro", uri=True)) as live,
        contextlib.closing(sqlite3.connect(target)) as copy,
    ):
        live.backup(copy)
        copy.execute("PRAGMA journal_mode=DELETE")  # one file, whatever the original has


def _copy_store(home: Home, target: Path, sums: _Sums) -> Iterator[str]:
    """Copy the scenes, and yield the chunks that are missing or damaged; nothing is collected meanwhile."""
    store, folder = open_store(home), store_folder(home)
    assert folder is not None
    with store.lock.publishing(lambda: None):
        _copy_folder(folder / "scenes", target / "scenes", sums)
        names: dict[str, None] = {}
        for manifest in sorted(target.glob("scenes/*/manifest.json")):
            with contextlib.suppress(InputError):  # hgs gc --check names it
                names.update(dict.fromkeys(chunks_of(manifest.read_bytes())))
        (target / "chunks").mkdir(parents=True, exist_ok=True)
        for name in names:
            try:
                right = sums.copy(folder / "chunks" / name, target / "chunks" / name) == name
            except FileNotFoundError:
                right = False
            if not right:
                yield name


def _copy_folder(source: Path, target: Path, sums: _Sums) -> None:
    """Copy a folder as it is now: files that are replaced meanwhile are the old or the new one, others may be gone."""
    try:
        entries = sorted(os.scandir(source), key=lambda entry: entry.name)
    except FileNotFoundError:
        return
    target.mkdir(parents=True, exist_ok=True)
    for entry in entries:
        if _LEFT_OUT.fullmatch(entry.name):
            continue
        there = target / entry.name
        with contextlib.suppress(FileNotFoundError):
            if entry.is_dir():
                _copy_folder(Path(entry.path), there, sums)
            elif entry.is_file():  # links are followed: their targets may not be where this is restored
                sums.copy(Path(entry.path), there)
