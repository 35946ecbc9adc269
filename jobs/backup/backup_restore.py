"""A home made of a backup (`jobs.backup.home_backup`), on this machine or another, at the same path or another."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path

import sqlalchemy as sa

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from jobs.backup.home_backup import DATABASE, DESCRIPTION, FORMAT, STORE, SUMS, Backup, database_file, store_folder
from jobs.home.database import create_engine
from jobs.home.home import Home
from jobs.records.job_schema import job_rows
from jobs.runs.capture_places import SPEC

__all__ = ["read_backup", "restore"]

_PART = ".restoring"


def restore(source: Path, home: Home) -> Backup:
    """Make a home of a backup, after all of its files have been compared with their SHA-256.

    Jobs whose captures lay in the old home find them in the new one. The database of a home with Postgres must have
    been restored before, and be the one of `home`.

    Raises:
        InputError: this is no backup, or a damaged one; or something lies where the home shall be; or the home keeps
            its database or its store elsewhere than the backup's.
        OSError: something cannot be read, or not be written.
    """
    backup = read_backup(source)
    _require_alike(backup, home)
    _require_empty(home)
    names = list(_checked(source))
    part = home.folder / _PART
    shutil.rmtree(part, ignore_errors=True)  # remains of an interrupted restoration
    part.mkdir(parents=True)
    try:
        for name in names:
            (part / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source / name, part / name)
        _move_captures(backup, home, part)
        for entry in sorted(
            part.iterdir(), key=lambda entry: entry.name == DATABASE
        ):  # the database last: it makes the folder a home
            target = _target(home, entry.name)
            if entry.name == STORE and target.is_dir():
                target.rmdir()
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(entry, target)
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return backup


def read_backup(source: Path) -> Backup:
    """Return a backup's description of itself.

    Raises:
        InputError: it is none, or of a later version.
    """
    file = source / DESCRIPTION
    try:
        told = json.loads(file.read_bytes())
        if told["format"] != FORMAT:
            raise InputError(file, f"is of the format {told['format']!r}", f"restore it with HGS {told['software']}")
        return Backup(**{field.name: told[field.name] for field in fields(Backup)})
    except FileNotFoundError as error:
        raise InputError(source, f"is no backup: it has no {DESCRIPTION}", "give a folder of hgs backup") from error
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError(file, f"is damaged ({error!r})", "use another backup") from error


def _require_alike(backup: Backup, home: Home) -> None:
    if (backup.database == "sqlite") != (database_file(home) is not None):
        problem = f"is of a home whose database is {backup.database}, and HGS_DATABASE_URL names another kind"
        cure = (
            "leave it out"
            if backup.database == "sqlite"
            else "restore the database with pg_restore or psql, and name it"
        )
        raise InputError("the backup", problem, cure)
    if (backup.store == "folder") != (store_folder(home) is not None):
        problem = "is of a home whose store is " + ("a folder" if backup.store == "folder" else backup.store)
        cure = "leave out HGS_STORE_URL" if backup.store == "folder" else f"give HGS_STORE_URL={backup.store}"
        raise InputError("the backup", problem, cure)


def _require_empty(home: Home) -> None:
    database, store = database_file(home), store_folder(home)
    for folder in (home.folder, store):
        if folder is not None and folder.exists():
            found = [entry.name for entry in folder.iterdir() if entry.name != _PART] if folder.is_dir() else ["a file"]
            if found:
                cure = "give an HGS_HOME that is not there yet, or move away what is there"
                raise InputError(folder, f"is not empty ({sorted(found)[0]})", cure)
    if database is not None and database.exists():
        raise InputError(database, "is there already", "move it away, or give another HGS_DATABASE_URL")


def _target(home: Home, name: str) -> Path:
    own = {DATABASE: database_file(home), STORE: store_folder(home)}.get(name)
    return home.folder / name if own is None else own


def _checked(source: Path) -> Iterator[str]:
    """Yield the files of a backup after comparing all of them.

    Raises:
        InputError: one is missing or another than it was, with how many are.
    """
    try:
        lines = (source / SUMS).read_text(encoding="utf-8", errors="surrogateescape").split("\n")[:-1]
    except OSError as error:
        raise InputError(source / SUMS, f"cannot be read ({error.strerror})", "use another backup") from error
    names, bad = [], []
    for line in lines:
        digest, _, name = line.removeprefix("\\").partition("  ")
        if line.startswith("\\"):
            name = name.replace("\\\\", "\0").replace("\\n", "\n").replace("\0", "\\")
        file = source / name
        if not file.resolve().is_relative_to(source.resolve()):
            raise InputError(source / SUMS, f"names {name[:80]!r}, which lies outside", "use another backup")
        if file.is_file() and _digest(file) == digest:
            names.append(name)
        else:
            bad.append(name)
    if bad:
        problem = f"is missing or damaged, and so are {len(bad) - 1} others" if bad[1:] else "is missing or damaged"
        raise InputError(source / bad[0], problem, "nothing was restored; use another backup, or copy this one again")
    yield from names


def _digest(file: Path) -> str:
    with file.open("rb") as reading:
        return hashlib.file_digest(reading, "sha256").hexdigest()


def _move_captures(backup: Backup, home: Home, part: Path) -> None:
    """Write the paths of captures anew that lay in the old home."""
    old, new = f"{backup.home}/", f"{home.folder}/"
    if old == new:
        return

    def moved(path: str) -> str:
        return new + path.removeprefix(old) if path.startswith(old) else path

    for spec in part.glob(f"runs/*/{SPEC}"):
        told = json.loads(spec.read_bytes())
        there = {name: moved(value) if isinstance(value, str) else value for name, value in told.items()}
        write_bytes(spec, json.dumps(there, indent=1).encode())
    copy = part / DATABASE
    engine = sa.create_engine(f"sqlite:///{copy}") if copy.exists() else create_engine(home)
    try:
        with engine.begin() as connection:
            for row in connection.execute(sa.select(job_rows.c.id, job_rows.c.capture, job_rows.c.audio)).all():
                values = {"capture": moved(row.capture), "audio": moved(row.audio)}
                if values != {"capture": row.capture, "audio": row.audio}:
                    connection.execute(sa.update(job_rows).where(job_rows.c.id == row.id).values(values))
    finally:
        engine.dispose()
