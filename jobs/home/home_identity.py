"""Whether the home's folder is the one that the database belongs to.

A machine on which the shared folder is not mounted sees an empty folder in its place. A file in the home holds a random
id that stands in the database too, so that a process can tell before it takes or makes jobs there. Where machines share
no folder, the store holds the id, and a machine whose store has the right one gets a home of its own.
"""

from __future__ import annotations

import uuid
from dataclasses import dataclass
from pathlib import Path

import obstore
import sqlalchemy as sa

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from jobs.home.home import Home
from jobs.home.object_store import open_object_store, require_conditional_puts

__all__ = ["HomeIdentity", "identify_home"]

FILE = "home-id"

_metadata = sa.MetaData()
_home = sa.Table("hgs_home", _metadata, sa.Column("id", sa.String(36), primary_key=True))  # one row


@dataclass(frozen=True)
class HomeIdentity:
    """The id that the folder of the home must hold."""

    folder: Path
    id: str

    def mismatch(self) -> InputError | None:
        """Return the fault of the folder as it is now, or None."""
        file = self.folder / FILE
        cure = f"mount the shared folder there, or, if it was replaced on purpose, write {self.id} into {file}"
        try:
            found = file.read_text().strip()
        except FileNotFoundError:
            return InputError(f"HGS_HOME {self.folder}", f"is not the home of this database: it has no {FILE}", cure)
        except OSError as error:
            return InputError(f"HGS_HOME {self.folder}", f"{FILE} cannot be read ({error.strerror})", cure)
        if found != self.id:
            return InputError(f"HGS_HOME {self.folder}", f"is the home of another database ({FILE}: {found})", cure)
        return None


def identify_home(home: Home, engine: sa.Engine) -> HomeIdentity:
    """Return the identity of the home, made the first time; one process at a time.

    Raises:
        InputError: the home's folder is not the one that this database belongs to, or cannot be read; or the store is
            not.
    """
    _metadata.create_all(engine)
    with engine.begin() as connection:
        known = connection.execute(sa.select(_home.c.id)).scalar_one_or_none()
        if known is None:
            known = _read_or_make_in_store(home) if home.runs_in_store else _read_or_make(home.folder)
            connection.execute(sa.insert(_home).values(id=known))
    if home.runs_in_store and not (home.folder / FILE).exists():
        require_conditional_puts(home.store_url)
        _require_store(home, known)
        write_bytes(home.folder / FILE, known.encode())
    identity = HomeIdentity(home.folder, known)
    mismatch = identity.mismatch()
    if mismatch is not None:
        raise mismatch
    return identity


def _read_or_make(folder: Path) -> str:
    """Return the id in the folder: a new database may be given an old home."""
    file = folder / FILE
    if not file.exists():
        write_bytes(file, str(uuid.uuid4()).encode())
    return file.read_text().strip()


def _read_or_make_in_store(home: Home) -> str:
    found = _id_in_store(home)
    if found is None:
        found = str(uuid.uuid4())
        obstore.put(open_object_store(home.store_url), FILE, found.encode(), mode="create")
    return found


def _require_store(home: Home, known: str) -> None:
    """Refuse a store of another database: it would hold none of the runs."""
    found = _id_in_store(home)
    if found != known:
        problem = f"is the store of another database ({FILE}: {found})" if found else f"has no {FILE}"
        cure = (
            "give the HGS_STORE_URL and HGS_RUN_STATE of the other machines; jobs of a shared home must be finished or "
            f"deleted before HGS_RUN_STATE=store, and then {known} written into that object"
        )
        raise InputError(f"HGS_STORE_URL {home.store_url}", problem, cure)


def _id_in_store(home: Home) -> str | None:
    try:
        return bytes(obstore.get(open_object_store(home.store_url), FILE).bytes()).decode().strip()
    except FileNotFoundError:
        return None
